//! Linking what the cheapest 2-matching leaves apart.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::matching::{Dir, Groups, Matching, Node, Paths, ZoneGraph};
use crate::random::below;
use crate::stop::Interrupt;

/// Puts links in until no group of zone components is closed: left by no link and without room, so
/// made of cycles only.
///
/// At first links that cost nothing, as long as they close no other group; then, each time the
/// cheapest of a few drawn at random, links that cost, and these stay.
/// Closed groups can be left if it is interrupted or no link can be had.
pub(crate) fn link(
    matching: &mut Matching<'_>,
    graph: &ZoneGraph,
    paths: &mut Paths,
    rng: &mut Xoshiro256PlusPlus,
    interrupt: Interrupt<'_>,
) {
    let mut groups = Closed::new(graph, matching);
    let mut in_vain = 0;
    let patience = 2 * groups.count + 20;
    let mut candidates: Vec<(Node, Dir)> = Vec::new();
    while groups.count > 0 && in_vain < patience && interrupt.check().is_none() {
        groups.outward(graph, matching, &mut candidates);
        candidates.retain(|&(node, dir)| matching.reduced(node, dir) == 0);
        if candidates.is_empty() {
            break;
        }
        let (node, dir) = candidates[below(rng, candidates.len())];
        in_vain += 1;
        if paths.cost_of_link(matching, node, dir, 1).is_some() {
            paths.put_in(matching, node, dir);
            let now = Closed::new(graph, matching);
            if now.count > groups.count {
                paths.undo(matching, node, dir);
            } else {
                in_vain = if now.count < groups.count { 0 } else { in_vain };
                groups = now;
            }
        }
    }
    let mut tries_left = 3 * groups.count + 20;
    while groups.count > 0 && tries_left > 0 && interrupt.check().is_none() {
        tries_left -= 1;
        groups.outward(graph, matching, &mut candidates);
        if !force_cheapest(matching, &candidates, paths, rng) {
            return;
        }
        groups = Closed::new(graph, matching);
    }
}

/// Puts in the cheapest of a few links drawn at random, for good; false if none of them can be had.
pub(crate) fn force_cheapest(
    matching: &mut Matching<'_>,
    candidates: &[(Node, Dir)],
    paths: &mut Paths,
    rng: &mut Xoshiro256PlusPlus,
) -> bool {
    if candidates.is_empty() {
        return false;
    }
    // At this stage a link costs something; one that costs the least possible needs no comparison.
    let least = matching.board.least_cost() as i32;
    let mut best: Option<(i32, (Node, Dir))> = None;
    let mut is_last = false;
    for _ in 0..=rng.next_u64() % 8 {
        let (node, dir) = candidates[below(rng, candidates.len())];
        let limit = best.map_or(i32::MAX / 2, |(cost, _)| cost);
        is_last = false;
        if let Some(cost) = paths.cost_of_link(matching, node, dir, limit) {
            best = Some((cost, (node, dir)));
            is_last = true;
            if cost <= least {
                break;
            }
        }
    }
    let Some((_, (node, dir))) = best else { return false };
    // What is put in is what was looked for last.
    if !is_last {
        paths.cost_of_link(matching, node, dir, i32::MAX / 2);
    }
    paths.put_in(matching, node, dir);
    matching.lock(node, dir);
    true
}

/// The groups that links hold together, and which of them are closed.
struct Closed {
    groups: Groups,
    /// For each group whether it is closed.
    shut: Vec<bool>,
    count: u32,
}

impl Closed {
    fn new(graph: &ZoneGraph, matching: &Matching<'_>) -> Self {
        let mut groups =
            Groups::new(graph, matching.board, |node, dir| matching.is_linked(node, dir));
        let mut shut = vec![true; graph.count() as usize];
        let mut count = groups.count();
        for &node in &matching.board.cells {
            if matching.room[node as usize] > 0 {
                let root = groups.root(graph.component(node)) as usize;
                count -= u32::from(shut[root]);
                shut[root] = false;
            }
        }
        Self { groups, shut, count }
    }

    /// The links that lead out of closed groups.
    fn outward(
        &mut self,
        graph: &ZoneGraph,
        matching: &Matching<'_>,
        links: &mut Vec<(Node, Dir)>,
    ) {
        links.clear();
        for &link in &graph.links {
            let (a, b) = self.groups.of_link(graph, matching.board, link);
            if a != b && (self.shut[a as usize] || self.shut[b as usize]) {
                links.push(link);
            }
        }
    }
}
