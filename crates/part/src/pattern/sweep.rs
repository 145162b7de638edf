//! Orders of a whole plane, as seen from the corner where they begin.

use beadwork_grid::{Cell, Region};

/// An order of a plane from its corner (0, 0), with lines along the first coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sweep {
    Zigzag,
    /// With the odd lines forwards: of a rectangle without its outline, the first one left.
    InnerZigzag,
    Raster,
    SpiralIn,
    /// Visited as [`Sweep::SpiralIn`] is: the caller reverses it.
    SpiralOut,
    Diagonal,
}

/// A plane as seen from one of its corners: u runs along the lines, v across them, both from 0 in
/// that corner.
///
/// All orders are made in this view, so that those from other corners and along the other axis are
/// exact mirror images.
pub(super) struct View {
    /// Number of places along u.
    pub(super) width: u32,
    /// Number of places along v.
    pub(super) height: u32,
    transposed: bool,
    from_right: bool,
    from_below: bool,
    plane_width: u32,
    plane_height: u32,
}

impl View {
    pub(super) fn new(region: &Region, transposed: bool, corner: u8) -> Self {
        let (plane_width, plane_height) = (region.width(), region.height());
        let (width, height) =
            if transposed { (plane_height, plane_width) } else { (plane_width, plane_height) };
        let (from_right, from_below) = (corner & 1 != 0, corner & 2 != 0);
        Self { width, height, transposed, from_right, from_below, plane_width, plane_height }
    }

    /// The cell at a place of the view.
    pub(super) fn cell(&self, u: u32, v: u32) -> Cell {
        let (x, y) = if self.transposed { (v, u) } else { (u, v) };
        let x = if self.from_right { self.plane_width - 1 - x } else { x };
        let y = if self.from_below { self.plane_height - 1 - y } else { y };
        y * self.plane_width + x
    }
}

/// Visits each place of a plane once.
pub(super) fn sweep(sweep: Sweep, width: u32, height: u32, visit: impl FnMut(u32, u32)) {
    match sweep {
        Sweep::Zigzag => zigzag(width, height, 0, visit),
        Sweep::InnerZigzag => zigzag(width, height, 1, visit),
        Sweep::Raster => raster(width, height, visit),
        Sweep::SpiralIn | Sweep::SpiralOut => spiral(width, height, visit),
        Sweep::Diagonal => diagonal(width, height, visit),
    }
}

fn raster(width: u32, height: u32, mut visit: impl FnMut(u32, u32)) {
    for v in 0..height {
        (0..width).for_each(|u| visit(u, v));
    }
}

/// The lines whose number leaves the remainder `forwards` by 2 run forwards, the others back.
fn zigzag(width: u32, height: u32, forwards: u32, mut visit: impl FnMut(u32, u32)) {
    for v in 0..height {
        if v % 2 == forwards {
            (0..width).for_each(|u| visit(u, v));
        } else {
            (0..width).rev().for_each(|u| visit(u, v));
        }
    }
}

/// Ring by ring; the innermost may be a single line.
fn spiral(width: u32, height: u32, mut visit: impl FnMut(u32, u32)) {
    for ring in 0..width.min(height).div_ceil(2) {
        let (right, bottom) = (width - 1 - ring, height - 1 - ring);
        (ring..=right).for_each(|u| visit(u, ring));
        (ring + 1..=bottom).for_each(|v| visit(right, v));
        if bottom > ring {
            (ring..right).rev().for_each(|u| visit(u, bottom));
        }
        if right > ring {
            (ring + 1..bottom).rev().for_each(|v| visit(ring, v));
        }
    }
}

/// Lines of equal u + v: the odd ones with rising v.
fn diagonal(width: u32, height: u32, mut visit: impl FnMut(u32, u32)) {
    for sum in 0..width + height - 1 {
        let lines = sum.saturating_sub(width - 1)..=sum.min(height - 1);
        if sum % 2 == 1 {
            lines.for_each(|v| visit(sum - v, v));
        } else {
            lines.rev().for_each(|v| visit(sum - v, v));
        }
    }
}
