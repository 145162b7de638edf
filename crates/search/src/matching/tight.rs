//! What the cheapest 2-matchings have in common.

use super::board::{Board, Node};
use super::flow::{Matching, directions, step_cost};

/// The strongly connected classes of the residual steps of reduced cost 0, the source and the sink
/// included.
///
/// Any two cheapest 2-matchings of one size differ by closed walks of such steps (complementary
/// slackness), so a link that is not there can be put in at no cost exactly if its step is free of
/// reduced cost and both of its cells are of one class.
/// Tarjan (1972); linear in the cells.
pub(crate) struct Classes {
    class: Vec<u32>,
    /// Those of the source and the sink.
    source: u32,
    sink: u32,
}

impl Classes {
    pub(crate) fn new(matching: &Matching<'_>) -> Self {
        Tarjan::new(matching).run()
    }

    pub(crate) fn of(&self, node: Node) -> u32 {
        self.class[node as usize]
    }

    /// Whether the cell has room, or can have at no cost.
    pub(crate) fn may_have_room(&self, matching: &Matching<'_>, node: Node) -> bool {
        let free = if Board::is_black(node) {
            matching.potential[node as usize] == matching.source && self.of(node) == self.source
        } else {
            matching.potential[node as usize] == matching.sink && self.of(node) == self.sink
        };
        matching.room[node as usize] > 0 || free
    }
}

struct Tarjan<'m, 'a> {
    matching: &'m Matching<'a>,
    source: Node,
    sink: Node,
    /// Order of discovery, from 1; 0 if not yet seen.
    seen: Vec<u32>,
    low: Vec<u32>,
    class: Vec<u32>,
    open: Vec<Node>,
    next: u32,
    classes: u32,
}

impl<'m, 'a> Tarjan<'m, 'a> {
    const NONE: u32 = u32::MAX;

    fn new(matching: &'m Matching<'a>) -> Self {
        let source = matching.board.nodes() as Node;
        let size = source as usize + 2;
        Self {
            matching,
            source,
            sink: source + 1,
            seen: vec![0; size],
            low: vec![0; size],
            class: vec![Self::NONE; size],
            open: Vec::new(),
            next: 0,
            classes: 0,
        }
    }

    fn run(mut self) -> Classes {
        let terminals = [self.source, self.sink];
        for &first in self.matching.board.cells.iter().chain(&terminals) {
            if self.seen[first as usize] == 0 {
                self.search(first);
            }
        }
        let [source, sink] = [self.source, self.sink].map(|node| self.class[node as usize]);
        Classes { class: self.class, source, sink }
    }

    /// Depth-first, with the nodes on the way on a stack of its own: boards are larger than the
    /// call stack.
    fn search(&mut self, first: Node) {
        self.enter(first);
        let mut way = vec![(first, 0)];
        while let Some((node, cursor)) = way.last_mut() {
            let node = *node;
            if let Some(next) = self.ahead(node, cursor) {
                if self.seen[next as usize] == 0 {
                    self.enter(next);
                    way.push((next, 0));
                } else if self.class[next as usize] == Self::NONE {
                    self.low[node as usize] = self.low[node as usize].min(self.seen[next as usize]);
                }
                continue;
            }
            way.pop();
            if let Some(&(before, _)) = way.last() {
                self.low[before as usize] = self.low[before as usize].min(self.low[node as usize]);
            }
            if self.low[node as usize] == self.seen[node as usize] {
                while let Some(member) = self.open.pop() {
                    self.class[member as usize] = self.classes;
                    if member == node {
                        break;
                    }
                }
                self.classes += 1;
            }
        }
    }

    fn enter(&mut self, node: Node) {
        self.next += 1;
        self.seen[node as usize] = self.next;
        self.low[node as usize] = self.next;
        self.open.push(node);
    }

    /// The next node that a step of reduced cost 0 leads to; the cursor counts what was looked at:
    /// directions and then the source or sink from a cell, cells from these two.
    fn ahead(&self, node: Node, cursor: &mut usize) -> Option<Node> {
        let m = self.matching;
        if node >= self.source {
            let leads = |cell: Node| {
                if node == self.source {
                    Board::is_black(cell)
                        && m.room[cell as usize] > 0
                        && m.potential[cell as usize] == m.source
                } else {
                    !Board::is_black(cell)
                        && m.capacity[cell as usize] > m.room[cell as usize]
                        && m.potential[cell as usize] == m.sink
                }
            };
            let skipped = m.board.cells[*cursor..].iter().position(|&cell| leads(cell))?;
            *cursor += skipped + 1;
            return Some(m.board.cells[*cursor - 1]);
        }
        let forward = directions(m, node);
        while *cursor < 4 {
            let dir = *cursor;
            *cursor += 1;
            if forward & (1 << dir) != 0 && step_cost(m, node, dir) == 0 {
                return Some(m.board.step(node, dir));
            }
        }
        if *cursor > 4 {
            return None;
        }
        *cursor += 1;
        let potential = m.potential[node as usize];
        if Board::is_black(node) {
            let gives = m.capacity[node as usize] > m.room[node as usize] && potential == m.source;
            gives.then_some(self.source)
        } else {
            (m.room[node as usize] > 0 && potential == m.sink).then_some(self.sink)
        }
    }
}
