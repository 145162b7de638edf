//! The outlines of a region, found by crack following.
//!
//! A **crack** is a side of a cell of the region whose other side is outside the region.
//! Walking along cracks with the region on the left and the outside on the right, every crack leads
//! to exactly one next crack, so all cracks form closed loops: one around each component of the
//! region, and one around each hole or group of holes that touch at corners.
//!
//! The state of a walk is the cell to the left of the current crack, A, and the direction, here to
//! the right.
//! The next crack depends on B, the cell ahead, and D, the cell to the right of B:
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
//! At an outer corner the walk stays in A and turns left; on a straight stretch it goes on to B; at
//! an inner corner it passes B, enters D and turns right.
//! The visited cells are exactly those with one of their eight neighbours outside: at an inner
//! corner, B touches the outside only diagonally.

use beadwork_grid::{Cell, Region};

use super::view::View;

/// Coordinates (u, v) in a view.
type Position = (u32, u32);

/// Steps along u and v in the four directions; with v down, each direction is a right turn from the
/// one before.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// All cells with one of their eight neighbours outside, outline after outline, each cell where it
/// comes first.
///
/// Every outline starts at its cell closest to the corner of the view, and outlines are sorted by
/// that distance.
pub(super) fn outlines(region: &Region, view: &View) -> Vec<Cell> {
    // Squared distance from the corner; ties are broken by the line.
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

/// Each outline as a closed walk in unit steps or none; a walk may visit a cell several times.
fn walks(region: &Region, view: &View) -> Vec<Vec<Position>> {
    // For each cell one bit for each direction: whether the crack was followed that the cell has on
    // its right when looking in this direction.
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

/// The closed walk that has the crack to the right of `position`, seen in `direction`.
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
            // That holds even if another component touches this one diagonally at the corner.
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
