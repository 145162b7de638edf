//! Visiting orders of a grid: zigzags and the spiral, clipped to a region.

use crate::{Cell, Region};

/// The cells of the region in row zigzag order, whether or not they form one path.
pub(crate) fn row_zigzag(region: &Region) -> Vec<Cell> {
    let width = region.width();
    let row = |y: u32| {
        (0..width)
            .map(move |x| if y.is_multiple_of(2) { x } else { width - 1 - x })
            .map(move |x| (x, y))
    };
    clip(region, (0..region.height()).flat_map(row))
}

pub(crate) fn column_zigzag(region: &Region) -> Vec<Cell> {
    let height = region.height();
    let column = |x: u32| {
        (0..height)
            .map(move |y| if x.is_multiple_of(2) { y } else { height - 1 - y })
            .map(move |y| (x, y))
    };
    clip(region, (0..region.width()).flat_map(column))
}

pub(crate) fn spiral(region: &Region) -> Vec<Cell> {
    let (width, height) = (region.width(), region.height());
    let rings = width.min(height).div_ceil(2);
    let ring = |r: u32| {
        let (right, bottom) = (width - 1 - r, height - 1 - r);
        let top = (r..=right).map(move |x| (x, r));
        let down = (r + 1..=bottom).map(move |y| (right, y));
        // A ring one cell high or wide has no way back.
        let back = (r..right).rev().filter(move |_| bottom > r).map(move |x| (x, bottom));
        let up = (r + 1..bottom).rev().filter(move |_| right > r).map(move |y| (r, y));
        top.chain(down).chain(back).chain(up)
    };
    clip(region, (0..rings).flat_map(ring))
}

/// The first two consecutive cells that are not neighbours, if any.
pub(crate) fn first_jump(region: &Region, order: &[Cell]) -> Option<(Cell, Cell)> {
    let jump = order.windows(2).find(|step| !region.adjacent(step[0], step[1]))?;
    Some((jump[0], jump[1]))
}

fn clip(region: &Region, order: impl Iterator<Item = (u32, u32)>) -> Vec<Cell> {
    order.map(|(x, y)| region.cell(x, y)).filter(|&cell| region.contains(cell)).collect()
}
