//! What it costs that no set of cells may stay closed.

use crate::matching::{Board, Classes, Dir, Matching, Node, Paths, ZoneGraph};

/// Searches for the cheapest link out of a component, at most; beyond it the extra cost counts as
/// the least possible.
const MOST_SEARCHES: u32 = 200;

/// What a cover costs more at least where anything is apart, for costs are whole numbers.
pub(crate) const LEAST: u32 = 1;

/// What the cheapest 2-matchings of one size never link, though a cover must.
pub(crate) struct Apart {
    /// The components that all links of all cheapest 2-matchings make.
    components: ZoneGraph,
    /// The zone components, finer: without the links that no cheapest 2-matching has.
    pub(crate) graph: ZoneGraph,
}

impl Apart {
    /// Takes all links that some cheapest 2-matching has: those in this one, and those whose
    /// residual step is free of reduced cost and lies on a closed walk of such steps, by
    /// complementary slackness.
    /// `None` if a cover need not cost more.
    pub(crate) fn new(matching: &Matching<'_>, pieces: u32) -> Option<Self> {
        let board = matching.board;
        let classes = Classes::new(matching);
        let allowed = Allowed { matching, classes: &classes };
        let components = ZoneGraph::of(board, |node, dir| allowed.link(node, dir));
        if closed_sets(&components, &allowed, pieces).is_empty() {
            return None;
        }
        let inside = |node: Node, dir: Dir| board.across[node as usize] & (1 << dir) == 0;
        let graph = ZoneGraph::of(board, |node, dir| allowed.link(node, dir) && inside(node, dir));
        Some(Self { components, graph })
    }
}

/// By how much a path, or a cover in `pieces` pieces, costs more than the cheapest 2-matching, at
/// least.
///
/// A path leaves each of the components, by a link that no cheapest 2-matching has.
/// The cheapest way to have such a link is a shortest residual walk through it, and the component
/// where that is dearest counts.
/// Of several pieces one may stay inside a component, so there only components count in which no
/// cheapest 2-matching has room for an end; that costs at least 1, for costs are whole numbers.
pub(crate) fn connectivity(
    apart: &Apart,
    matching: &Matching<'_>,
    pieces: u32,
    paths: &mut Paths,
) -> u32 {
    if pieces == 1 { dearest(&apart.components, matching, paths) } else { LEAST }
}

/// What some cheapest 2-matching of the same size has.
pub(super) struct Allowed<'m, 'a> {
    pub(super) matching: &'m Matching<'a>,
    pub(super) classes: &'m Classes,
}

impl Allowed<'_, '_> {
    /// Whether one has this link.
    pub(super) fn link(&self, node: Node, dir: Dir) -> bool {
        let Self { matching, classes } = self;
        let other = matching.board.step(node, dir);
        matching.is_linked(node, dir)
            || (matching.reduced(node, dir) == 0 && classes.of(node) == classes.of(other))
    }
}

/// The components that a cover in so many pieces has to leave but this 2-matching does not: with
/// one piece those that hold no end, with several those that can hold none.
pub(super) fn closed_sets(
    graph: &ZoneGraph,
    allowed: &Allowed<'_, '_>,
    pieces: u32,
) -> Vec<Vec<Node>> {
    if graph.count() == 1 {
        return Vec::new();
    }
    let board: &Board = allowed.matching.board;
    let mut sets = vec![Vec::new(); graph.count() as usize];
    let mut is_closed = vec![true; graph.count() as usize];
    for &node in &board.cells {
        let component = graph.component(node) as usize;
        sets[component].push(node);
        let has_room = allowed.matching.room[node as usize] > 0;
        if has_room || (pieces > 1 && allowed.classes.may_have_room(allowed.matching, node)) {
            is_closed[component] = false;
        }
    }
    sets.into_iter()
        .zip(is_closed)
        .filter(|(_, is_closed)| *is_closed)
        .map(|(set, _)| set)
        .collect()
}

/// The cost of the cheapest link out of a component, for the component where it is dearest.
fn dearest(graph: &ZoneGraph, matching: &Matching<'_>, paths: &mut Paths) -> u32 {
    const NONE: i32 = i32::MAX / 4;

    let mut cheapest = vec![NONE; graph.count() as usize];
    let mut searches_left = MOST_SEARCHES;
    for &(node, dir) in &graph.links {
        let other = matching.board.step(node, dir);
        let (a, b) = (graph.component(node) as usize, graph.component(other) as usize);
        let limit = cheapest[a].max(cheapest[b]);
        if a == b || limit <= LEAST as i32 {
            continue;
        }
        if searches_left == 0 {
            return LEAST;
        }
        searches_left -= 1;
        if let Some(cost) = paths.cost_of_link(matching, node, dir, limit) {
            cheapest[a] = cheapest[a].min(cost);
            cheapest[b] = cheapest[b].min(cost);
        }
    }
    // A component without a way out at any cost is no matter of costs: then there is no cover in so
    // few pieces.
    let known = cheapest.into_iter().filter(|&cost| cost < NONE);
    known.max().map_or(LEAST, |dearest| dearest as u32).max(LEAST)
}
