//! Connecting groups of zone components that no link of the cheapest 2-matching leaves.
//!
//! The zone components that links join form *groups*; no link leads from one group to another.
//! A group is *closed* if no cell in it has room for another link: then its strands are cycles, or
//! paths between reserved ends, and no rearrangement of links inside the group connects it to the
//! rest of the path.
//!
//! ```text
//!   A: o---o   B: o---o---o        A holds a cycle and no link leaves it: A is a closed group.
//!      |   |              |        Inserting a link from A to B, by a cheapest exchange along an
//!      o---o      o---o---o        alternating cycle, opens it.
//! ```
//!
//! Inserting one link moves others along an alternating cycle, which may close another group.
//! So links are inserted one by one, and the groups are computed again after each.

use beadwork_base::Control;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::matching::{ComponentGraph, Dir, Groups, Node, ShortestPaths, TwoMatching};
use crate::random::below;

/// Inserts links until no group of components is closed.
///
/// First inserts links that cost nothing, drawn at random, and undoes each insertion that increases
/// the number of closed groups.
/// When no such link is left or too many have failed, inserts the cheapest of a few links drawn at
/// random; these are locked, so that later steps keep them.
///
/// Groups may stay closed if the call is interrupted or no link can be inserted.
pub(super) fn connect(
    matching: &mut TwoMatching<'_>,
    graph: &ComponentGraph,
    paths: &mut ShortestPaths,
    rng: &mut Xoshiro256PlusPlus,
    control: &Control<'_>,
) {
    let mut groups = ClosedGroups::new(graph, matching);
    let mut candidates: Vec<(Node, Dir)> = Vec::new();

    let max_failures = 2 * groups.count + 20;
    let mut failures = 0;
    while groups.count > 0 && failures < max_failures && control.interrupted().is_none() {
        groups.links_out(graph, matching, &mut candidates);
        // A positive reduced cost is a lower bound on what an insertion costs.
        candidates.retain(|&(node, dir)| matching.reduced_cost(node, dir) == 0);
        if candidates.is_empty() {
            break;
        }
        let (node, dir) = candidates[below(rng, candidates.len())];
        failures += 1;
        if paths.insertion_cost(matching, node, dir, 1).is_some() {
            paths.insert(matching, node, dir);
            let after = ClosedGroups::new(graph, matching);
            if after.count > groups.count {
                paths.undo_insertion(matching, node, dir);
            } else {
                if after.count < groups.count {
                    failures = 0;
                }
                groups = after;
            }
        }
    }

    let mut tries_left = 3 * groups.count + 20;
    while groups.count > 0 && tries_left > 0 && control.interrupted().is_none() {
        tries_left -= 1;
        groups.links_out(graph, matching, &mut candidates);
        if !insert_cheapest(matching, &candidates, paths, rng) {
            return;
        }
        groups = ClosedGroups::new(graph, matching);
    }
}

/// Inserts and locks the cheapest of up to eight links drawn at random from the candidates, which
/// are named by their black cells.
/// Returns whether one of them could be inserted.
pub(super) fn insert_cheapest(
    matching: &mut TwoMatching<'_>,
    candidates: &[(Node, Dir)],
    paths: &mut ShortestPaths,
    rng: &mut Xoshiro256PlusPlus,
) -> bool {
    if candidates.is_empty() {
        return false;
    }
    // Links that cost nothing have been tried before, so a cheaper link than one crossing at the
    // minimum cost is unlikely.
    let good_enough = matching.board.min_crossing_cost() as i32;
    let mut best: Option<(i32, (Node, Dir))> = None;
    let mut is_last = false;
    for _ in 0..=rng.next_u64() % 8 {
        let (node, dir) = candidates[below(rng, candidates.len())];
        let limit = best.map_or(ShortestPaths::UNLIMITED, |(cost, _)| cost);
        is_last = false;
        if let Some(cost) = paths.insertion_cost(matching, node, dir, limit) {
            best = Some((cost, (node, dir)));
            is_last = true;
            if cost <= good_enough {
                break;
            }
        }
    }
    let Some((_, (node, dir))) = best else { return false };
    // The path search remembers only its last path, so find the path of the best link again.
    if !is_last {
        paths.insertion_cost(matching, node, dir, ShortestPaths::UNLIMITED);
    }
    paths.insert(matching, node, dir);
    matching.lock(node, dir);
    true
}

/// The groups of components that the links of a 2-matching join, and which of them are closed.
struct ClosedGroups {
    groups: Groups,
    /// For each group, at the index of its representative, whether it is closed.
    is_closed: Vec<bool>,
    /// Number of closed groups.
    count: u32,
}

impl ClosedGroups {
    /// Linear in the cells.
    fn new(graph: &ComponentGraph, matching: &TwoMatching<'_>) -> Self {
        let mut groups =
            Groups::new(graph, matching.board, |node, dir| matching.is_linked(node, dir));
        let mut is_closed = vec![true; graph.count() as usize];
        let mut count = groups.count();
        for &node in &matching.board.cells {
            if matching.has_room(node) {
                let group = groups.group(graph.component(node)) as usize;
                count -= u32::from(is_closed[group]);
                is_closed[group] = false;
            }
        }
        Self { groups, is_closed, count }
    }

    /// Collects the links that lead out of closed groups, by their black cells.
    fn links_out(
        &mut self,
        graph: &ComponentGraph,
        matching: &TwoMatching<'_>,
        links: &mut Vec<(Node, Dir)>,
    ) {
        links.clear();
        for &link in &graph.links {
            let (a, b) = self.groups.of_link(graph, matching.board, link);
            if a != b && (self.is_closed[a as usize] || self.is_closed[b as usize]) {
                links.push(link);
            }
        }
    }
}
