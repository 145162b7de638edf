//! The outlines of a region, walked around along the cracks between its cells and what lies
//! outside.
//!
//! A **crack** is a side of a cell of the region that has no cell of the region on its other side.
//! Followed with the region on the left hand, cracks close in loops, each crack in one of them;
//! where two loops meet at a corner, each turns left.
//! The cells on the left, and those passed at inner corners, are the outline.

use beadwork_grid::{Cell, Region};

use super::sweep::View;

/// A place in a view.
type Place = (u32, u32);

/// Steps along u and v in the four directions, each a right turn from the one before with v down.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// All cells with one of their eight neighbours outside, outline by outline, each where it is first
/// met.
pub(super) fn outlines(region: &Region, view: &View) -> Vec<Cell> {
    let nearness = |&(u, v): &Place| (u * u + v * v, v);
    let mut walks = walks(region, view);
    for walk in &mut walks {
        let nearest =
            (0..walk.len()).min_by_key(|&at| nearness(&walk[at])).expect("a walk has a place");
        walk.rotate_left(nearest);
    }
    // Stable: of a wall one cell wide, the outer outline was found before that of the hole, and
    // stays so.
    walks.sort_by_key(|walk| nearness(&walk[0]));
    let mut taken = vec![false; region.grid_len()];
    let cells = walks.into_iter().flatten().map(|(u, v)| view.cell(u, v));
    cells.filter(|&cell| !std::mem::replace(&mut taken[cell as usize], true)).collect()
}

/// Each outline as a closed walk in unit steps or none; places may come back.
fn walks(region: &Region, view: &View) -> Vec<Vec<Place>> {
    // For each cell, one bit for each direction in which the crack on that direction's right was
    // walked.
    let mut walked = vec![0_u8; region.grid_len()];
    let mut walks = Vec::new();
    for v in 0..view.height {
        for u in 0..view.width {
            if !region.contains(view.cell(u, v)) {
                continue;
            }
            for direction in 0..4 {
                let is_crack = step(region, view, (u, v), right_of(direction)).is_none();
                if is_crack && walked[view.cell(u, v) as usize] & 1 << direction == 0 {
                    walks.push(walk(region, view, &mut walked, (u, v), direction));
                }
            }
        }
    }
    walks
}

/// The walk of which `place`, heading in `direction`, is one crack.
fn walk(
    region: &Region,
    view: &View,
    walked: &mut [u8],
    mut place: Place,
    mut direction: usize,
) -> Vec<Place> {
    let mut walk = Vec::new();
    loop {
        let mark = &mut walked[view.cell(place.0, place.1) as usize];
        if *mark & 1 << direction != 0 {
            return walk;
        }
        *mark |= 1 << direction;
        walk.push(place);
        // An outer corner keeps the cell, also where another part of the region touches it from
        // across.
        let Some(ahead) = step(region, view, place, direction) else {
            direction = left_of(direction);
            continue;
        };
        place = ahead;
        if let Some(beside) = step(region, view, ahead, right_of(direction)) {
            // An inner corner: the cell ahead sees the outside across its own corner only.
            walk.push(ahead);
            place = beside;
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

/// The next place in a direction, if it belongs to the region.
fn step(region: &Region, view: &View, (u, v): Place, direction: usize) -> Option<Place> {
    let (du, dv) = STEPS[direction];
    let (u, v) = (u.checked_add_signed(du)?, v.checked_add_signed(dv)?);
    (u < view.width && v < view.height && region.contains(view.cell(u, v))).then_some((u, v))
}
