//! A dearer 2-matching: closed sets of cells pay for being closed.

use beadwork_base::Control;

use super::connectivity::{Allowed, closed_sets};
use crate::matching::{Classes, Groups, Matching, Node, Paths, ZoneGraph};

/// Rounds of raising, at most: of sets that no cheapest 2-matching leaves, and of those that the
/// present one does not.
const ROUNDS: u32 = 12;
const ROUNDS_IN_PARTS: u32 = 16;

/// Costs are counted in so many parts, that weights may be fractions.
const PARTS: i32 = 4;

/// Lower bound of the cost of a cover in so many pieces, by Lagrange multipliers on closed sets.
///
/// The links of a cover are a forest, so inside a set S of cells it has at most |S| - 1 of them
/// (Dantzig, Fulkerson and Johnson 1954, as for tours; Held and Karp 1970 put the multipliers on
/// the costs).
/// For any weight m >= 0, adding m to the cost of every link inside S and giving m (|S| - 1) back
/// does not raise the cost of a cover; hence the cheapest 2-matching under the raised costs, less
/// what is given back, is a bound, for any number of sets and weights; costs being whole numbers,
/// it may be rounded up.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cuts {
    /// On sets that no cheapest 2-matching leaves, each raised by 1: that raises the bound with
    /// each round, as long as no exchange becomes free.
    NeverLeft,
    /// Where there are no such sets, different ones are closed in different 2-matchings; then also
    /// on the groups of zones that are closed in the present one, raised by a part of 1, a
    /// subgradient step.
    Stepwise,
}

impl Cuts {
    /// The bound; the search for it ends when it reaches `enough`.
    /// Each round repairs the optimum along the borders of the sets: linear in the cells for each
    /// link that changes, at most.
    pub(crate) fn bound(
        self,
        cheapest: &Matching<'_>,
        pieces: u32,
        paths: &mut Paths,
        enough: u64,
        control: &Control<'_>,
    ) -> u64 {
        let board = cheapest.board.with_costs_in_parts(PARTS);
        let zones = ZoneGraph::new(&board);
        let mut matching = cheapest.in_parts(&board, PARTS);
        let mut best = matching.cost();
        let mut given_back = 0;
        let mut rounds_left = [ROUNDS, ROUNDS_IN_PARTS];
        let whole = |bound: i64| (bound.max(0) as u64).div_ceil(PARTS as u64);
        while whole(best) < enough && control.interrupted().is_none() {
            let classes = Classes::new(&matching);
            let allowed = Allowed { matching: &matching, classes: &classes };
            let graph = ZoneGraph::of(&board, |node, dir| allowed.link(node, dir));
            let never_left = closed_sets(&graph, &allowed, pieces);
            let (sets, by, kind) = match self {
                Self::Stepwise if never_left.is_empty() => (closed_groups(&zones, &matching), 1, 1),
                _ => (never_left, PARTS, 0),
            };
            if sets.is_empty() || rounds_left[kind] == 0 {
                break;
            }
            rounds_left[kind] -= 1;
            for set in sets {
                matching.raise_inside(&set, by);
                given_back += i64::from(by) * (set.len() as i64 - 1);
            }
            paths.repair(&mut matching);
            let bound = matching.raised_cost() - given_back;
            if self == Self::NeverLeft && bound <= best {
                break;
            }
            best = best.max(bound);
        }
        whole(best)
    }
}

/// The groups of zone components that no link of this 2-matching leaves and that have no room.
fn closed_groups(zones: &ZoneGraph, matching: &Matching<'_>) -> Vec<Vec<Node>> {
    let board = matching.board;
    let mut groups = Groups::new(zones, board, |node, dir| matching.is_linked(node, dir));
    let mut sets = vec![Vec::new(); zones.count() as usize];
    let mut is_closed = vec![true; zones.count() as usize];
    for &node in &board.cells {
        let root = groups.root(zones.component(node)) as usize;
        sets[root].push(node);
        is_closed[root] &= matching.room[node as usize] == 0;
    }
    sets.into_iter()
        .zip(is_closed)
        .filter(|(set, is_closed)| *is_closed && !set.is_empty())
        .map(|(set, _)| set)
        .collect()
}
