//! How differences between blocks even out.
//!
//! Blocks at the part's border may be filled in part: each has the heat capacity of its voxels, and
//! is linked to the next by as many faces as their voxels share (`block_grid.rs` counts them).

use crate::aligned::AlignedBuffer;
use crate::block_grid::{Block, BlockGrid};
use crate::coefficients::Coefficients;

use super::Region;

/// How far a block's voxels reach from a face that it shares with so many of them: in voxels.
fn reach(block: &Block, faces: u16, axis: usize, block_grid: &BlockGrid) -> f32 {
    (f32::from(block.voxels) / f32::from(faces)).clamp(1.0, block_grid.coarsening[axis] as f32)
}

/// The conductance between a block and the next along an axis, 1/s in voxels.
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
    let distance =
        0.5 * (reach(block, faces, axis, block_grid) + reach(next, faces, axis, block_grid));
    f32::from(faces) * coefficients.conductance(axis) / distance
}

/// Conductances of blocks.
#[derive(Debug, Default)]
pub(super) struct BlockConductances {
    /// To the next blocks along x, y and z, 1/s in voxels.
    pub(super) links: [AlignedBuffer; 3],
    /// To plate and air, 1/s in voxels.
    pub(super) losses: AlignedBuffer,
    /// 1 over the number of voxels; 0 for blocks without any.
    pub(super) share: AlignedBuffer,
    /// A bound on the rates at which differences between blocks die out, 1/s.
    pub(super) max_rate: f32,
}

impl BlockConductances {
    /// Of so many blocks without any voxels.
    pub(super) fn reset(&mut self, len: usize) {
        let Self { links: [x, y, z], losses, share, max_rate } = self;
        for numbers in [x, y, z, losses, share] {
            numbers.reset(len);
        }
        *max_rate = 0.0;
    }

    /// Takes the conductances of a region from what its blocks hold, and from their mean
    /// temperatures above the air.
    pub(super) fn weigh(
        &mut self,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        theta: &[f32],
    ) {
        let strides = block_grid.strides();
        let link_at = |i: usize, axis: usize| {
            link(
                &block_grid.blocks[i],
                &block_grid.blocks[i + strides[axis]],
                axis,
                block_grid,
                coefficients,
            )
        };
        let whole = block_grid.whole();
        // Most blocks are whole, and so are those around them.
        let inner =
            [0, 1, 2].map(|axis: usize| link(&whole, &whole, axis, block_grid, coefficients));
        let inner_share = 1.0 / f32::from(whole.voxels);
        let inner_fastest = 4.0 * inner.iter().sum::<f32>() * inner_share;
        for line in region.lines(block_grid) {
            for i in line {
                let block = &block_grid.blocks[i];
                if *block == whole
                    && strides.iter().all(|&stride| block_grid.blocks[i + stride] == whole)
                {
                    (0..3).for_each(|axis| self.links[axis][i] = inner[axis]);
                    (self.share[i], self.losses[i]) = (inner_share, 0.0);
                    self.max_rate = self.max_rate.max(inner_fastest);
                    continue;
                }
                if block.voxels == 0 {
                    (0..3).for_each(|axis| self.links[axis][i] = 0.0);
                    (self.share[i], self.losses[i]) = (0.0, 0.0);
                    continue;
                }
                (0..3).for_each(|axis| self.links[axis][i] = link_at(i, axis));
                self.share[i] = 1.0 / f32::from(block.voxels);
                let plate = if coefficients.plate_conducts && block.plate > 0 {
                    2.0 * coefficients.vertical * f32::from(block.plate)
                        / reach(block, block.plate, 2, block_grid)
                } else {
                    0.0
                };
                self.losses[i] = plate
                    + coefficients.surface_loss_slope(
                        theta[i],
                        f32::from(block.sides),
                        f32::from(block.top_bottom),
                    );
            }
        }
        for (axis, _, sheet) in region.sides(block_grid).filter(|&(_, side, _)| side == 0) {
            for i in sheet.blocks(block_grid).map(|i| i - strides[axis]) {
                self.links[axis][i] = link_at(i, axis);
            }
        }
        let part = |i: &usize| block_grid.blocks[*i].voxels > 0 && block_grid.blocks[*i] != whole;
        for i in region.blocks(block_grid).filter(part) {
            let out: f32 =
                (0..3).map(|axis| self.links[axis][i] + self.links[axis][i - strides[axis]]).sum();
            self.max_rate = self.max_rate.max((2.0 * out + self.losses[i]) * self.share[i]);
        }
    }
}
