//! A grid seen from one of its corners.

use beadwork_grid::{Cell, Region};

/// The grid of a region in coordinates (u, v) that start at one of its corners: u runs along the
/// lines of a pattern and v across them.
///
/// Patterns are generated only in these coordinates, so a pattern from another corner or along the
/// other axis is an exact mirror image or transposition, and needs no code of its own.
pub(crate) struct View {
    /// Number of cells along u.
    pub(crate) width: u32,
    /// Number of cells along v.
    pub(crate) height: u32,
    /// Whether u runs along y.
    is_transposed: bool,
    /// Whether the corner is on the right.
    is_from_right: bool,
    /// Whether the corner is at the bottom, where y is largest.
    is_from_bottom: bool,
    grid_width: u32,
    grid_height: u32,
}

impl View {
    /// A view from a corner: bit 0 of its number stands for the right, bit 1 for the bottom.
    pub(crate) fn new(region: &Region, is_transposed: bool, corner: u8) -> Self {
        let (grid_width, grid_height) = (region.width(), region.height());
        let (width, height) =
            if is_transposed { (grid_height, grid_width) } else { (grid_width, grid_height) };
        let (is_from_right, is_from_bottom) = (corner & 1 != 0, corner & 2 != 0);
        Self {
            width,
            height,
            is_transposed,
            is_from_right,
            is_from_bottom,
            grid_width,
            grid_height,
        }
    }

    /// The cell at (u, v).
    pub(crate) fn cell(&self, u: u32, v: u32) -> Cell {
        let (x, y) = if self.is_transposed { (v, u) } else { (u, v) };
        let x = if self.is_from_right { self.grid_width - 1 - x } else { x };
        let y = if self.is_from_bottom { self.grid_height - 1 - y } else { y };
        y * self.grid_width + x
    }
}
