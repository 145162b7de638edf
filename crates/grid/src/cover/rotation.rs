//! Rotation and extension of paths, after Pósa, "Hamiltonian circuits in random graphs" (1976).
//!
//! Several disjoint paths cover all cells.
//! Draw at random an end of one of them and a neighbour of that end, and link the two.
//! What follows depends on where the neighbour lies:
//!
//! ```text
//!   on the same path:             a ~~~ n m ~~~ end       link end-n instead of n-m
//!   rotation                      a ~~~ n end ~~~ m       the path has the new end m
//!
//!   inside another path:          b ~~~ m n ~~~ c         link end-n instead of m-n
//!   extension                     a ~~~ end n ~~~ c       and   b ~~~ m, or the same
//!                                                         with b and c exchanged
//!
//!   at the end of another path:   n ~~~ c                 nothing to cut:
//!   joining                       a ~~~ end n ~~~ c       one path fewer
//! ```
//!
//! None of these steps increases the number of paths.
//! So the ends move over the region like random walks, and when two of them become neighbours, a
//! step may join them.

use std::ops::Range;

use beadwork_base::{Control, Interrupted};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Cell, Region};

/// Cells rewritten between two polls of the control: about a millisecond.
const POLL_INTERVAL: u64 = 1 << 16;

/// Number of cells that [`Pieces::wander`] may rewrite.
///
/// The ends approach each other like random walks, which takes about as many steps as the region
/// has cells, and each step rewrites a part of the cells.
/// Small regions get this quadratic work; on large ones, the limit keeps it to seconds.
pub(super) fn work_limit(region: &Region) -> u64 {
    let cells = u64::from(region.cell_count());
    (6_000 * cells).min(60_000_000 + 64 * cells)
}

/// Disjoint paths through all cells of a region.
pub(super) struct Pieces {
    /// The cells of each path, in order.
    pub(super) pieces: Vec<Vec<Cell>>,
    /// For each cell of the grid, the number of its piece and its index there.
    pub(super) home: Vec<(u32, u32)>,
}

impl Pieces {
    pub(super) fn new(region: &Region, pieces: Vec<Vec<Cell>>) -> Self {
        let mut all = Self { pieces, home: vec![(0, 0); region.grid_len()] };
        for piece in 0..all.pieces.len() {
            all.update_homes(piece, 0..all.pieces[piece].len());
        }
        all
    }

    /// Makes random rotations and extensions until at most `target` pieces are left or the work
    /// limit is reached.
    /// The random numbers are always the same, so the result is deterministic.
    pub(super) fn wander(
        &mut self,
        region: &Region,
        target: u32,
        control: &Control<'_>,
    ) -> Result<(), Interrupted> {
        let limit = work_limit(region);
        let cells = region.cell_count() as usize;
        let (mut work_left, mut poll_at) = (limit, limit);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut neighbours = Vec::with_capacity(4);
        while self.pieces.len() as u32 > target && work_left > 0 {
            if work_left <= poll_at {
                control.check()?;
                control.report(cells + (limit - work_left) as usize, cells + limit as usize);
                poll_at = work_left.saturating_sub(POLL_INTERVAL);
            }
            let piece = rng.random_range(0..self.pieces.len());
            // Links are added at the last cell of a piece, so reverse it to use the other end.
            if rng.random() {
                self.pieces[piece].reverse();
                let work = self.update_homes(piece, 0..self.pieces[piece].len());
                work_left = work_left.saturating_sub(work);
            }
            let end = *self.pieces[piece].last().expect("a piece has cells");
            neighbours.clear();
            neighbours.extend(region.neighbours(end));
            let work = match neighbours.len() {
                0 => 1,
                count => self.link(piece, neighbours[rng.random_range(0..count)]),
            };
            work_left = work_left.saturating_sub(work);
        }
        Ok(())
    }

    /// Links the last cell of a piece to a neighbour: a rotation, an extension or a joining.
    /// Returns the number of cells rewritten.
    pub(super) fn link(&mut self, piece: usize, neighbour: Cell) -> u64 {
        let (other, index) = self.home[neighbour as usize];
        let (other, index) = (other as usize, index as usize);
        if other == piece {
            // Rotation: reverse all cells after the neighbour.
            let changed = index + 1..self.pieces[piece].len();
            self.pieces[piece][changed.clone()].reverse();
            return self.update_homes(piece, changed);
        }
        // The other piece can be cut before or after the neighbour.
        // Take over the longer part: a few long pieces obstruct each other less than many short
        // ones.
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
        let mut work = self.update_homes(piece, from..self.pieces[piece].len());
        if self.pieces[other].is_empty() {
            // The last piece gets the number of the removed one.
            self.pieces.swap_remove(other);
        }
        if other < self.pieces.len() {
            work += self.update_homes(other, 0..self.pieces[other].len());
        }
        work
    }

    /// Updates the homes of some cells of a piece; returns their number plus one.
    fn update_homes(&mut self, piece: usize, changed: Range<usize>) -> u64 {
        for index in changed.clone() {
            self.home[self.pieces[piece][index] as usize] = (piece as u32, index as u32);
        }
        changed.len() as u64 + 1
    }

    /// All pieces as one order, sorted by their lowest cells so that the travel between consecutive
    /// pieces tends to be short.
    pub(super) fn into_order(mut self) -> Vec<Cell> {
        self.pieces.sort_unstable_by_key(|piece| piece.iter().min().copied());
        self.pieces.concat()
    }
}
