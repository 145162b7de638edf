//! The bound by cuts: Lagrange multipliers on sets of cells that a cover cannot close.
//!
//! # Proof
//! The links of a cover form a forest, so inside a set S of cells it has at most |S| - 1 links.
//! A 2-matching that leaves S as cycles has |S|.
//! (These are the subtour constraints of Dantzig, Fulkerson and Johnson 1954 for the travelling
//! salesman; Held and Karp 1970 charge violations of constraints by multipliers.)
//!
//! Choose a multiplier m >= 0 for this set.
//! Add m to the cost of every link inside S, as a surcharge, and subtract m (|S| - 1) from the
//! total.
//! The cost of a cover does not rise, as it has at most |S| - 1 such links.
//! So the cheapest 2-matching under the changed costs is still a lower bound; and a 2-matching that
//! still closes S now costs m more than before, so the bound rises unless another one avoids the
//! charge.
//!
//! ```text
//!   S:  o--o       4 cells, 4 links: a cycle pays 4 m and gets 3 m back.
//!       |  |       A path through S has at most 3 links inside, and pays nothing in sum.
//!       o--o
//! ```
//!
//! This holds for any number of sets and any multipliers, whichever way they are chosen, so only
//! the quality of the bound depends on the choice.
//! As costs are whole numbers, a bound may be rounded up.

use beadwork_base::Control;

use super::connectivity::{OptimalLinks, closed_components};
use crate::matching::{ComponentGraph, Groups, Node, ShortestPaths, TightClasses, TwoMatching};

/// Maximum number of rounds that charge sets closed in all cheapest 2-matchings.
const MAX_ROUNDS: u32 = 12;

/// Maximum number of rounds that charge sets closed in the present 2-matching (subgradient steps).
const MAX_SUBGRADIENT_ROUNDS: u32 = 16;

/// Costs are scaled by this factor, so that multipliers can be fractions.
const COST_SCALE: i32 = 4;

/// Which sets of cells are charged.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cuts {
    /// Sets that are closed in all cheapest 2-matchings, with multiplier 1. Each round raises the
    /// bound, as long as no exchange becomes free.
    ClosedInAll,
    /// The sets of [`Cuts::ClosedInAll`] as long as there are any.
    /// After that, different cheapest 2-matchings close different sets, so the groups of zones that
    /// the present one closes are charged, with a multiplier of 1/[`COST_SCALE`].
    /// This is a subgradient step: the bound may fall before it rises.
    Subgradient,
}

impl Cuts {
    /// Lower bound on the cost of a cover with `pieces` pieces, starting from the cheapest
    /// 2-matching.
    ///
    /// Ends when the bound reaches `enough`, when no set is closed, after the maximum number of
    /// rounds, or when interrupted; the bound holds in any case.
    /// Each round restores the optimum by a shortest-path search for each link that has to change.
    pub(crate) fn bound(
        self,
        cheapest: &TwoMatching<'_>,
        pieces: u32,
        paths: &mut ShortestPaths,
        enough: u64,
        control: &Control<'_>,
    ) -> u64 {
        let board = cheapest.board.with_scaled_costs(COST_SCALE);
        let zones = ComponentGraph::of_zones(&board);
        let mut matching = cheapest.scaled(&board, COST_SCALE);
        let mut best = matching.cost();
        let mut given_back = 0;
        let mut rounds_left = [MAX_ROUNDS, MAX_SUBGRADIENT_ROUNDS];
        let unscaled = |bound: i64| (bound.max(0) as u64).div_ceil(COST_SCALE as u64);
        while unscaled(best) < enough && control.interrupted().is_none() {
            let classes = TightClasses::new(&matching);
            let optimal = OptimalLinks { matching: &matching, classes: &classes };
            let components = ComponentGraph::new(&board, |node, dir| optimal.contains(node, dir));
            let closed_in_all = closed_components(&components, &optimal, pieces);
            let (sets, multiplier, kind) = match self {
                Self::Subgradient if closed_in_all.is_empty() => {
                    (closed_groups(&zones, &matching), 1, 1)
                }
                _ => (closed_in_all, COST_SCALE, 0),
            };
            if sets.is_empty() || rounds_left[kind] == 0 {
                break;
            }
            rounds_left[kind] -= 1;
            for set in sets {
                matching.add_surcharge(&set, multiplier);
                given_back += i64::from(multiplier) * (set.len() as i64 - 1);
            }
            paths.restore_optimum(&mut matching);
            let bound = matching.cost_with_surcharges() - given_back;
            if self == Self::ClosedInAll && bound <= best {
                break;
            }
            best = best.max(bound);
        }
        unscaled(best)
    }
}

/// The cells of each group of zone components that no link of this 2-matching leaves and that has
/// no room.
fn closed_groups(zones: &ComponentGraph, matching: &TwoMatching<'_>) -> Vec<Vec<Node>> {
    let board = matching.board;
    let mut groups = Groups::new(zones, board, |node, dir| matching.is_linked(node, dir));
    let mut cells = vec![Vec::new(); zones.count() as usize];
    let mut is_closed = vec![true; zones.count() as usize];
    for &node in &board.cells {
        let group = groups.group(zones.component(node)) as usize;
        cells[group].push(node);
        is_closed[group] &= !matching.has_room(node);
    }
    cells
        .into_iter()
        .zip(is_closed)
        .filter(|(cells, is_closed)| *is_closed && !cells.is_empty())
        .map(|(cells, _)| cells)
        .collect()
}
