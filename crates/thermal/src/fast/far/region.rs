//! Regions: boxes of whole blocks.

use std::ops::Range;

use crate::block_grid::BlockGrid;
use crate::shape::Shape;

use super::super::window::Window;

/// A box of blocks, given by their positions in the block grid with its halo counted.
///
/// Along x it begins and ends at cache lines of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    /// First block along x, y and z.
    pub(crate) low: [usize; 3],
    /// One more than the last block along x, y and z.
    pub(crate) high: [usize; 3],
}

/// Two neighbouring blocks on both sides of a region's border, as flat indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BorderPair {
    pub(super) axis: usize,
    pub(super) inside: usize,
    pub(super) outside: usize,
}

impl BorderPair {
    /// The block with the smaller coordinate, at whose index links and shared faces of the pair are
    /// stored.
    pub(super) fn lower(self) -> usize {
        self.inside.min(self.outside)
    }
}

impl Region {
    /// The region of all blocks with a voxel below row `top`.
    pub(super) fn whole(block_grid: &BlockGrid, top: usize) -> Self {
        let [x, y, z] = ends(block_grid);
        Self { low: [1; 3], high: [x, y, z.min(block_grid.layers_below(top) + 1)] }
    }

    /// The region of all blocks that lie, at least in part, within a window, its halo excluded.
    pub(crate) fn around(window: Window, block_grid: &BlockGrid) -> Self {
        let (sizes, ends) = (window.shape.sizes(), ends(block_grid));
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let factor = block_grid.coarsening[axis];
            // The first voxel inside is origin + 1; voxel v belongs to block (v - 1) / factor + 1.
            let (origin, last) = (window.origin[axis], window.origin[axis] + sizes[axis] - 2);
            low[axis] = origin / factor + 1;
            high[axis] = (last.div_ceil(factor) + 1).min(ends[axis]);
        }
        Self { low, high }
    }

    /// The window whose inside is all voxels of these blocks, in a part of the given shape.
    pub(crate) fn window(self, block_grid: &BlockGrid, part: Shape) -> Window {
        let (factors, part_ends) = (block_grid.coarsening, part.sizes());
        // One voxel of halo before the first voxel, (low - 1) factor + 1, and one behind the last.
        let origin = [0, 1, 2].map(|axis: usize| (self.low[axis] - 1) * factors[axis]);
        let end = [0, 1, 2]
            .map(|axis: usize| ((self.high[axis] - 1) * factors[axis] + 2).min(part_ends[axis]));
        let [row_len, planes, rows] = [0, 1, 2].map(|axis: usize| end[axis] - origin[axis]);
        Window { origin, shape: Shape { row_len, rows, planes } }
    }

    /// The region grown by some blocks on each side, as far as the block grid goes.
    pub(super) fn grown(self, by: usize, block_grid: &BlockGrid) -> Self {
        let ends = ends(block_grid);
        let low = self.low.map(|low| low.saturating_sub(by).max(1));
        let high = [0, 1, 2].map(|axis: usize| (self.high[axis] + by).min(ends[axis]));
        Self { low, high }
    }

    /// y and z of each row of blocks.
    pub(super) fn rows(self) -> impl Iterator<Item = (usize, usize)> {
        let [_, y, z] = [0, 1, 2].map(|axis: usize| self.low[axis]..self.high[axis]);
        y.flat_map(move |y| z.clone().map(move |z| (y, z)))
    }

    /// The range of flat indices of each row of blocks.
    pub(super) fn lines(self, block_grid: &BlockGrid) -> impl Iterator<Item = Range<usize>> {
        let (shape, [first, end]) = (block_grid.shape, [self.low[0], self.high[0]]);
        self.rows().map(move |(y, z)| shape.index([first, y, z])..shape.index([end, y, z]))
    }

    /// The flat indices of all blocks.
    pub(super) fn blocks(self, block_grid: &BlockGrid) -> impl Iterator<Item = usize> {
        self.lines(block_grid).flatten()
    }

    /// The sides of the region beyond which there are more blocks: axis, 0 for the lower or 1 for
    /// the upper side, and the outermost blocks of the region on that side.
    pub(super) fn sides(
        self,
        block_grid: &BlockGrid,
    ) -> impl Iterator<Item = (usize, usize, Self)> {
        let ends = ends(block_grid);
        (0..6).map(|i| (i / 2, i % 2)).filter_map(move |(axis, side)| {
            let mut sheet = self;
            let open = if side == 0 {
                sheet.high[axis] = self.low[axis] + 1;
                self.low[axis] > 1
            } else {
                sheet.low[axis] = self.high[axis] - 1;
                self.high[axis] < ends[axis]
            };
            open.then_some((axis, side, sheet))
        })
    }

    /// All pairs of neighbouring blocks across the border, one side after the other in the order of
    /// [`Region::sides`], and on each side in the order of [`Region::blocks`].
    pub(crate) fn border(self, block_grid: &BlockGrid) -> impl Iterator<Item = BorderPair> {
        let strides = block_grid.strides();
        self.sides(block_grid).flat_map(move |(axis, side, sheet)| {
            let stride = strides[axis];
            sheet.blocks(block_grid).map(move |inside| {
                let outside = if side == 0 { inside - stride } else { inside + stride };
                BorderPair { axis, inside, outside }
            })
        })
    }
}

/// One more than the last block of a part along x, y and z.
fn ends(block_grid: &BlockGrid) -> [usize; 3] {
    block_grid.shape.sizes().map(|size| size - 1)
}
