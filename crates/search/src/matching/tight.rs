//! Links that occur in some cheapest 2-matching of one size.
//!
//! An arc of the residual graph is *tight* if its reduced cost is 0. By complementary slackness,
//! two cheapest 2-matchings of the same size differ by cycles of tight arcs: the cycles' reduced
//! costs sum to 0, and none is negative.
//! Conversely, exchanging along any cycle of tight arcs gives another cheapest 2-matching.
//! So a link occurs in some cheapest 2-matching exactly if it is in the present one, or its arc is
//! tight and lies on a cycle of tight arcs.
//! The latter is the case exactly if both of its cells are in the same strongly connected component
//! of the graph of tight arcs, here called a *class*.

use super::board::{Board, Node};
use super::two_matching::TwoMatching;

/// The strongly connected components of the tight arcs, source and sink included.
pub(crate) struct TightClasses {
    /// For each node its class.
    class: Vec<u32>,
    source: u32,
    sink: u32,
}

impl TightClasses {
    /// Finds the classes by Tarjan's method (1972).
    /// Linear in the cells.
    pub(crate) fn new(matching: &TwoMatching<'_>) -> Self {
        Tarjan::new(matching).run()
    }

    /// The class of a cell.
    pub(crate) fn class(&self, node: Node) -> u32 {
        self.class[node as usize]
    }

    /// Whether a cell has room in some cheapest 2-matching of the same size.
    ///
    /// A cell gets room by the arc that takes a link from it, to the source or from the sink.
    pub(crate) fn may_have_room(&self, matching: &TwoMatching<'_>, node: Node) -> bool {
        let terminal = if Board::is_black(node) { self.source } else { self.sink };
        let can_release = matching.release_cost(node) == 0 && self.class(node) == terminal;
        matching.has_room(node) || can_release
    }
}

/// Tarjan's depth-first search for strongly connected components.
///
/// Nodes are numbered in the order of their discovery.
/// `low` is the smallest number known to be reachable from a node within its component.
/// When the search leaves a node whose `low` is its own number, the node is the first one of its
/// component, which consists of all nodes above it on the stack.
struct Tarjan<'m, 'a> {
    matching: &'m TwoMatching<'a>,
    /// The number of the source, after those of the nodes.
    source: Node,
    /// The number of the sink.
    sink: Node,
    /// For each node its number in the order of discovery, from 1; 0 if not discovered yet.
    discovery: Vec<u32>,
    low: Vec<u32>,
    /// For each node its class; [`Tarjan::NONE`] if not known yet.
    class: Vec<u32>,
    /// Discovered nodes whose class is not known yet.
    stack: Vec<Node>,
    discovered: u32,
    classes: u32,
}

impl<'m, 'a> Tarjan<'m, 'a> {
    const NONE: u32 = u32::MAX;

    fn new(matching: &'m TwoMatching<'a>) -> Self {
        let source = matching.board.node_count() as Node;
        let size = source as usize + 2;
        Self {
            matching,
            source,
            sink: source + 1,
            discovery: vec![0; size],
            low: vec![0; size],
            class: vec![Self::NONE; size],
            stack: Vec::new(),
            discovered: 0,
            classes: 0,
        }
    }

    fn run(mut self) -> TightClasses {
        let terminals = [self.source, self.sink];
        for &first in self.matching.board.cells.iter().chain(&terminals) {
            if self.discovery[first as usize] == 0 {
                self.search(first);
            }
        }
        let [source, sink] = [self.source, self.sink].map(|node| self.class[node as usize]);
        TightClasses { class: self.class, source, sink }
    }

    /// Searches from one node.
    ///
    /// Not recursive, because a path of tight arcs may be longer than the call stack allows:
    /// `branch` holds the nodes from the first to the present one, each with a cursor over its
    /// arcs.
    fn search(&mut self, first: Node) {
        self.discover(first);
        let mut branch = vec![(first, 0)];
        while let Some((node, cursor)) = branch.last_mut() {
            let node = *node;
            if let Some(next) = self.next_end(node, cursor) {
                if self.discovery[next as usize] == 0 {
                    self.discover(next);
                    branch.push((next, 0));
                } else if self.class[next as usize] == Self::NONE {
                    self.low[node as usize] =
                        self.low[node as usize].min(self.discovery[next as usize]);
                }
                continue;
            }
            branch.pop();
            if let Some(&(parent, _)) = branch.last() {
                self.low[parent as usize] = self.low[parent as usize].min(self.low[node as usize]);
            }
            if self.low[node as usize] == self.discovery[node as usize] {
                while let Some(member) = self.stack.pop() {
                    self.class[member as usize] = self.classes;
                    if member == node {
                        break;
                    }
                }
                self.classes += 1;
            }
        }
    }

    fn discover(&mut self, node: Node) {
        self.discovered += 1;
        self.discovery[node as usize] = self.discovered;
        self.low[node as usize] = self.discovered;
        self.stack.push(node);
    }

    /// The end of the next tight arc from a node; `None` after the last one.
    ///
    /// The cursor, 0 at first, is the number of arcs examined: from a cell those in the four
    /// directions and then the one to the source or sink; from source and sink those to all cells.
    fn next_end(&self, node: Node, cursor: &mut usize) -> Option<Node> {
        let Self { matching, source, sink, .. } = *self;
        if node >= source {
            let is_end = |cell: Node| {
                let exists = if node == source {
                    Board::is_black(cell) && matching.has_room(cell)
                } else {
                    !Board::is_black(cell) && matching.has_links(cell)
                };
                exists && matching.release_cost(cell) == 0
            };
            let cells = &matching.board.cells;
            let skipped = cells[*cursor..].iter().position(|&cell| is_end(cell))?;
            *cursor += skipped + 1;
            return Some(cells[*cursor - 1]);
        }
        let arcs = matching.arcs_from(node);
        while *cursor < 4 {
            let dir = *cursor;
            *cursor += 1;
            if arcs & (1 << dir) != 0 && matching.arc_cost(node, dir) == 0 {
                return Some(matching.board.neighbour(node, dir));
            }
        }
        if *cursor > 4 {
            return None;
        }
        *cursor += 1;
        let (exists, terminal) = if Board::is_black(node) {
            (matching.has_links(node), source)
        } else {
            (matching.has_room(node), sink)
        };
        (exists && matching.release_cost(node) == 0).then_some(terminal)
    }
}
