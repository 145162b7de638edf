//! Orders pieces for short travel, by the nearest-neighbour rule, where tool changes do not fix
//! their order.

use beadwork_grid::{Cell, Region};
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Pieces that are printed one after the other, with no piece of another group between.
pub(super) enum Group<'a> {
    /// Any number of pieces, in any order, each from either end.
    Any(Vec<&'a [Cell]>),
    /// A single piece, and whether it is reversed.
    Fixed(&'a [Cell], bool),
}

/// An end of a piece: its coordinates, the number of the piece, and whether it is the last cell.
type End = GeomWithData<[i64; 2], (usize, bool)>;

/// The cells of all pieces, group by group, starting near the cell `from`, or near the first cell
/// of the grid.
///
/// The next piece of a group is the one with the nearest end, in Euclidean distance.
/// This nearest-neighbour rule keeps travel short, though not the shortest.
/// About O(p log p) for p pieces.
pub(super) fn arrange(region: &Region, groups: Vec<Group<'_>>, from: Option<Cell>) -> Vec<Cell> {
    let mut order: Vec<Cell> = Vec::with_capacity(region.cell_count() as usize);
    let position = |cell: Cell| {
        let (x, y) = region.xy(cell);
        [i64::from(x), i64::from(y)]
    };
    for group in groups {
        match group {
            Group::Fixed(piece, false) => order.extend(piece),
            Group::Fixed(piece, true) => order.extend(piece.iter().rev()),
            Group::Any(pieces) => {
                let end = |piece: usize, is_last: bool| {
                    let cells = pieces[piece];
                    End::new(
                        position(cells[if is_last { cells.len() - 1 } else { 0 }]),
                        (piece, is_last),
                    )
                };
                let ends =
                    (0..pieces.len()).flat_map(|piece| [end(piece, false), end(piece, true)]);
                let mut remaining = RTree::bulk_load(ends.collect());
                loop {
                    let here = position(order.last().copied().or(from).unwrap_or_default());
                    let Some(nearest) = remaining.pop_nearest_neighbor(here) else { break };
                    let (piece, is_last) = nearest.data;
                    remaining.remove(&end(piece, !is_last));
                    if is_last {
                        order.extend(pieces[piece].iter().rev());
                    } else {
                        order.extend(pieces[piece]);
                    }
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Checks each step against all remaining pieces.
    fn is_nearest_first(region: &Region, pieces: &[&[Cell]], order: &[Cell], from: Cell) -> bool {
        let distance = |a: Cell, b: Cell| {
            let ((ax, ay), (bx, by)) = (region.xy(a), region.xy(b));
            ax.abs_diff(bx).pow(2) + ay.abs_diff(by).pow(2)
        };
        let mut remaining = pieces.to_vec();
        let (mut at, mut here) = (0, from);
        while at < order.len() {
            let begins =
                |piece: &&[Cell]| piece[0] == order[at] || piece[piece.len() - 1] == order[at];
            let Some(number) = remaining.iter().position(begins) else { return false };
            let near = remaining.iter().flat_map(|piece| [piece[0], piece[piece.len() - 1]]);
            if near.map(|end| distance(here, end)).min() != Some(distance(here, order[at])) {
                return false;
            }
            at += remaining.remove(number).len();
            here = order[at - 1];
        }
        remaining.is_empty()
    }

    #[test]
    fn the_nearest_end_comes_first() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let region = Region::rectangle(30, 30).unwrap();
        for _ in 0..300 {
            // Pieces are parts of rows, and no two share a cell.
            let mut cells: Vec<Cell> = Vec::new();
            let mut lengths = Vec::new();
            for row in 0..10 {
                let mut x = rng.random_range(0..5);
                while x < 30 {
                    let length = rng.random_range(1..=(30 - x).min(6));
                    cells.extend((x..x + length).map(|x| region.cell(x, 3 * row)));
                    lengths.push(length as usize);
                    x += length + rng.random_range(1..4);
                }
            }
            let mut rest = &cells[..];
            let pieces: Vec<&[Cell]> = lengths
                .iter()
                .map(|&length| {
                    let (piece, other) = rest.split_at(length);
                    rest = other;
                    piece
                })
                .collect();
            let from = rng.random_range(0..900);
            let order = arrange(&region, vec![Group::Any(pieces.clone())], Some(from));
            assert!(is_nearest_first(&region, &pieces, &order, from));
        }
    }
}
