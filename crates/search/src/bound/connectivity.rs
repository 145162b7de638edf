//! The bound by connectivity: a path may need links that no cheapest 2-matching has.
//!
//! Take all links that occur in some cheapest 2-matching of the required size.
//! If these links together do not connect all cells, every cheapest 2-matching leaves the same
//! components unconnected, so none of them is a path, and a path costs more.
//! The difference is at least the cost of inserting a link that leaves such a component.

use crate::matching::{Board, ComponentGraph, Dir, Node, ShortestPaths, TightClasses, TwoMatching};

/// Maximum number of shortest-path searches for links that leave a component.
const MAX_SEARCHES: u32 = 200;

/// The minimum difference between two different costs: they are whole numbers.
pub(crate) const MIN_EXTRA_COST: u32 = 1;

/// The components that all cheapest 2-matchings of one size leave unconnected.
pub(crate) struct Separation {
    /// The components that all links of all cheapest 2-matchings form.
    components: ComponentGraph,
    /// The zone components, divided further: without the links that occur in no cheapest
    /// 2-matching.
    /// Its links are those that a cover needs and that 2-matchings tend to lack.
    pub(crate) graph: ComponentGraph,
}

impl Separation {
    /// Finds the components; `None` if none of them is closed ([`closed_components`]).
    /// Linear in the cells.
    pub(crate) fn find(matching: &TwoMatching<'_>, pieces: u32) -> Option<Self> {
        let board = matching.board;
        let classes = TightClasses::new(matching);
        let optimal = OptimalLinks { matching, classes: &classes };
        let components = ComponentGraph::new(board, |node, dir| optimal.contains(node, dir));
        if closed_components(&components, &optimal, pieces).is_empty() {
            return None;
        }
        let inside = |node: Node, dir: Dir| board.across[node as usize] & (1 << dir) == 0;
        let graph = ComponentGraph::new(board, |node, dir| {
            optimal.contains(node, dir) && inside(node, dir)
        });
        Some(Self { components, graph })
    }

    /// Lower bound on the extra cost of a cover with `pieces` pieces over the cheapest 2-matching.
    ///
    /// With one piece, the path connects all cells, so it leaves each component by a link that
    /// occurs in no cheapest 2-matching.
    /// It costs at least as much as the cheapest 2-matching with such a link.
    /// This holds for each component, and so for the one where it costs most.
    ///
    /// With several pieces, one of them may stay inside a component, but only if it can have its
    /// ends there.
    /// A closed component can't hold the ends of a piece at minimum cost, so a cover costs at least
    /// [`MIN_EXTRA_COST`] more.
    pub(crate) fn extra_cost(
        &self,
        matching: &TwoMatching<'_>,
        pieces: u32,
        paths: &mut ShortestPaths,
    ) -> u32 {
        if pieces == 1 { max_exit_cost(&self.components, matching, paths) } else { MIN_EXTRA_COST }
    }
}

/// The links that occur in some cheapest 2-matching of one size.
pub(super) struct OptimalLinks<'m, 'a> {
    /// One of these 2-matchings.
    pub(super) matching: &'m TwoMatching<'a>,
    pub(super) classes: &'m TightClasses,
}

impl OptimalLinks<'_, '_> {
    /// Whether the link from a cell in a direction is one of them.
    pub(super) fn contains(&self, node: Node, dir: Dir) -> bool {
        let Self { matching, classes } = self;
        let other = matching.board.neighbour(node, dir);
        matching.is_linked(node, dir)
            || (matching.reduced_cost(node, dir) == 0
                && classes.class(node) == classes.class(other))
    }
}

/// The cells of each component that is *closed*: a cover with this number of pieces has to leave
/// it, but the cheapest 2-matchings do not.
///
/// With one piece these are the components without room for an end in the present 2-matching, with
/// several pieces those without room in any cheapest one.
/// Empty if there is only one component.
pub(super) fn closed_components(
    components: &ComponentGraph,
    optimal: &OptimalLinks<'_, '_>,
    pieces: u32,
) -> Vec<Vec<Node>> {
    if components.count() == 1 {
        return Vec::new();
    }
    let OptimalLinks { matching, classes } = optimal;
    let board: &Board = matching.board;
    let mut cells = vec![Vec::new(); components.count() as usize];
    let mut is_closed = vec![true; components.count() as usize];
    for &node in &board.cells {
        let component = components.component(node) as usize;
        cells[component].push(node);
        if matching.has_room(node) || (pieces > 1 && classes.may_have_room(matching, node)) {
            is_closed[component] = false;
        }
    }
    cells
        .into_iter()
        .zip(is_closed)
        .filter(|(_, is_closed)| *is_closed)
        .map(|(cells, _)| cells)
        .collect()
}

/// The cost of the cheapest link out of a component, maximized over the components.
///
/// If more than [`MAX_SEARCHES`] searches would be needed, the result is [`MIN_EXTRA_COST`].
fn max_exit_cost(
    components: &ComponentGraph,
    matching: &TwoMatching<'_>,
    paths: &mut ShortestPaths,
) -> u32 {
    const UNKNOWN: i32 = i32::MAX / 4;

    let mut cheapest = vec![UNKNOWN; components.count() as usize];
    let mut searches_left = MAX_SEARCHES;
    for &(node, dir) in &components.links {
        let other = matching.board.neighbour(node, dir);
        let (a, b) = (components.component(node) as usize, components.component(other) as usize);
        // A link that is not cheaper than both known exits changes nothing, and no exit costs less
        // than the minimum.
        let limit = cheapest[a].max(cheapest[b]);
        if a == b || limit <= MIN_EXTRA_COST as i32 {
            continue;
        }
        if searches_left == 0 {
            return MIN_EXTRA_COST;
        }
        searches_left -= 1;
        if let Some(cost) = paths.insertion_cost(matching, node, dir, limit) {
            cheapest[a] = cheapest[a].min(cost);
            cheapest[b] = cheapest[b].min(cost);
        }
    }
    // A component without an exit at any cost shows that there is no cover with so few pieces.
    // Proving that is the task of the bounds on pieces, so such a component is ignored here.
    let known = cheapest.into_iter().filter(|&cost| cost < UNKNOWN);
    known.max().map_or(MIN_EXTRA_COST, |cost| cost as u32).max(MIN_EXTRA_COST)
}
