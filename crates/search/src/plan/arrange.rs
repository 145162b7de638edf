//! The order of the pieces that no tool decides: always on to the nearest end.

use beadwork_grid::{Cell, Region};

/// Pieces to be printed one after the other.
pub(super) enum Group<'a> {
    /// In any order, from either end.
    Any(Vec<&'a [Cell]>),
    /// One piece in one direction.
    Fixed(&'a [Cell], bool),
}

/// The cells of all pieces, group by group, beginning near the cell `from` of the same plane.
///
/// Always on to the nearest end of a piece left in the group, in Euclidean distance: a short way, not the shortest. Quadratic in the pieces of a group.
pub(super) fn arrange(region: &Region, groups: Vec<Group<'_>>, from: Option<Cell>) -> Vec<Cell> {
    let mut order: Vec<Cell> = Vec::with_capacity(region.cell_count() as usize);
    let distance = |a: Cell, b: Cell| {
        let ((ax, ay), (bx, by)) = (region.xy(a), region.xy(b));
        u64::from(ax.abs_diff(bx)).pow(2) + u64::from(ay.abs_diff(by)).pow(2)
    };
    for group in groups {
        match group {
            Group::Fixed(piece, false) => order.extend(piece),
            Group::Fixed(piece, true) => order.extend(piece.iter().rev()),
            Group::Any(mut left) => {
                while !left.is_empty() {
                    let from = order.last().copied().or(from);
                    let away = |end: Cell| from.map_or(0, |from| distance(from, end));
                    let near = |piece: &[Cell]| away(piece[0]).min(away(piece[piece.len() - 1]));
                    let next = (0..left.len())
                        .min_by_key(|&at| (near(left[at]), at))
                        .expect("there are pieces left");
                    let piece = left.remove(next);
                    if away(piece[0]) <= away(piece[piece.len() - 1]) {
                        order.extend(piece);
                    } else {
                        order.extend(piece.iter().rev());
                    }
                }
            }
        }
    }
    order
}
