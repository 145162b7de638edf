//! The block grid: counts of voxels and faces in blocks, for the coarse far field.
//!
//! Steps far from the nozzle work on a coarser grid (`fast/far`), whose cells are blocks of voxels.
//! The coarse equation needs a few integers per block: how much heat it can store, and through how
//! many faces it exchanges heat with the next blocks, the build plate and the air.
//! They are kept up to date at each birth, in constant time.

use crate::shape::Shape;

/// The blocks of a part.
///
/// The blocks are arranged like voxels in a [`crate::patch::Patch`]: the same index order, and a
/// halo of one block on each side.
/// The last blocks along an axis may reach beyond the part; they contain fewer voxels.
#[derive(Clone, Debug)]
pub(crate) struct BlockGrid {
    /// Coarsening factors: voxels in a full block along x, y and z.
    pub(crate) coarsening: [usize; 3],
    pub(crate) shape: Shape,
    /// Contents of each block, by flat index.
    pub(crate) blocks: Vec<Block>,
}

/// Contents of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Block {
    /// Number of active voxels.
    pub(crate) voxels: u16,
    /// Faces between two active voxels, one in this block and one in the next along x, y and z.
    pub(crate) shared_faces: [u16; 3],
    /// Sides of voxels exposed to the air.
    pub(crate) sides: u16,
    /// Top and bottom faces of voxels exposed to the air.
    pub(crate) top_bottom: u16,
    /// Bottom faces of voxels on the build plate.
    pub(crate) plate_faces: u16,
}

/// Coarsening factor along x and y.
const LATERAL_COARSENING: usize = 2;

/// Largest coarsening factor along z.
/// Taller blocks would blur the steep vertical profile below the nozzle.
const MAX_VERTICAL_COARSENING: usize = 8;

impl BlockGrid {
    /// The blocks of a part of which nothing is printed yet, given the shape of its patch and the
    /// width of a voxel divided by its height.
    ///
    /// Blocks are as close to cubes as whole voxels allow.
    pub(crate) fn unprinted(shape: Shape, width_by_height: f64) -> Self {
        let layers = (LATERAL_COARSENING as f64 * width_by_height)
            .round()
            .clamp(1.0, MAX_VERTICAL_COARSENING as f64);
        let coarsening = [LATERAL_COARSENING, LATERAL_COARSENING, layers as usize];
        let blocks = |axis: usize| (shape.sizes()[axis] - 2).div_ceil(coarsening[axis]);
        let shape = Shape::with_halo(blocks(0), blocks(1), blocks(2));
        Self { coarsening, shape, blocks: vec![Block::default(); shape.len()] }
    }

    /// Number of layers of blocks that contain a row of voxels below row `top`, which counts the
    /// halo.
    pub(crate) fn layers_below(&self, top: usize) -> usize {
        (top - 1).div_ceil(self.coarsening[2])
    }

    /// A block full of voxels whose neighbours are full as well.
    pub(crate) fn interior_block(&self) -> Block {
        let [x, y, z] = self.coarsening.map(|factor| factor as u16);
        Block { voxels: x * y * z, shared_faces: [y * z, x * z, x * y], ..Block::default() }
    }

    /// Distances in the flat index from a block to the next along x, y and z.
    pub(crate) fn strides(&self) -> [usize; 3] {
        [1, self.shape.plane_len(), self.shape.row_len]
    }

    /// Flat index of the block that contains a voxel, given by its position with the halo counted.
    pub(crate) fn block_of(&self, position: [usize; 3]) -> usize {
        // Voxel 1 is the first behind the halo, and belongs to block 1.
        let block = [0, 1, 2].map(|axis: usize| (position[axis] - 1) / self.coarsening[axis] + 1);
        self.shape.index(block)
    }

    /// Counts a new voxel.
    ///
    /// `neighbours` lists its active neighbours, each as its axis and whether it lies on the side
    /// of larger coordinates.
    pub(crate) fn birth(
        &mut self,
        position: [usize; 3],
        neighbours: impl Iterator<Item = (usize, bool)>,
    ) {
        let own = self.block_of(position);
        let within = [0, 1, 2].map(|axis: usize| (position[axis] - 1) % self.coarsening[axis]);
        let strides = self.strides();
        let on_plate = u16::from(position[2] == 1);
        // Counted first as if all faces were exposed ...
        let block = &mut self.blocks[own];
        block.voxels += 1;
        block.sides += 4;
        block.top_bottom += 2 - on_plate;
        block.plate_faces += on_plate;
        // ... then each active neighbour covers two of them: one of each voxel.
        for (axis, ahead) in neighbours {
            let other = match ahead {
                true if within[axis] == self.coarsening[axis] - 1 => own + strides[axis],
                false if within[axis] == 0 => own - strides[axis],
                _ => own,
            };
            for index in [own, other] {
                let block = &mut self.blocks[index];
                if axis == 2 {
                    block.top_bottom -= 1;
                } else {
                    block.sides -= 1;
                }
            }
            if own != other {
                self.blocks[own.min(other)].shared_faces[axis] += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Counts all blocks from scratch.
    fn counted(
        block_grid: &BlockGrid,
        size: [usize; 3],
        active: &dyn Fn([usize; 3]) -> bool,
    ) -> Vec<Block> {
        let mut blocks = vec![Block::default(); block_grid.blocks.len()];
        for position in positions(size).filter(|&position| active(position)) {
            let own = block_grid.block_of(position);
            blocks[own].voxels += 1;
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut neighbour = position;
                    neighbour[axis] = neighbour[axis].wrapping_add_signed(step);
                    let other = block_grid.block_of(neighbour.map(|i| i.max(1)));
                    match (active(neighbour), axis, neighbour[2]) {
                        (true, ..) if step == 1 && other != own => {
                            blocks[own].shared_faces[axis] += 1;
                        }
                        (true, ..) => {}
                        (false, 2, 0) => blocks[own].plate_faces += 1,
                        (false, 2, _) => blocks[own].top_bottom += 1,
                        (false, ..) => blocks[own].sides += 1,
                    }
                }
            }
        }
        blocks
    }

    fn positions(size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
        let [x, y, z] = size.map(|n| 1..=n);
        x.flat_map(move |x| {
            let (y, z) = (y.clone(), z.clone());
            y.flat_map(move |y| z.clone().map(move |z| [x, y, z]))
        })
    }

    #[test]
    fn birth_updates_equal_a_full_recount() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        for _ in 0..200 {
            let size = [0; 3].map(|_: usize| random.random_range(1..10_usize));
            let shape = Shape::with_halo(size[0], size[1], size[2]);
            let mut block_grid = BlockGrid::unprinted(shape, random.random_range(0.3..5.0));
            let mut active = vec![false; shape.len()];
            for position in positions(size) {
                if random.random_bool(0.4) {
                    continue;
                }
                let steps = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
                let neighbours = steps.iter().enumerate().filter_map(|(i, step)| {
                    let other =
                        [0, 1, 2].map(|axis: usize| position[axis].wrapping_add_signed(step[axis]));
                    active[shape.index(other)].then_some((i / 2, i % 2 == 1))
                });
                block_grid.birth(position, neighbours);
                active[shape.index(position)] = true;
            }
            assert_eq!(
                block_grid.blocks,
                counted(&block_grid, size, &|position| active[shape.index(position)])
            );
        }
    }
}
