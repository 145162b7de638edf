//! Joins the cycles of a 2-matching to each other and to its paths.

use beadwork_base::{Control, Interrupted};

use crate::bits::{link, square};
use crate::matching::TwoMatching;
use crate::{Cell, Region};

/// Cells examined between two polls of the control.
const POLL_INTERVAL: usize = 1 << 16;

/// The paths and cycles ("strands") of a 2-matching.
///
/// Strands are only ever united, so a union-find structure knows which cells share one.
pub(super) struct Strands<'a> {
    region: &'a Region,
    matching: TwoMatching<'a>,
    /// For each cell its parent in the union-find tree of its strand; the root is its own parent.
    parent: Vec<Cell>,
    /// For each root, whether its strand is a cycle.
    is_cycle: Vec<bool>,
}

impl<'a> Strands<'a> {
    pub(super) fn new(region: &'a Region, matching: TwoMatching<'a>) -> Self {
        let cells = region.grid_len();
        let parent = (0..cells as Cell).collect();
        let mut strands = Self { region, matching, parent, is_cycle: vec![true; cells] };
        for cell in region.cells() {
            for other in strands.matching.linked(cell) {
                let (root, other_root) = (strands.root(cell), strands.root(other));
                strands.parent[other_root as usize] = root;
            }
        }
        for cell in region.cells() {
            if strands.matching.deficit(cell) > 0 {
                let root = strands.root(cell);
                strands.is_cycle[root as usize] = false;
            }
        }
        strands
    }

    /// The root of a cell's strand.
    /// Halves the path to it, which makes later calls faster.
    fn root(&mut self, mut cell: Cell) -> Cell {
        while self.parent[cell as usize] != cell {
            let next = self.parent[self.parent[cell as usize] as usize];
            self.parent[cell as usize] = next;
            cell = next;
        }
        cell
    }

    /// Whether two cells belong to different strands, at least one of which is a cycle.
    /// Only then do the changes below make one strand of two.
    fn can_unite(&mut self, a: Cell, b: Cell) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        a != b && (self.is_cycle[a as usize] || self.is_cycle[b as usize])
    }

    fn unite(&mut self, a: Cell, b: Cell) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a as usize] = b;
        self.is_cycle[b as usize] &= self.is_cycle[a as usize];
    }

    /// Joins cycles to other strands until no switch and no end of a path can join another one.
    /// Each pass over the cells but the last joins at least one, and usually one or two passes do.
    pub(super) fn join(&mut self, control: &Control<'_>) -> Result<(), Interrupted> {
        let cells: Vec<Cell> = self.region.cells().collect();
        loop {
            let mut joined = false;
            for cells in cells.chunks(POLL_INTERVAL) {
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

    /// Switches the unit cell at a corner if that joins a cycle to another strand.
    ///
    /// ```text
    ///   .~~~~~~~~~~~~.         .~~~~~~~~~~~~.
    ///   `~ a ---- b ~'         `~ a      b ~'     the cycle above is opened at a-b, the strand
    ///                    ->       |      |        below at c-d, and the ends are joined
    ///   ~~ c ---- d ~~         ~~ c      d ~~
    /// ```
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

    /// Extends a path from its end along a neighbouring cycle, which is opened at the neighbour.
    fn take_in(&mut self, end: Cell) -> bool {
        if self.matching.deficit(end) == 0 {
            return false;
        }
        // The strand of `end` is a path, so one that it can unite with is a cycle.
        let neighbour = self.region.neighbours(end).find(|&other| self.can_unite(end, other));
        let Some((cell, opened)) =
            neighbour.and_then(|cell| Some((cell, self.matching.linked(cell).next()?)))
        else {
            return false;
        };
        self.matching.toggle(cell, opened);
        self.matching.toggle(end, cell);
        self.unite(end, cell);
        true
    }

    /// The cells of each strand in order; cycles are opened at their lowest cell.
    pub(super) fn into_pieces(self) -> Vec<Vec<Cell>> {
        let mut seen = vec![false; self.region.grid_len()];
        let mut pieces = Vec::new();
        // Ends of paths first, so that what remains unseen are the cycles.
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
