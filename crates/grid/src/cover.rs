//! A start for any region: a cover by few paths.

use std::ops::Range;

use beadwork_base::{Control, Interrupted};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::matching::TwoMatching;
use crate::orders::{first_jump, row_zigzag};
use crate::path::{link, square};
use crate::{Cell, Path, Region, region_components};

/// Cells worked on between two looks at the control: about a millisecond.
const POLL_INTERVAL: u64 = 1 << 16;

/// A lower bound on the pieces of any cover.
///
/// The p pieces that cover a connected component of n cells have n - p links, at most two at each
/// cell; no set of links with at most two at each cell has more than a maximum 2-matching, so p is
/// at least n minus its size, and at least 1. The bound is the sum over the components.
/// It counts what colours cost: a component with d more black cells than white needs d pieces.
/// Cost as for the matching: nearly linear in the cells on usual parts.
pub fn piece_bound(region: &Region, control: &Control<'_>) -> Result<u32, Interrupted> {
    let matching = TwoMatching::maximum(region, control, region.cell_count() as usize)?;
    Ok(matching.pieces(&region_components(region)).iter().sum())
}

/// A path in few pieces through any region; of one piece wherever the row zigzag is.
/// Deterministic.
///
/// Elsewhere it takes a maximum 2-matching, joins its cycles to one another and to its paths, and
/// opens the cycles that are left.
/// While there are more pieces than [`piece_bound`], ends drawn at random take over cells of their
/// neighbours, until two of them meet or the work, in cells rewritten, exceeds a fixed multiple of
/// the region's.
/// The number of pieces is small but not always the smallest.
pub fn cover(region: &Region, control: &Control<'_>) -> Result<Path, Interrupted> {
    control.check()?;
    let rows = row_zigzag(region);
    let order = if first_jump(region, &rows).is_none() {
        rows
    } else {
        let total = region.cell_count() as usize + work_limit(region) as usize;
        let matching = TwoMatching::maximum(region, control, total)?;
        let bound = matching.pieces(&region_components(region)).iter().sum();
        let mut strands = Strands::new(region, matching);
        strands.join(control)?;
        let mut ends = Ends::new(region, strands.into_pieces());
        ends.wander(region, bound, control)?;
        control.report(total, total);
        ends.into_order()
    };
    Ok(Path::in_pieces(region, order).expect("the pieces hold every cell once"))
}

/// Cells that [`Ends::wander`] may rewrite.
/// Ends drift together like random walks, so small regions get quadratic work; large ones must stay
/// within seconds.
fn work_limit(region: &Region) -> u64 {
    let cells = u64::from(region.cell_count());
    (6_000 * cells).min(60_000_000 + 64 * cells)
}

/// The paths and cycles of a 2-matching.
struct Strands<'a> {
    region: &'a Region,
    matching: TwoMatching<'a>,
    /// For each cell another one of its strand, nearer to the strand's root; the root's is itself.
    towards_root: Vec<Cell>,
    /// For each root, whether its strand is a cycle.
    is_cycle: Vec<bool>,
}

impl<'a> Strands<'a> {
    fn new(region: &'a Region, matching: TwoMatching<'a>) -> Self {
        let cells = region.grid_len();
        let towards_root = (0..cells as Cell).collect();
        let mut strands = Self { region, matching, towards_root, is_cycle: vec![true; cells] };
        for cell in region.cells() {
            for other in strands.matching.linked(cell) {
                let (root, other_root) = (strands.root(cell), strands.root(other));
                strands.towards_root[other_root as usize] = root;
            }
        }
        for cell in
            region.cells().filter(|&cell| strands.matching.deficit(cell) > 0).collect::<Vec<_>>()
        {
            let root = strands.root(cell);
            strands.is_cycle[root as usize] = false;
        }
        strands
    }

    fn root(&mut self, mut cell: Cell) -> Cell {
        while self.towards_root[cell as usize] != cell {
            let next = self.towards_root[self.towards_root[cell as usize] as usize];
            self.towards_root[cell as usize] = next;
            cell = next;
        }
        cell
    }

