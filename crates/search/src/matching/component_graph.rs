//! Groups of cells that some links connect, and the links between the groups.

use super::board::{Board, Dir, Node, dirs};
use crate::disjoint_sets::DisjointSets;

/// The connected components of a board under a choice of *inner* links, and the graph that results
/// when each component is contracted to a vertex.
/// The edges of that graph are the other links.
///
/// With the links inside the zones as inner links, these are the zone components.
/// Components are numbered from 0 in the order of their first cells.
pub(crate) struct ComponentGraph {
    /// For each node its component; [`ComponentGraph::NONE`] for the padding.
    component: Vec<u32>,
    count: u32,
    /// The links that are not inner ones, named by their black cells.
    pub(crate) links: Vec<(Node, Dir)>,
    /// For each component the components that it shares links with, in ascending order; it may be
    /// one of them itself.
    pub(crate) neighbours: Vec<Vec<u32>>,
}

impl ComponentGraph {
    const NONE: u32 = u32::MAX;

    /// The zone components of a board.
    /// Linear in the cells.
    pub(crate) fn of_zones(board: &Board) -> Self {
        Self::new(board, |node, dir| board.across[node as usize] & (1 << dir) == 0)
    }

    /// The components under the links for which `is_inner` is true.
    /// It is called for a link from both of its cells, and has to return the same.
    /// Linear in the cells.
    pub(crate) fn new(board: &Board, is_inner: impl Fn(Node, Dir) -> bool) -> Self {
        let mut component = vec![Self::NONE; board.node_count()];
        let mut links = Vec::new();
        let mut count = 0;
        let mut stack = Vec::new();
        for &first in &board.cells {
            if Board::is_black(first) {
                let outer =
                    dirs(board.neighbours[first as usize]).filter(|&dir| !is_inner(first, dir));
                links.extend(outer.map(|dir| (first, dir)));
            }
            if component[first as usize] != Self::NONE {
                continue;
            }
            component[first as usize] = count;
            stack.push(first);
            while let Some(node) = stack.pop() {
                for dir in dirs(board.neighbours[node as usize]).filter(|&dir| is_inner(node, dir))
                {
                    let other = board.neighbour(node, dir);
                    if component[other as usize] == Self::NONE {
                        component[other as usize] = count;
                        stack.push(other);
                    }
                }
            }
            count += 1;
        }
        let mut neighbours = vec![Vec::new(); count as usize];
        for &(node, dir) in &links {
            let other = board.neighbour(node, dir);
            let (a, b) = (component[node as usize], component[other as usize]);
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        Self { component, count, links, neighbours }
    }

    /// Number of components.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// The component of a cell.
    pub(crate) fn component(&self, node: Node) -> u32 {
        self.component[node as usize]
    }
}

/// The components of a [`ComponentGraph`] in groups that some of the links between them connect.
pub(crate) struct Groups {
    sets: DisjointSets,
    count: u32,
}

impl Groups {
    /// Groups the components by the links for which `connects` is true.
    pub(crate) fn new(
        graph: &ComponentGraph,
        board: &Board,
        connects: impl Fn(Node, Dir) -> bool,
    ) -> Self {
        let mut sets = DisjointSets::new(graph.count as usize);
        let mut count = graph.count;
        for &(node, dir) in &graph.links {
            if connects(node, dir) {
                let other = board.neighbour(node, dir);
                count -= u32::from(sets.union(graph.component(node), graph.component(other)));
            }
        }
        Self { sets, count }
    }

    /// Number of groups.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// The group of a component, named by one of its components.
    pub(crate) fn group(&mut self, component: u32) -> u32 {
        self.sets.find(component)
    }

    /// The groups of the two cells of a link.
    pub(crate) fn of_link(
        &mut self,
        graph: &ComponentGraph,
        board: &Board,
        (node, dir): (Node, Dir),
    ) -> (u32, u32) {
        let other = board.neighbour(node, dir);
        (self.group(graph.component(node)), self.group(graph.component(other)))
    }
}
