//! Maximum simple 2-matchings of a region: sets of the maximum number of links with at most two at
//! each cell.
//!
//! # What they are good for
//! A set of links with at most two at each cell consists of disjoint paths and cycles (a cell
//! without links is a path of one cell).
//! A cover of n cells by p paths is such a set, with n - p links.
//! So no cover has more links than a maximum 2-matching, which bounds the number of paths from
//! below; and if the matching's cycles can be joined to its paths, it becomes a cover of few paths.
//!
//! # How one is found
//! Colour the cells like a chessboard: every link then joins a black cell to a white one, so the
//! grid is a bipartite graph, and a maximum 2-matching is a maximum flow from the black cells to
//! the white ones with a capacity of 2 at each cell and of 1 at each link.
//!
//! An **augmenting path** starts at a black cell with fewer than two links and ends at a white cell
//! with fewer than two.
//! Its first link is not in the matching, the second is, the third is not, and so on.
//! Taking out the links that are in and putting in those that are not gives the first and the last
//! cell one more link each, and leaves the cells between with two.
//!
//! ```text
//!   before   B    W ---- B    W          B and W have room for one more link each
//!   after    B -- W      B -- W
//! ```
//!
//! A matching without an augmenting path is maximum (the theorem of Berge, or of maximum flow and
//! minimum cut).
//! Here the search for them is breadth-first and starts from all horizontal links, which leaves
//! little to do: only cells at the ends of rows have fewer than two links.

use std::collections::VecDeque;

use beadwork_base::{Control, Interrupted};

use crate::bits::link;
use crate::{Cell, Components, Region};

/// A set of links of a region, at most two at each cell.
pub(crate) struct TwoMatching<'a> {
    region: &'a Region,
    /// The links of each cell of the grid, as bits of [`link`].
    pub(crate) links: Vec<u8>,
}

impl<'a> TwoMatching<'a> {
    /// Finds a maximum 2-matching, which follows the rows where possible.
    ///
    /// O(cells) for each end of a row in the worst case.
    /// On usual parts nearly linear in the grid's cells, because most augmenting paths are short.
    ///
    /// Reports the number of cells done, out of a `total` that the caller sets.
    pub(crate) fn maximum(
        region: &'a Region,
        control: &Control<'_>,
        total: usize,
    ) -> Result<Self, Interrupted> {
        let mut matching = Self { region, links: vec![0; region.grid_len()] };
        for cell in region.cells() {
            let (x, _) = region.xy(cell);
            if x + 1 < region.width() && region.contains(cell + 1) {
                matching.toggle(cell, cell + 1);
            }
        }
        let mut search = Search::new(region.grid_len());
        let mut row = None;
        for (done, cell) in region.cells().enumerate() {
            let (x, y) = region.xy(cell);
            if row.replace(y) != Some(y) {
                control.check()?;
                control.report(done, total);
            }
            let is_black = (x + y).is_multiple_of(2);
            if is_black {
                while matching.deficit(cell) > 0 && search.augment(&mut matching, cell) {}
            }
        }
        control.report(region.cell_count() as usize, total);
        Ok(matching)
    }

    /// Number of links missing at a cell: two minus its links.
    pub(crate) fn deficit(&self, cell: Cell) -> u32 {
        2 - self.links[cell as usize].count_ones()
    }

    /// Puts in the link between two neighbours, or takes it out if it is in.
    pub(crate) fn toggle(&mut self, a: Cell, b: Cell) {
        let (low, high) = (a.min(b), a.max(b));
        // The order of the tests matters on a grid of one column, where the cell below has the next
        // number, too.
        let (of_low, of_high) = if high - low == self.region.width() {
            (link::BELOW, link::ABOVE)
        } else {
            (link::RIGHT, link::LEFT)
        };
        self.links[low as usize] ^= of_low;
        self.links[high as usize] ^= of_high;
    }

