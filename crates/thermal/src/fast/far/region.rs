//! Boxes of whole blocks.

use std::ops::Range;

use crate::block_grid::BlockGrid;
use crate::patch::Shape;

use super::super::window::Window;

/// A box of blocks, the halo counted; along x it begins and ends where cache lines of voxels do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    /// The first block along x, y and z.
    pub(crate) low: [usize; 3],
    /// Where it ends: one more than the last.
    pub(crate) high: [usize; 3],
}

/// Two blocks beside each other on both sides of a region's border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BorderPair {
    pub(super) axis: usize,
    pub(super) inside: usize,
    pub(super) outside: usize,
}

impl BorderPair {
    /// The first of the two blocks.
    pub(super) fn first(self) -> usize {
        self.inside.min(self.outside)
    }
}

impl Region {
    /// All blocks with a voxel below row `top`.
    pub(crate) fn whole(block_grid: &BlockGrid, top: usize) -> Self {
        let [x, y, z] = ends(block_grid);
        Self { low: [1; 3], high: [x, y, z.min(block_grid.layers(top) + 1)] }
    }

    /// All blocks of which something lies in a window.
    pub(crate) fn around(window: Window, block_grid: &BlockGrid) -> Self {
        let Shape { row, rows, planes } = window.shape;
        let ends = ends(block_grid);
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for (axis, size) in [row, planes, rows].into_iter().enumerate() {
            let (first, end) = (window.origin[axis], window.origin[axis] + size - 2);
            low[axis] = first / block_grid.coarsening[axis] + 1;
            high[axis] = (end.div_ceil(block_grid.coarsening[axis]) + 1).min(ends[axis]);
        }
        Self { low, high }
    }

    /// The window into a part whose inside is all these blocks' voxels.
    pub(crate) fn window(self, block_grid: &BlockGrid, part: Shape) -> Window {
        let ends = [part.row, part.planes, part.rows];
        let origin =
            [0, 1, 2].map(|axis: usize| (self.low[axis] - 1) * block_grid.coarsening[axis]);
        let end = [0, 1, 2].map(|axis: usize| {
            ((self.high[axis] - 1) * block_grid.coarsening[axis] + 2).min(ends[axis])
        });
        let [row, planes, rows] = [0, 1, 2].map(|axis: usize| end[axis] - origin[axis]);
        Window { origin, shape: Shape { row, rows, planes } }
    }

    /// With so many blocks more on each side, as far as there are any.
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

    /// The indices of the blocks of each row.
    pub(super) fn lines(self, block_grid: &BlockGrid) -> impl Iterator<Item = Range<usize>> {
        let (shape, [first, end]) = (block_grid.shape, [self.low[0], self.high[0]]);
        self.rows().map(move |(y, z)| shape.index([first, y, z])..shape.index([end, y, z]))
    }

    /// The indices of all blocks.
    pub(super) fn blocks(self, block_grid: &BlockGrid) -> impl Iterator<Item = usize> {
        self.lines(block_grid).flatten()
    }

    /// The sides beyond which there are more blocks, 0 the lower, 1 the upper one of an axis; each
    /// with the layer of the region's blocks on it.
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

    /// All pairs of blocks on both sides of the border, in an order of their own.
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

/// Where the blocks of a part end along x, y and z.
fn ends(block_grid: &BlockGrid) -> [usize; 3] {
    [block_grid.shape.row, block_grid.shape.planes, block_grid.shape.rows].map(|n| n - 1)
}
