//! The zone components of a board and how they touch.

use super::board::{Board, Dir, Node, dirs};
use crate::union::Union;

/// Zone components, numbered in the order of their first cells, and the links between them.
pub(crate) struct ZoneGraph {
    component: Vec<u32>,
    count: u32,
    /// The links that cross, from their black cells.
    pub(crate) links: Vec<(Node, Dir)>,
    /// For each component those it touches, rising.
    pub(crate) neighbours: Vec<Vec<u32>>,
}

impl ZoneGraph {
    const NONE: u32 = u32::MAX;

    /// Linear in the cells.
    pub(crate) fn new(board: &Board) -> Self {
        Self::of(board, |node, dir| board.across[node as usize] & (1 << dir) == 0)
    }

    /// Components held together by some links, which are asked for from either cell.
    pub(crate) fn of(board: &Board, inner: impl Fn(Node, Dir) -> bool) -> Self {
        let mut component = vec![Self::NONE; board.nodes()];
        let mut links = Vec::new();
        let mut count = 0;
        let mut open = Vec::new();
        for &first in &board.cells {
            if Board::is_black(first) {
                let outer =
                    dirs(board.neighbours[first as usize]).filter(|&dir| !inner(first, dir));
                links.extend(outer.map(|dir| (first, dir)));
            }
            if component[first as usize] != Self::NONE {
                continue;
            }
            component[first as usize] = count;
            open.push(first);
            while let Some(node) = open.pop() {
                for dir in dirs(board.neighbours[node as usize]).filter(|&dir| inner(node, dir)) {
                    let other = board.step(node, dir);
                    if component[other as usize] == Self::NONE {
                        component[other as usize] = count;
                        open.push(other);
                    }
                }
            }
            count += 1;
        }
        let mut neighbours = vec![Vec::new(); count as usize];
        for &(node, dir) in &links {
            let (a, b) = (component[node as usize], component[board.step(node, dir) as usize]);
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

/// Zone components held together by some of the links between them.
pub(crate) struct Groups {
    union: Union,
    count: u32,
}

impl Groups {
    pub(crate) fn new(graph: &ZoneGraph, board: &Board, holds: impl Fn(Node, Dir) -> bool) -> Self {
        let mut groups = Self { union: Union::new(graph.count as usize), count: graph.count };
        for &(node, dir) in &graph.links {
            if holds(node, dir) {
                let other = board.step(node, dir);
                groups.count -=
                    u32::from(groups.union.unite(graph.component(node), graph.component(other)));
            }
        }
        groups
    }

    /// Number of groups.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// The groups of the two cells of a link.
    pub(crate) fn of_link(
        &mut self,
        graph: &ZoneGraph,
        board: &Board,
        (node, dir): (Node, Dir),
    ) -> (u32, u32) {
        let other = board.step(node, dir);
        (self.root(graph.component(node)), self.root(graph.component(other)))
    }

    /// The group of a component, by the number of one of its components.
    pub(crate) fn root(&mut self, component: u32) -> u32 {
        self.union.root(component)
    }
}
