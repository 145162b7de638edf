//! The outlines of a region, found by crack following.
//!
//! A **crack** is a side of a cell of the region whose other side is outside the region.
//! A walk follows cracks with the region on its left and the outside on its right.
//! Every crack has exactly one next crack and is the next crack of exactly one, so the cracks form
//! closed loops: one around each component of the region, and one around each hole or group of
//! holes that touch at corners.
//!
//! The state of a walk is a direction and a cell A, the cell to the left of the current crack.
//! The next crack depends on B, the cell ahead of A, and on D, the cell to the right of B. In these
//! pictures the direction is to the right, and a line is a crack:
//!
//! ```text
//!    A |             A   B           A   B
//!    --+             -------         --+
//!                                      | D
//!
//!    B outside:      D outside:      D inside:
//!    outer corner    straight        inner corner
//! ```
//!
//! At an outer corner the walk stays in A and turns left; on a straight stretch it moves to B; at
//! an inner corner it passes through B to D and turns right.
//! The visited cells are exactly those with one of their eight neighbours outside: at an inner
//! corner, B touches the outside only diagonally.

use beadwork_grid::{Cell, Region};

use super::view::View;

/// Coordinates (u, v) in a view.
type Position = (u32, u32);

/// Steps along u and v in the four directions; with v down, each direction is a right turn from the
/// one before.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// All cells that have one of their eight neighbours outside the region, one outline after another.
///
/// Each outline starts at its cell closest to the corner of the view, and outlines are sorted by
/// that distance.
/// A cell that is visited several times is listed only once, at its first visit.
pub(super) fn outlines(region: &Region, view: &View) -> Vec<Cell> {
    // Squared distance from the corner; ties are broken by the line, v.
    let distance = |&(u, v): &Position| (u * u + v * v, v);
    let mut walks = walks(region, view);
    for walk in &mut walks {
        let closest =
            (0..walk.len()).min_by_key(|&at| distance(&walk[at])).expect("a walk has a cell");
        walk.rotate_left(closest);
    }
    // The sort is stable: around a wall one cell wide, the outer outline was found before that of
    // the hole and stays before it.
    walks.sort_by_key(|walk| distance(&walk[0]));
    let mut is_taken = vec![false; region.grid_len()];
    let cells = walks.into_iter().flatten().map(|(u, v)| view.cell(u, v));
    cells.filter(|&cell| !std::mem::replace(&mut is_taken[cell as usize], true)).collect()
}

/// Each outline as a closed walk: consecutive cells are neighbours, or equal at an outer corner.
///
/// A walk may visit a cell several times.
fn walks(region: &Region, view: &View) -> Vec<Vec<Position>> {
    // One bit mask for each cell; bit d is set once the crack on the right of the cell, as seen in
    // direction d, has been followed.
    let mut followed = vec![0_u8; region.grid_len()];
    let mut walks = Vec::new();
    for v in 0..view.height {
        for u in 0..view.width {
            if !region.contains(view.cell(u, v)) {
                continue;
            }
            for direction in 0..4 {
                let is_crack = step(region, view, (u, v), right_of(direction)).is_none();
                if is_crack && followed[view.cell(u, v) as usize] & 1 << direction == 0 {
                    walks.push(walk(region, view, &mut followed, (u, v), direction));
                }
            }
        }
    }
    walks
}

/// The closed walk that starts at the crack on the right of `position`, as seen in `direction`.
fn walk(
    region: &Region,
    view: &View,
    followed: &mut [u8],
    mut position: Position,
    mut direction: usize,
) -> Vec<Position> {
    let mut walk = Vec::new();
    loop {
        let cracks = &mut followed[view.cell(position.0, position.1) as usize];
        if *cracks & 1 << direction != 0 {
            return walk;
        }
        *cracks |= 1 << direction;
        walk.push(position);
        let Some(ahead) = step(region, view, position, direction) else {
            // An outer corner: the next crack is the front side of the same cell.
            // That keeps components apart that touch only diagonally at this corner.
            direction = left_of(direction);
            continue;
        };
        position = ahead;
        if let Some(diagonal) = step(region, view, ahead, right_of(direction)) {
            // An inner corner: the next crack belongs to the cell diagonally ahead, and the cell
            // ahead is passed on the way.
            walk.push(ahead);
            position = diagonal;
            direction = right_of(direction);
        }
    }
}

fn right_of(direction: usize) -> usize {
    (direction + 1) % 4
}

fn left_of(direction: usize) -> usize {
    (direction + 3) % 4
}

/// The neighbour in a direction, if it belongs to the region.
fn step(region: &Region, view: &View, (u, v): Position, direction: usize) -> Option<Position> {
    let (du, dv) = STEPS[direction];
    let (u, v) = (u.checked_add_signed(du)?, v.checked_add_signed(dv)?);
    (u < view.width && v < view.height && region.contains(view.cell(u, v))).then_some((u, v))
}
