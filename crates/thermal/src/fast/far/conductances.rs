//! Conductances of the coarse heat equation between blocks.
//!
//! Blocks at the surface of a part may contain fewer voxels than others.
//! A block has the heat capacity of its voxels, and conducts to the next block through as many
//! faces as their voxels share (`block_grid.rs` counts both).

use crate::aligned::AlignedBuffer;
use crate::block_grid::{Block, BlockGrid};
use crate::coefficients::Coefficients;

use super::region::Region;

/// Mean thickness of a block along an axis, in voxels: the mean number of its voxels behind each of
/// the given number of faces.
fn thickness(block: &Block, faces: u16, axis: usize, block_grid: &BlockGrid) -> f32 {
    let max = block_grid.coarsening[axis] as f32;
    (f32::from(block.voxels) / f32::from(faces)).clamp(1.0, max)
}

/// Conductance between a block and the next along an axis, voxels/s: that of their shared faces,
/// divided by the distance between the blocks' centres.
/// A block that is partly filled is thinner, so its centre is closer.
fn link(
    block: &Block,
    next: &Block,
    axis: usize,
    block_grid: &BlockGrid,
    coefficients: &Coefficients,
) -> f32 {
    let faces = block.shared_faces[axis];
    if faces == 0 {
        return 0.0;
    }
    let distance = 0.5
        * (thickness(block, faces, axis, block_grid) + thickness(next, faces, axis, block_grid));
    f32::from(faces) * coefficients.conductance(axis) / distance
}

/// Coefficients of all blocks, as one array each.
///
/// Conductances are in voxels/s: times a difference of temperatures they are heat in K voxels/s.
#[derive(Debug, Default)]
pub(super) struct BlockConductances {
    /// To the next block along x, y and z.
    pub(super) links: [AlignedBuffer; 3],
    /// To plate and air, linearised.
    pub(super) losses: AlignedBuffer,
    /// 1 over the number of voxels; 0 for blocks without any.
    pub(super) inverse_voxels: AlignedBuffer,
    /// Upper bound on the decay rates of the coarse equation, 1/s, of all blocks so far.
    pub(super) max_rate: f32,
}

impl BlockConductances {
    /// Resets all coefficients to those of blocks without voxels.
    pub(super) fn reset(&mut self, len: usize) {
        let Self { links: [x, y, z], losses, inverse_voxels, max_rate } = self;
        for numbers in [x, y, z, losses, inverse_voxels] {
            numbers.reset(len);
        }
        *max_rate = 0.0;
    }

    /// Recomputes the coefficients of a region from the contents of its blocks and from their mean
    /// temperatures above the air.
    pub(super) fn update(
        &mut self,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        theta: &[f32],
    ) {
        let strides = block_grid.strides();
        let blocks = &block_grid.blocks;
        let link_at = |i: usize, axis: usize| {
            link(&blocks[i], &blocks[i + strides[axis]], axis, block_grid, coefficients)
        };
        let interior = block_grid.interior_block();
        // Most blocks are full and have full neighbours, so their coefficients are computed once.
        let interior_links =
            [0, 1, 2].map(|axis: usize| link(&interior, &interior, axis, block_grid, coefficients));
        let interior_inverse = 1.0 / f32::from(interior.voxels);
        // Gershgorin's bound, twice the sum of the six links of a block per voxel.
        let interior_rate = 4.0 * interior_links.iter().sum::<f32>() * interior_inverse;
        for line in region.lines(block_grid) {
            for i in line {
                let block = &blocks[i];
                if *block == interior
                    && strides.iter().all(|&stride| blocks[i + stride] == interior)
                {
                    (0..3).for_each(|axis| self.links[axis][i] = interior_links[axis]);
                    (self.inverse_voxels[i], self.losses[i]) = (interior_inverse, 0.0);
                    self.max_rate = self.max_rate.max(interior_rate);
                    continue;
                }
                if block.voxels == 0 {
                    (0..3).for_each(|axis| self.links[axis][i] = 0.0);
                    (self.inverse_voxels[i], self.losses[i]) = (0.0, 0.0);
                    continue;
                }
                (0..3).for_each(|axis| self.links[axis][i] = link_at(i, axis));
                self.inverse_voxels[i] = 1.0 / f32::from(block.voxels);
                // The plate is half the block's thickness away from its centre.
                let plate = if coefficients.plate_conducts && block.plate_faces > 0 {
                    2.0 * coefficients.vertical * f32::from(block.plate_faces)
                        / thickness(block, block.plate_faces, 2, block_grid)
                } else {
                    0.0
                };
                let (sides, top_bottom) = (f32::from(block.sides), f32::from(block.top_bottom));
                self.losses[i] =
                    plate + coefficients.surface_loss_slope(theta[i], sides, top_bottom);
            }
        }
        // A link is stored at the lower block of its pair, so those across the lower sides of the
        // region belong to blocks outside.
        for (axis, _, sheet) in region.sides(block_grid).filter(|&(_, side, _)| side == 0) {
            for i in sheet.blocks(block_grid).map(|i| i - strides[axis]) {
                self.links[axis][i] = link_at(i, axis);
            }
        }
        let other = |i: &usize| blocks[*i].voxels > 0 && blocks[*i] != interior;
        for i in region.blocks(block_grid).filter(other) {
            let out: f32 =
                (0..3).map(|axis| self.links[axis][i] + self.links[axis][i - strides[axis]]).sum();
            let rate = (2.0 * out + self.losses[i]) * self.inverse_voxels[i];
            self.max_rate = self.max_rate.max(rate);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::testing::{insulated, printed, random_region, random_state};
    use super::*;

    #[test]
    fn conductances_do_not_depend_on_the_region_that_is_updated() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        for i in 0..200 {
            let (state, coefficients) = if i % 4 == 0 {
                let coefficients = insulated();
                (printed([30, 12, 16], &coefficients, |_| Some(50.0)), coefficients)
            } else {
                random_state(&mut random)
            };
            let block_grid = state.occupancy.block_grid();
            let theta = vec![40.0; block_grid.shape.len()];
            let [mut whole, mut part] = [(); 2].map(|()| BlockConductances::default());
            whole.reset(block_grid.shape.len());
            part.reset(block_grid.shape.len());
            whole.update(Region::whole(block_grid, state.top), block_grid, &coefficients, &theta);
            let (region, _) = random_region(&mut random, &state);
            part.update(region, block_grid, &coefficients, &theta);
            for i in region.blocks(block_grid) {
                assert_eq!(whole.inverse_voxels[i].to_bits(), part.inverse_voxels[i].to_bits());
                assert_eq!(whole.losses[i].to_bits(), part.losses[i].to_bits());
                for (axis, stride) in block_grid.strides().into_iter().enumerate() {
                    let links = |conductances: &BlockConductances| {
                        [i, i - stride].map(|i| conductances.links[axis][i].to_bits())
                    };
                    assert_eq!(links(&whole), links(&part));
                }
            }
        }
    }
}
