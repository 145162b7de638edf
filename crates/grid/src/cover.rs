//! A start for any region: a cover by few paths, found by rotation and extension.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::start::row_zigzag;
use crate::{Cell, Path, Region, region_components};

/// A lower bound on the pieces of any cover: each connected component needs max(1, its colour imbalance).
///
/// Colour the cells like a chessboard. Neighbours differ in colour, so a path alternates and holds at most one more cell of
/// one colour than of the other; a component with d more cells of one colour therefore needs d paths. Linear in the cells.
pub fn piece_bound(region: &Region) -> u32 {
    let components = region_components(region);
    let mut surplus = vec![0_i32; components.count() as usize];
    for cell in region.cells() {
        let (x, y) = region.xy(cell);
        surplus[components.label(cell) as usize] += if (x + y) % 2 == 0 { 1 } else { -1 };
    }
    surplus.iter().map(|surplus| surplus.unsigned_abs().max(1)).sum()
}

/// A path in few pieces through any region; of one piece wherever the row zigzag is.
///
/// It cuts the row zigzag where it jumps. Then the end of some piece, drawn at random, takes a random neighbour for its next cell
/// (a *rotation*, after Pósa, "Hamiltonian circuits in random graphs", 1976): of its own piece, which turns the stretch
/// between them round and gives the piece a new end; inside another piece, which cuts that one and takes over the rest of it; or at
/// another piece's end, which joins the two. It stops at [`piece_bound`], or when the work done, in cells rewritten, exceeds a
/// fixed multiple of the region's. The number of pieces is small but not always the smallest. Deterministic.
pub fn cover(region: &Region) -> Path {
    let zigzag = row_zigzag(region);
    let mut cover = Cover::new(region, &zigzag);
    let bound = piece_bound(region);
    // Ends drift together like random walks, so small regions get quadratic work; large ones must stay within seconds.
    let cells = u64::from(region.cell_count());
    let mut work_left = (2_000 * cells).min(20_000_000 + 64 * cells);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut neighbours = Vec::with_capacity(4);
    while cover.pieces.len() as u32 > bound && work_left > 0 {
        let piece = rng.random_range(0..cover.pieces.len());
        if rng.random() {
            cover.turn(piece);
        }
        let end = *cover.pieces[piece].last().expect("a piece has cells");
        neighbours.clear();
        neighbours.extend(region.neighbours(end));
        let work = match neighbours.len() {
            0 => 1,
            count => cover.extend(piece, neighbours[rng.random_range(0..count)]),
        };
        work_left = work_left.saturating_sub(work);
    }
    Path::in_pieces(region, cover.into_order()).expect("the pieces hold every cell once")
}

/// Disjoint paths through all cells.
struct Cover {
    pieces: Vec<Vec<Cell>>,
    /// For each cell of the plane its piece and its index there.
    home: Vec<(u32, u32)>,
}

impl Cover {
    fn new(region: &Region, order: &[Cell]) -> Self {
        let pieces: Vec<Vec<Cell>> =
            order.chunk_by(|&a, &b| region.adjacent(a, b)).map(<[Cell]>::to_vec).collect();
        let mut cover = Self { pieces, home: vec![(0, 0); region.plane_len()] };
        for piece in 0..cover.pieces.len() {
            cover.settle(piece, 0..cover.pieces[piece].len());
        }
        cover
    }

    /// Turns a piece round, so that its other end is the last cell.
    fn turn(&mut self, piece: usize) {
        self.pieces[piece].reverse();
        self.settle(piece, 0..self.pieces[piece].len());
    }

    /// Links the last cell of a piece to a neighbour; gives the number of cells rewritten.
    fn extend(&mut self, piece: usize, to: Cell) -> u64 {
        let (other, index) = self.home[to as usize];
        let (other, index) = (other as usize, index as usize);
        if other == piece {
            let changed = index + 1..self.pieces[piece].len();
            self.pieces[piece][changed.clone()].reverse();
            return self.settle(piece, changed);
        }
        // Of the other piece, the longer part is taken over: long pieces have few ends in the way of their growth.
        let length = self.pieces[other].len();
        let mut taken = if index + 1 > length - index {
            let rest = self.pieces[other].split_off(index + 1);
            let mut taken = std::mem::replace(&mut self.pieces[other], rest);
            taken.reverse();
            taken
        } else {
            self.pieces[other].split_off(index)
        };
        let from = self.pieces[piece].len();
        self.pieces[piece].append(&mut taken);
        let mut work = self.settle(piece, from..self.pieces[piece].len());
        if self.pieces[other].is_empty() {
            self.pieces.swap_remove(other);
            if other < self.pieces.len() {
                work += self.settle(other, 0..self.pieces[other].len());
            }
        } else {
            work += self.settle(other, 0..self.pieces[other].len());
        }
        work
    }

    fn settle(&mut self, piece: usize, changed: Range<usize>) -> u64 {
        for index in changed.clone() {
            self.home[self.pieces[piece][index] as usize] = (piece as u32, index as u32);
        }
        changed.len() as u64 + 1
    }

    /// All pieces in one order, in the order of their topmost, leftmost cells, so that the lifts between them stay short.
    fn into_order(mut self) -> Vec<Cell> {
        self.pieces.sort_unstable_by_key(|piece| piece.iter().min().copied());
        self.pieces.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(side: u32) -> Region {
        let inside = |x: u32, y: u32| {
            let (dx, dy) = (2 * i64::from(x) + 1 - i64::from(side), 2 * i64::from(y) + 1 - i64::from(side));
            dx * dx + dy * dy <= i64::from(side) * i64::from(side)
        };
        Region::from_mask(side, side, (0..side * side).map(|cell| inside(cell % side, cell / side)).collect())
            .unwrap()
    }

    #[test]
    fn the_bound_counts_components_and_colours() {
        assert_eq!(piece_bound(&Region::rectangle(5, 5).unwrap()), 1);
        let plus = [false, true, false, true, true, true, false, true, false];
        assert_eq!(piece_bound(&Region::from_mask(3, 3, plus.to_vec()).unwrap()), 3);
        let corners = [true, false, true, false, false, false, true, false, true];
        assert_eq!(piece_bound(&Region::from_mask(3, 3, corners.to_vec()).unwrap()), 4);
    }

    #[test]
    fn discs_need_few_pieces() {
        for side in [4, 10, 21, 40] {
            let region = disc(side);
            let path = cover(&region);
            assert!(path.pieces() >= piece_bound(&region));
            assert!(path.pieces() <= piece_bound(&region) + 1, "side {side}: {} pieces", path.pieces());
        }
    }

    #[test]
    fn the_smallest_regions() {
        let plus = [false, true, false, true, true, true, false, true, false];
        assert_eq!(cover(&Region::from_mask(3, 3, plus.to_vec()).unwrap()).pieces(), 3);
        assert_eq!(cover(&Region::rectangle(1, 1).unwrap()).pieces(), 1);
        assert_eq!(cover(&Region::from_mask(2, 2, vec![true, false, false, true]).unwrap()).pieces(), 2);
    }
}
