//! The slow, obvious reference implementation of the exact search: it tries every set of links.

use crate::CostMatrix;
use beadwork_grid::{Cell, Region, Zones};

/// A region to cover, and what its crossings cost.
pub(super) struct Problem<'a> {
    pub(super) region: &'a Region,
    pub(super) zones: &'a Zones,
    pub(super) costs: &'a CostMatrix,
    /// Cell at which the first piece has to begin; `None` for any.
    pub(super) start: Option<Cell>,
    /// Cell at which the last piece has to end; `None` for any.
    pub(super) end: Option<Cell>,
}

/// The minimum number of pieces of a cover, and the minimum cost of a cover with that number.
pub(super) fn fewest_and_cheapest(problem: &Problem<'_>) -> (u32, u64) {
    (1..)
        .find_map(|pieces| cheapest(problem, pieces).map(|cost| (pieces, cost)))
        .expect("single cells are a cover")
}

/// The minimum cost of a cover with this number of pieces; `None` if there is none.
pub(super) fn cheapest(problem: &Problem<'_>, pieces: u32) -> Option<u64> {
    let cells: Vec<Cell> = problem.region.cells().collect();
    let links = cells.len().checked_sub(pieces as usize)?;
    let mut search = Search {
        problem,
        cells,
        links,
        linked: vec![Vec::new(); problem.region.grid_len()],
        best: None,
    };
    search.decide(0, 0, 0);
    search.best
}

struct Search<'a> {
    problem: &'a Problem<'a>,
    cells: Vec<Cell>,
    /// Number of links that the cover must have.
    links: usize,
    /// For each cell the cells it is linked with so far.
    linked: Vec<Vec<Cell>>,
    best: Option<u64>,
}

impl Search<'_> {
    /// Tries all choices of the links of one cell to the right and below, each followed by all
    /// choices for the cells after it.
    ///
    /// `links` is the number of links chosen so far; `lacking` is how many links the earlier cells
    /// have fewer than two each.
    fn decide(&mut self, index: usize, links: usize, lacking: usize) {
        // Two links at each cell would be one link for each cell.
        // Each link fewer than that leaves two link ends missing.
        if lacking > 2 * (self.cells.len() - self.links) {
            return;
        }
        let Some(&cell) = self.cells.get(index) else {
            if links == self.links {
                self.finish();
            }
            return;
        };
        let later: Vec<Cell> =
            self.problem.region.neighbours(cell).filter(|&other| other > cell).collect();
        for choice in 0..1_u32 << later.len() {
            let chosen: Vec<Cell> = (0..later.len())
                .filter(|bit| choice >> bit & 1 == 1)
                .map(|bit| later[bit])
                .collect();
            if self.linked[cell as usize].len() + chosen.len() > 2
                || chosen.iter().any(|&other| self.linked[other as usize].len() > 1)
            {
                continue;
            }
            let mut inserted = 0;
            for &other in &chosen {
                if self.reaches(cell, other) {
                    break;
                }
                self.linked[cell as usize].push(other);
                self.linked[other as usize].push(cell);
                inserted += 1;
            }
            if inserted == chosen.len() {
                let lacking = lacking + 2 - self.linked[cell as usize].len();
                self.decide(index + 1, links + inserted, lacking);
            }
            for &other in chosen[..inserted].iter().rev() {
                self.linked[cell as usize].pop();
                self.linked[other as usize].pop();
            }
        }
    }

    /// Whether links already connect two cells, so that one between them would close a cycle.
    fn reaches(&self, from: Cell, to: Cell) -> bool {
        let mut seen = vec![from];
        let mut index = 0;
        while let Some(&cell) = seen.get(index) {
            for &other in &self.linked[cell as usize] {
                if !seen.contains(&other) {
                    seen.push(other);
                }
            }
            index += 1;
        }
        seen.contains(&to)
    }

    /// Updates the best cost with a complete cover, if its ends are as required.
    fn finish(&mut self) {
        let Problem { zones, costs, start, end, .. } = *self.problem;
        let mut total = 0;
        let mut seen: Vec<Cell> = Vec::new();
        let mut pieces: Vec<Vec<Cell>> = Vec::new();
        for &cell in self.cells.iter().filter(|&&cell| self.linked[cell as usize].len() < 2) {
            if seen.contains(&cell) {
                continue;
            }
            let mut piece = vec![cell];
            while let Some(&next) = self.linked[piece[piece.len() - 1] as usize]
                .iter()
                .find(|&other| !piece.contains(other))
            {
                piece.push(next);
            }
            seen.extend(&piece);
            pieces.push(piece);
        }
        let cost_of = |piece: &[Cell]| -> u64 {
            piece
                .windows(2)
                .map(|step| u64::from(costs.scaled(zones.id(step[0]), zones.id(step[1]))))
                .sum()
        };
        for piece in &pieces {
            let forward = cost_of(piece);
            let backward = cost_of(&piece.iter().rev().copied().collect::<Vec<_>>());
            let (first, last) = (piece[0], piece[piece.len() - 1]);
            // The first piece begins at the start, the last one ends at the end, and one piece
            // holds both only if it is the only one.
            let ways = [(forward, first, last), (backward, last, first)].into_iter().filter(
                |&(_, first, last)| {
                    let [has_start, has_end] =
                        [start, end].map(|end| end.is_some_and(|cell| piece.contains(&cell)));
                    (!has_start || start == Some(first))
                        && (!has_end || end == Some(last))
                        && !(has_start && has_end && pieces.len() > 1)
                },
            );
            let Some(cost) = ways.map(|(cost, ..)| cost).min() else { return };
            total += cost;
        }
        self.best = Some(self.best.map_or(total, |best| best.min(total)));
    }
}