    /// The cells that a cell is linked to.
    pub(crate) fn linked(&self, cell: Cell) -> impl Iterator<Item = Cell> + use<> {
        let bits = self.links[cell as usize];
        let width = self.region.width();
        let others = [
            (link::RIGHT, cell.wrapping_add(1)),
            (link::BELOW, cell.wrapping_add(width)),
            (link::LEFT, cell.wrapping_sub(1)),
            (link::ABOVE, cell.wrapping_sub(width)),
        ];
        others.into_iter().filter(move |(bit, _)| bits & bit != 0).map(|(_, other)| other)
    }

    /// Lower bound on the number of paths that cover each component, in the order of the
    /// components' numbers, if the matching is maximum.
    ///
    /// A component of n cells with m links has a total deficit of 2 n - 2 m, so half of it is the
    /// bound n - m.
    /// If all cells have two links, they form cycles, and a cover still needs one path.
    pub(crate) fn pieces(&self, components: &Components) -> Vec<u32> {
        let mut deficits = vec![0; components.count() as usize];
        for cell in self.region.cells() {
            deficits[components.label(cell) as usize] += self.deficit(cell);
        }
        deficits.iter().map(|deficit: &u32| (deficit / 2).max(1)).collect()
    }
}

/// Breadth-first search for augmenting paths; its buffers serve all searches.
struct Search {
    /// The predecessor of each cell in the search that reached it last.
    before: Vec<Cell>,
    /// The round in which a cell was reached last, or [`Search::DEAD`].
    reached_in: Vec<u32>,
    round: u32,
    /// Black cells whose neighbours have not been examined yet.
    queue: VecDeque<Cell>,
}

impl Search {
    /// Marks cells that no later augmenting path can pass.
    const DEAD: u32 = u32::MAX;

    fn new(cells: usize) -> Self {
        Self {
            before: vec![0; cells],
            reached_in: vec![0; cells],
            round: 0,
            queue: VecDeque::new(),
        }
    }

    /// Gives the black cell `root` one more link, if there is an augmenting path from it.
    ///
    /// If there is none, all cells that this search reached are dead: no later augmenting path
    /// passes them.
    /// From these cells, only these cells and dead ones can be reached, and no white one among them
    /// has room for another link.
    /// Augmenting paths that stay outside do not change that.
    fn augment(&mut self, matching: &mut TwoMatching<'_>, root: Cell) -> bool {
        let region = matching.region;
        self.round += 1;
        self.queue.clear();
        self.queue.push_back(root);
        self.reached_in[root as usize] = self.round;
        let mut reached = vec![root];
        while let Some(black) = self.queue.pop_front() {
            // To a white cell by a link that is not in the matching ...
            for white in region.neighbours(black) {
                if !self.is_new(white) || matching.linked(black).any(|linked| linked == white) {
                    continue;
                }
                self.reach(white, black, &mut reached);
                if matching.deficit(white) > 0 {
                    self.flip(matching, root, white);
                    return true;
                }
                // ... and back to a black cell by one that is.
                for next in matching.linked(white) {
                    if self.is_new(next) {
                        self.reach(next, white, &mut reached);
                        self.queue.push_back(next);
                    }
                }
            }
        }
        reached.iter().for_each(|&cell| self.reached_in[cell as usize] = Self::DEAD);
        false
    }

    /// Whether a cell is worth visiting: this search has not reached it yet, and it is not dead.
    fn is_new(&self, cell: Cell) -> bool {
        self.reached_in[cell as usize] != self.round && self.reached_in[cell as usize] != Self::DEAD
    }

    fn reach(&mut self, cell: Cell, before: Cell, reached: &mut Vec<Cell>) {
        self.reached_in[cell as usize] = self.round;
        self.before[cell as usize] = before;
        reached.push(cell);
    }

    /// Toggles the links of the augmenting path from `root` to `end`.
    fn flip(&self, matching: &mut TwoMatching<'_>, root: Cell, end: Cell) {
        let mut cell = end;
        while cell != root {
            let before = self.before[cell as usize];
            matching.toggle(before, cell);
            cell = before;
        }
    }
}
