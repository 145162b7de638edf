//! The voxels of a part counted in blocks, for steps on a coarser grid.

use crate::patch::Shape;

/// What the blocks of a part hold: numbers of voxels and of faces.
///
/// A block is `fold` voxels wide, deep and high: about a cube.
/// Blocks have a halo, as voxels have, and the same order.
#[derive(Clone, Debug)]
pub(crate) struct BlockGrid {
    /// Voxels of a block along x, y and z.
    pub(crate) coarsening: [usize; 3],
    pub(crate) shape: Shape,
    pub(crate) blocks: Vec<Block>,
}

/// What one block holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Block {
    /// Active voxels.
    pub(crate) voxels: u16,
    /// Pairs of active voxels with the next block along x, y and z.
    pub(crate) shared_faces: [u16; 3],
    /// Sides open to the air.
    pub(crate) sides: u16,
    /// Tops and bottoms open to the air.
    pub(crate) top_bottom: u16,
    /// Bottoms on the build plate.
    pub(crate) plate: u16,
}

/// Voxels of a block in a layer, along each axis.
const FOLD: usize = 2;

/// The tallest block, in layers: higher ones would blur what happens below the nozzle.
const TALLEST: usize = 8;

impl BlockGrid {
    /// Of a part whose voxels are so many times as wide as high.
    pub(crate) fn none(shape: Shape, width_by_height: f64) -> Self {
        let layers = (FOLD as f64 * width_by_height).round().clamp(1.0, TALLEST as f64);
        let coarsening = [FOLD, FOLD, layers as usize];
        let blocks = |axis: usize, voxels: usize| (voxels - 2).div_ceil(coarsening[axis]);
        let shape =
            Shape::around(blocks(0, shape.row), blocks(1, shape.planes), blocks(2, shape.rows));
        Self { coarsening, shape, blocks: vec![Block::default(); shape.len()] }
    }

    /// Layers of blocks that lie, at least in part, below a row of voxels; both count the halo.
    pub(crate) fn layers(&self, top: usize) -> usize {
        (top - 1).div_ceil(self.coarsening[2])
    }

    /// A block full of voxels amid others.
    pub(crate) fn whole(&self) -> Block {
        let [x, y, z] = self.coarsening.map(|coarsening| coarsening as u16);
        Block { voxels: x * y * z, shared_faces: [y * z, x * z, x * y], ..Block::default() }
    }

    /// From a block to the next along x, y and z.
    pub(crate) fn strides(&self) -> [usize; 3] {
        [1, self.shape.plane(), self.shape.row]
    }

    /// The block of a voxel: its index.
    /// Both count the halo.
    pub(crate) fn block(&self, at: [usize; 3]) -> usize {
        self.shape.index([0, 1, 2].map(|axis: usize| (at[axis] - 1) / self.coarsening[axis] + 1))
    }

    /// Counts a new voxel, given which of its neighbours are active: their axes, and whether they
    /// lie ahead of it.
    pub(crate) fn birth(
        &mut self,
        at: [usize; 3],
        neighbours: impl Iterator<Item = (usize, bool)>,
    ) {
        let own = self.block(at);
        let place = [0, 1, 2].map(|axis: usize| (at[axis] - 1) % self.coarsening[axis]);
        let strides = self.strides();
        let on_plate = u16::from(at[2] == 1);
        let block = &mut self.blocks[own];
        block.voxels += 1;
        block.sides += 4;
        block.top_bottom += 2 - on_plate;
        block.plate += on_plate;
        for (axis, ahead) in neighbours {
            let other = match ahead {
                true if place[axis] == self.coarsening[axis] - 1 => own + strides[axis],
                false if place[axis] == 0 => own - strides[axis],
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

    /// Counted anew, from what is active.
    fn counted(
        block_grid: &BlockGrid,
        size: [usize; 3],
        active: &dyn Fn([usize; 3]) -> bool,
    ) -> Vec<Block> {
        let mut blocks = vec![Block::default(); block_grid.blocks.len()];
        for at in places(size).filter(|&at| active(at)) {
            let own = block_grid.block(at);
            blocks[own].voxels += 1;
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut neighbour = at;
                    neighbour[axis] = neighbour[axis].wrapping_add_signed(step);
                    let other = block_grid.block(neighbour.map(|i| i.max(1)));
                    match (active(neighbour), axis, neighbour[2]) {
                        (true, ..) if step == 1 && other != own => {
                            blocks[own].shared_faces[axis] += 1
                        }
                        (true, ..) => {}
                        (false, 2, 0) => blocks[own].plate += 1,
                        (false, 2, _) => blocks[own].top_bottom += 1,
                        (false, ..) => blocks[own].sides += 1,
                    }
                }
            }
        }
        blocks
    }

    fn places(size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
        let [x, y, z] = size.map(|n| 1..=n);
        x.flat_map(move |x| {
            let (y, z) = (y.clone(), z.clone());
            y.flat_map(move |y| z.clone().map(move |z| [x, y, z]))
        })
    }

    #[test]
    fn births_count_what_a_recount_finds() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        for _ in 0..200 {
            let size = [0; 3].map(|_: usize| random.random_range(1..10_usize));
            let shape = Shape::around(size[0], size[1], size[2]);
            let mut block_grid = BlockGrid::none(shape, random.random_range(0.3..5.0));
            let mut active = vec![false; shape.len()];
            for at in places(size) {
                if random.random_bool(0.4) {
                    continue;
                }
                let steps = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
                let neighbours = steps.iter().enumerate().filter_map(|(i, step)| {
                    let other =
                        [0, 1, 2].map(|axis: usize| at[axis].wrapping_add_signed(step[axis]));
                    active[shape.index(other)].then_some((i / 2, i % 2 == 1))
                });
                block_grid.birth(at, neighbours);
                active[shape.index(at)] = true;
            }
            assert_eq!(
                block_grid.blocks,
                counted(&block_grid, size, &|at| active[shape.index(at)])
            );
        }
    }
}
