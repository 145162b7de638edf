//! Maximum simple 2-matchings: as many links as any set of paths and cycles through a region can
//! have.
//!
//! A simple 2-matching is a set of links with at most two at each cell: disjoint paths and cycles.
//! A cover by p paths has cells - p links, so a maximum 2-matching bounds the pieces from below,
//! and it is the raw material of a cover.
//! The grid is bipartite (colour it like a chessboard), hence the matching is a flow from one
//! colour to the other and grows along alternating paths.

use std::collections::VecDeque;

use beadwork_base::{Control, Interrupted};

use crate::path::link;
use crate::{Cell, Components, Region};

/// Links with at most two at each cell.
pub(crate) struct TwoMatching<'a> {
    region: &'a Region,
    /// The links of each cell, as bits of [`link`].
    pub(crate) links: Vec<u8>,
}

impl<'a> TwoMatching<'a> {
    /// A maximum one that keeps to the rows where it can.
    ///
    /// O(cells) for each end of a row in the worst case; on parts nearly linear, for ends find each
    /// other nearby.
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
            if (x + y).is_multiple_of(2) {
                while matching.deficit(cell) > 0 && search.augment(&mut matching, cell) {}
            }
        }
        control.report(region.cell_count() as usize, total);
        Ok(matching)
    }

    /// How many links the cell lacks to have two.
    pub(crate) fn deficit(&self, cell: Cell) -> u32 {
        2 - self.links[cell as usize].count_ones()
    }

    /// Puts a link between two neighbours in, or takes it out.
    pub(crate) fn toggle(&mut self, a: Cell, b: Cell) {
        let (low, high) = (a.min(b), a.max(b));
        // In a plane of one column the cell below is the next one too.
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

    /// The pieces that the cells of each component need at least, in the order of their labels:
    /// half their deficit, and one.
    pub(crate) fn pieces(&self, components: &Components) -> Vec<u32> {
        let mut deficits = vec![0; components.count() as usize];
        for cell in self.region.cells() {
            deficits[components.label(cell) as usize] += self.deficit(cell);
        }
        deficits.iter().map(|deficit: &u32| (deficit / 2).max(1)).collect()
    }
}

/// Breadth-first search for alternating paths.
struct Search {
    /// The cell before each one seen.
    before: Vec<Cell>,
    /// The search in which a cell was seen last; [`Search::DEAD`] if none can pass it.
    seen: Vec<u32>,
    round: u32,
    open: VecDeque<Cell>,
}

impl Search {
    const DEAD: u32 = u32::MAX;

    fn new(cells: usize) -> Self {
        Self { before: vec![0; cells], seen: vec![0; cells], round: 0, open: VecDeque::new() }
    }

    /// Gives a cell one more link, if an alternating path leads from it to another cell that lacks
    /// one.
    ///
    /// Cells of a search that failed lead nowhere in later ones either: what could be reached from
    /// them is all they saw.
    fn augment(&mut self, matching: &mut TwoMatching<'_>, root: Cell) -> bool {
        let region = matching.region;
        self.round += 1;
        self.open.clear();
        self.open.push_back(root);
        self.seen[root as usize] = self.round;
        let mut reached = vec![root];
        while let Some(cell) = self.open.pop_front() {
            for other in region.neighbours(cell) {
                let is_new = self.seen[other as usize] != self.round
                    && self.seen[other as usize] != Self::DEAD;
                if !is_new || matching.linked(cell).any(|linked| linked == other) {
                    continue;
                }
                self.see(other, cell, &mut reached);
                if matching.deficit(other) > 0 {
                    self.flip(matching, root, other);
                    return true;
                }
                for next in matching.linked(other) {
                    if self.seen[next as usize] != self.round
                        && self.seen[next as usize] != Self::DEAD
                    {
                        self.see(next, other, &mut reached);
                        self.open.push_back(next);
                    }
                }
            }
        }
        reached.iter().for_each(|&cell| self.seen[cell as usize] = Self::DEAD);
        false
    }

    fn see(&mut self, cell: Cell, before: Cell, reached: &mut Vec<Cell>) {
        self.seen[cell as usize] = self.round;
        self.before[cell as usize] = before;
        reached.push(cell);
    }

    /// Puts in and takes out the links along the path that was found.
    fn flip(&self, matching: &mut TwoMatching<'_>, root: Cell, end: Cell) {
        let mut cell = end;
        while cell != root {
            let before = self.before[cell as usize];
            matching.toggle(before, cell);
            cell = before;
        }
    }
}