    /// Whether these two belong to different strands, one of them a cycle: then a switch makes them
    /// one.
    fn can_unite(&mut self, a: Cell, b: Cell) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        a != b && (self.is_cycle[a as usize] || self.is_cycle[b as usize])
    }

    fn unite(&mut self, a: Cell, b: Cell) {
        let (a, b) = (self.root(a), self.root(b));
        self.towards_root[a as usize] = b;
        self.is_cycle[b as usize] &= self.is_cycle[a as usize];
    }

    /// Joins cycles to other strands until none can be: by switches, and by ends that take a cycle
    /// in.
    fn join(&mut self, control: &Control<'_>) -> Result<(), Interrupted> {
        let cells: Vec<Cell> = self.region.cells().collect();
        loop {
            let mut joined = false;
            for cells in cells.chunks(POLL_INTERVAL as usize) {
                control.check()?;
                for &cell in cells {
                    joined |= self.switch(cell) || self.take_in(cell);
                }
            }
            if !joined {
                return Ok(());
            }
        }
    }

    /// Switches the unit cell at a corner, if that makes two strands one.
    fn switch(&mut self, corner: Cell) -> bool {
        let (x, y) = self.region.xy(corner);
        if x + 1 >= self.region.width() || y + 1 >= self.region.height() {
            return false;
        }
        let opposite = corner + self.region.width() + 1;
        let bits = self.matching.links[corner as usize] & (square::TOP | square::LEFT)
            | self.matching.links[opposite as usize] & (square::BOTTOM | square::RIGHT);
        let parallel = [square::HORIZONTAL, square::VERTICAL].contains(&(bits | link::CORNER));
        if !parallel || !self.can_unite(corner, opposite) {
            return false;
        }
        let (b, c) = (corner + 1, opposite - 1);
        for (one, other) in [(corner, b), (c, opposite), (corner, c), (b, opposite)] {
            self.matching.toggle(one, other);
        }
        self.unite(corner, opposite);
        true
    }

    /// Lets the end of a path take in a cycle beside it: the path goes on with the cycle, opened
    /// there.
    fn take_in(&mut self, end: Cell) -> bool {
        if self.matching.deficit(end) == 0 {
            return false;
        }
        let beside = self.region.neighbours(end).find(|&other| self.can_unite(end, other));
        let Some((cell, opened)) =
            beside.and_then(|cell| Some((cell, self.matching.linked(cell).next()?)))
        else {
            return false;
        };
        self.matching.toggle(cell, opened);
        self.matching.toggle(end, cell);
        self.unite(end, cell);
        true
    }

    /// The cells of each strand in order, cycles opened at their first cell.
    fn into_pieces(self) -> Vec<Vec<Cell>> {
        let mut seen = vec![false; self.region.grid_len()];
        let mut pieces = Vec::new();
        let ends = self.region.cells().filter(|&cell| self.matching.deficit(cell) > 0);
        for first in ends.chain(self.region.cells()) {
            if seen[first as usize] {
                continue;
            }
            let mut piece = Vec::new();
            let mut next = Some(first);
            while let Some(cell) = next {
                seen[cell as usize] = true;
                piece.push(cell);
                next = self.matching.linked(cell).find(|&other| !seen[other as usize]);
            }
            pieces.push(piece);
        }
        pieces
    }
}

/// Disjoint paths through all cells, whose ends wander.
struct Ends {
    pieces: Vec<Vec<Cell>>,
    /// For each cell of the plane its piece and its index there.
    home: Vec<(u32, u32)>,
}

impl Ends {
    fn new(region: &Region, pieces: Vec<Vec<Cell>>) -> Self {
        let mut ends = Self { pieces, home: vec![(0, 0); region.grid_len()] };
        for piece in 0..ends.pieces.len() {
            ends.settle(piece, 0..ends.pieces[piece].len());
        }
        ends
    }

    /// Rotation and extension after Pósa, "Hamiltonian circuits in random graphs" (1976), until so
    /// many pieces are left or the work is done.
    fn wander(
        &mut self,
        region: &Region,
        pieces: u32,
        control: &Control<'_>,
    ) -> Result<(), Interrupted> {
        let limit = work_limit(region);
        let cells = region.cell_count() as usize;
        let (mut work_left, mut poll_at) = (limit, limit);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut neighbours = Vec::with_capacity(4);
        while self.pieces.len() as u32 > pieces && work_left > 0 {
            if work_left <= poll_at {
                control.check()?;
                control.report(cells + (limit - work_left) as usize, cells + limit as usize);
                poll_at = work_left.saturating_sub(POLL_INTERVAL);
            }
            let piece = rng.random_range(0..self.pieces.len());
            if rng.random() {
                self.pieces[piece].reverse();
                work_left =
                    work_left.saturating_sub(self.settle(piece, 0..self.pieces[piece].len()));
            }
            let end = *self.pieces[piece].last().expect("a piece has cells");
            neighbours.clear();
            neighbours.extend(region.neighbours(end));
            let work = match neighbours.len() {
                0 => 1,
                count => self.extend(piece, neighbours[rng.random_range(0..count)]),
            };
            work_left = work_left.saturating_sub(work);
        }
        Ok(())
    }

    /// Links the last cell of a piece to a neighbour; gives the number of cells rewritten.
    ///
    /// In its own piece, that turns the stretch between them round and gives the piece a new end;
    /// inside another piece, it cuts that one and takes over one part of it; at another piece's
    /// end, it joins the two.
    fn extend(&mut self, piece: usize, to: Cell) -> u64 {
        let (other, index) = self.home[to as usize];
        let (other, index) = (other as usize, index as usize);
        if other == piece {
            let changed = index + 1..self.pieces[piece].len();
            self.pieces[piece][changed.clone()].reverse();
            return self.settle(piece, changed);
        }
        // Of the other piece, the longer part is taken over: long pieces have few ends in the way
        // of their growth.
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
        }
        if other < self.pieces.len() {
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

    /// All pieces in one order, in the order of their topmost, leftmost cells, so that the lifts
    /// between them stay short.
    fn into_order(mut self) -> Vec<Cell> {
        self.pieces.sort_unstable_by_key(|piece| piece.iter().min().copied());
        self.pieces.concat()
    }
}

#[cfg(test)]
mod tests;
