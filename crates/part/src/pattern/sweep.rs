//! Orders of all cells of a grid, in the coordinates of a [`View`](super::view::View): u along the
//! lines, v across them, from corner (0, 0).

/// An order of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sweep {
    /// Lines along u, back and forth; even lines run forwards.
    Zigzag,
    /// As [`Sweep::Zigzag`], but odd lines run forwards.
    /// It fills the cells that outlines leave: in a rectangle these begin with line 1.
    InnerZigzag,
    /// Lines along u, all forwards.
    Raster,
    /// Rings from the outside inwards.
    SpiralIn,
    /// Rings from the inside outwards; visited as [`Sweep::SpiralIn`], and the caller reverses the
    /// order.
    SpiralOut,
    /// Diagonals, back and forth.
    Diagonal,
}

impl Sweep {
    /// Calls `visit` once with each (u, v) of a grid.
    pub(super) fn for_each(self, width: u32, height: u32, visit: impl FnMut(u32, u32)) {
        match self {
            Self::Zigzag => zigzag(width, height, 0, visit),
            Self::InnerZigzag => zigzag(width, height, 1, visit),
            Self::Raster => raster(width, height, visit),
            Self::SpiralIn | Self::SpiralOut => spiral(width, height, visit),
            Self::Diagonal => diagonal(width, height, visit),
        }
    }
}

fn raster(width: u32, height: u32, mut visit: impl FnMut(u32, u32)) {
    for v in 0..height {
        (0..width).for_each(|u| visit(u, v));
    }
}

/// Lines with v % 2 equal to `forwards` run forwards, the others backwards.
fn zigzag(width: u32, height: u32, forwards: u32, mut visit: impl FnMut(u32, u32)) {
    for v in 0..height {
        if v % 2 == forwards {
            (0..width).for_each(|u| visit(u, v));
        } else {
            (0..width).rev().for_each(|u| visit(u, v));
        }
    }
}

/// Ring by ring, each one along its top, right, bottom and left side.
/// The innermost ring may be a single line, which must not be visited once forwards and once
/// backwards.
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

/// Diagonals of equal u + v; v increases along the odd ones.
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
