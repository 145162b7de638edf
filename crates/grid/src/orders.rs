//! Orders in which to visit the cells of a grid, clipped to a region: zigzags and a spiral.
//!
//! On a rectangle each of them is one path.
//! On other regions consecutive cells may lie apart, since the cells between them are missing.

use crate::{Cell, Region};

/// Rows from top to bottom; even rows run from left to right, odd rows back.
pub(crate) fn row_zigzag(region: &Region) -> Vec<Cell> {
    let width = region.width();
    let row = |y: u32| {
        (0..width)
            .map(move |x| if y.is_multiple_of(2) { x } else { width - 1 - x })
            .map(move |x| (x, y))
    };
    clip(region, (0..region.height()).flat_map(row))
}

/// Columns from left to right; even columns run from top to bottom, odd columns back.
pub(crate) fn column_zigzag(region: &Region) -> Vec<Cell> {
    let height = region.height();
    let column = |x: u32| {
        (0..height)
            .map(move |y| if x.is_multiple_of(2) { y } else { height - 1 - y })
            .map(move |y| (x, y))
    };
    clip(region, (0..region.width()).flat_map(column))
}

/// Rings from the outside to the inside, each clockwise from its top-left cell.
pub(crate) fn spiral(region: &Region) -> Vec<Cell> {
    let (width, height) = (region.width(), region.height());
    let rings = width.min(height).div_ceil(2);
    let ring = |r: u32| {
        let (right, bottom) = (width - 1 - r, height - 1 - r);
        let top = (r..=right).map(move |x| (x, r));
        let down = (r + 1..=bottom).map(move |y| (right, y));
        // A ring that is one cell high or wide has no second side to return along.
        let back = (r..right).rev().filter(move |_| bottom > r).map(move |x| (x, bottom));
        let up = (r + 1..bottom).rev().filter(move |_| right > r).map(move |y| (r, y));
        top.chain(down).chain(back).chain(up)
    };
    clip(region, (0..rings).flat_map(ring))
}

/// The first two consecutive cells that are not neighbours; `None` if the order is one path.
pub(crate) fn first_jump(region: &Region, order: &[Cell]) -> Option<(Cell, Cell)> {
    let jump = order.windows(2).find(|step| !region.adjacent(step[0], step[1]))?;
    Some((jump[0], jump[1]))
}

fn clip(region: &Region, order: impl Iterator<Item = (u32, u32)>) -> Vec<Cell> {
    order.map(|(x, y)| region.cell(x, y)).filter(|&cell| region.contains(cell)).collect()
}
