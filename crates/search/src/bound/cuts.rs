//! A dearer 2-matching: closed sets of cells pay for being closed.

use super::connectivity::{Allowed, closed_sets};
use crate::matching::{Classes, Matching, Paths, ZoneGraph};
use crate::stop::Interrupt;

/// Rounds of raising, at most.
const ROUNDS: u32 = 12;

/// Lower bound of the cost of a cover in so many pieces, by Lagrange multipliers on closed sets.
///
/// The links of a cover are a forest, so inside a set S of cells it has at most |S| - 1 of them (Dantzig, Fulkerson and
/// Johnson 1954, as for tours; Held and Karp 1970 put the multipliers on the costs). For any weight m >= 0, adding m to the cost
/// of every link inside S and giving m (|S| - 1) back does not raise the cost of a cover; hence the cheapest 2-matching under
/// the raised costs, less what is given back, is a bound, for any number of sets and weights.
///
/// The sets are those that no cheapest 2-matching leaves, which are raised by 1 until there are none: then the bound rises with
/// each round, as long as no exchange becomes free. Ends when it reaches `enough`. Each round repairs the optimum along the
/// borders of the sets: linear in the cells for each link that changes, at most.
pub(crate) fn cuts(
    cheapest: &Matching<'_>,
    pieces: u32,
    paths: &mut Paths,
    enough: u64,
    interrupt: Interrupt<'_>,
) -> u64 {
    let board = cheapest.board;
    let mut matching = cheapest.clone();
    let mut best = matching.cost();
    let mut given_back = 0;
    for _ in 0..ROUNDS {
        let classes = Classes::new(&matching);
        let allowed = Allowed { matching: &matching, classes: &classes };
        let graph = ZoneGraph::of(board, |node, dir| allowed.link(node, dir));
        let sets = closed_sets(&graph, &allowed, pieces);
        if sets.is_empty() || best as u64 >= enough || interrupt.check().is_some() {
            break;
        }
        for set in sets {
            matching.raise_inside(&set, 1);
            given_back += set.len() as i64 - 1;
        }
        paths.repair(&mut matching);
        best = best.max(matching.raised_cost() - given_back);
    }
    best as u64
}
