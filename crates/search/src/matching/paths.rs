//! Cheapest exchanges: one link put in, or an optimum restored after its costs have changed.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::board::{Board, Dir, Node, dirs};
use super::flow::{Matching, step_cost, steps};

/// A search for shortest residual paths; kept between searches to spare allocations.
///
/// Beside the cells there are the **source**, from which black cells draw, and the **sink**, into
/// which white cells drain: a path through one of them moves room from one cell to another.
pub(crate) struct Paths {
    round: u32,
    /// Of each node and then of the source, the sink and the end of the search.
    labels: Vec<Label>,
    reached: Vec<Node>,
    later: BinaryHeap<Reverse<(i32, Node)>>,
    /// Length of the paths that are being extended.
    length: i32,
    /// The steps taken by the last exchange.
    taken: Vec<(Node, Node)>,
    source: Node,
    sink: Node,
}

#[derive(Clone, Copy, Default)]
struct Label {
    round: u32,
    length: i32,
    before: Node,
    is_final: bool,
}

impl Paths {
    pub(crate) fn new(board: &Board) -> Self {
        let source = board.nodes() as Node;
        Self {
            round: 0,
            labels: Vec::new(),
            reached: Vec::new(),
            later: BinaryHeap::new(),
            length: 0,
            taken: Vec::new(),
            source,
            sink: source + 1,
        }
    }

    /// What it adds to the cost at least to have the link from this black cell in this direction,
    /// if that is below `limit`.
    ///
    /// The exchange leads from the link's white cell back to its black one.
    /// It visits what is nearer than the limit.
    pub(crate) fn cost_of_link(
        &mut self,
        matching: &Matching<'_>,
        black: Node,
        dir: Dir,
        limit: i32,
    ) -> Option<i32> {
        let link = matching.reduced(black, dir);
        let white = matching.board.step(black, dir);
        self.shortest(matching, &[(white, 0)], |node| (node == black).then_some(0), limit - link)?;
        Some(self.length + link)
    }

    /// Puts in the link whose cost was found last.
    pub(crate) fn put_in(&mut self, matching: &mut Matching<'_>, black: Node, dir: Dir) {
        self.take(matching);
        matching.toggle(black, dir);
    }

    /// Takes back the last link put in, which must have cost nothing: then the potentials are as
    /// they were.
    pub(crate) fn undo(&mut self, matching: &mut Matching<'_>, black: Node, dir: Dir) {
        self.taken.iter_mut().for_each(|(from, to)| std::mem::swap(from, to));
        self.toggle_taken(matching);
        matching.toggle(black, dir);
    }

    /// Moves room to one of these cells, the cheapest, and keeps it there for good: its path ends
    /// there.
    /// Gives what that adds to the cost, and the cell; `None`, and nothing changes, if no cell can
    /// have room.
    ///
    /// A cell that gives up a link gets room, and the link moves on along a shortest path to a cell
    /// of its colour that has room.
    /// Two searches, one for each colour.
    pub(crate) fn reserve(
        &mut self,
        matching: &mut Matching<'_>,
        cells: &[Node],
    ) -> Option<(i32, Node)> {
        let free = |&&cell: &&Node| matching.capacity[cell as usize] == 2;
        let with_room = cells.iter().filter(free).find(|&&cell| matching.room[cell as usize] > 0);
        let (cost, cell) = if let Some(&cell) = with_room {
            (0, cell)
        } else {
            let (blacks, whites): (Vec<Node>, Vec<Node>) =
                cells.iter().filter(free).partition(|&&cell| Board::is_black(cell));
            let black = self.cheapest_room(matching, &blacks, i32::MAX / 2);
            let white =
                self.cheapest_room(matching, &whites, black.map_or(i32::MAX / 2, |(cost, _)| cost));
            if white.is_none() {
                self.cheapest_room(matching, &blacks, i32::MAX / 2);
            }
            let (cost, cell) = white.or(black)?;
            self.take(matching);
            matching.room[cell as usize] += 1;
            (cost, cell)
        };
        matching.capacity[cell as usize] -= 1;
        matching.room[cell as usize] -= 1;
        matching.spare -= 1;
        Some((cost, cell))
    }

    /// The one of these cells, all of one colour and without room, that gets room at the least
    /// cost, below the limit.
    fn cheapest_room(
        &mut self,
        matching: &Matching<'_>,
        cells: &[Node],
        limit: i32,
    ) -> Option<(i32, Node)> {
        let end = self.end();
        let is_black = Board::is_black(*cells.first()?);
        // A black cell draws one less, at the end of the path; a white one drains one less, at its
        // beginning.
        let less = |cell: Node| {
            let potential = matching.potential[cell as usize];
            if is_black { potential - matching.source } else { matching.sink - potential }
        };
        if is_black {
            let closes = |node: Node| cells.contains(&node).then(|| less(node));
            self.shortest(matching, &[(self.source, 0)], closes, limit)?;
            Some((self.length, self.labels[end as usize].before))
        } else {
            let starts: Vec<(Node, i32)> = cells.iter().map(|&cell| (cell, less(cell))).collect();
            let sink = self.sink;
            self.shortest(matching, &starts, |node| (node == sink).then_some(0), limit)?;
            let mut first = sink;
            while self.labels[first as usize].before != first {
                first = self.labels[first as usize].before;
            }
            Some((self.length, first))
        }
    }

    /// The node at which every search ends.
    fn end(&self) -> Node {
        self.sink + 1
    }

    /// Makes a 2-matching the cheapest of its size again after costs have changed.
    ///
    /// Links whose reduced cost has the wrong sign go in or out; each cell that this leaves with a
    /// link too many or too few begins or ends a shortest path along which the surplus moves on.
    /// O(cells) for each such cell at most.
    pub(crate) fn repair(&mut self, matching: &mut Matching<'_>) {
        let mut excess = self.saturate(matching);
        let nodes = matching.board.cells.iter().copied().chain([self.source, self.sink]);
        for node in nodes.collect::<Vec<_>>() {
            while excess[node as usize] > 0 {
                let closes = |end: Node| (excess[end as usize] < 0).then_some(0);
                self.shortest(matching, &[(node, 0)], closes, i32::MAX / 2)
                    .expect("what one cell has too many another one has too few");
                let end = self.labels[self.end() as usize].before;
                excess[node as usize] -= 1;
                excess[end as usize] += 1;
                self.take(matching);
            }
        }
        matching.spare = matching.room.iter().map(|&room| u32::from(room)).sum();
    }

    /// Puts links of negative reduced cost in and takes those of positive cost out; gives what each
    /// node has too many.
    fn saturate(&self, matching: &mut Matching<'_>) -> Vec<i32> {
        let board = matching.board;
        let mut excess = vec![0; board.nodes() + 2];
        let blacks = || board.cells.iter().copied().filter(|&node| Board::is_black(node));
        let whites = || board.cells.iter().copied().filter(|&node| !Board::is_black(node));
        for black in blacks() {
            for dir in dirs(board.neighbours[black as usize]) {
                let reduced = matching.reduced(black, dir);
                let is_linked = matching.is_linked(black, dir);
                if if is_linked { reduced > 0 } else { reduced < 0 } {
                    matching.toggle(black, dir);
                    let surplus = if is_linked { 1 } else { -1 };
                    excess[black as usize] += surplus;
                    excess[board.step(black, dir) as usize] -= surplus;
                }
            }
        }
        // With these two no cell can want to give back what it draws; some may want to draw more.
        matching.source = blacks().map(|node| matching.potential[node as usize]).min().unwrap_or(0);
        matching.sink = whites().map(|node| matching.potential[node as usize]).max().unwrap_or(0);
        for node in blacks().filter(|&node| matching.potential[node as usize] > matching.source) {
            let room = i32::from(std::mem::take(&mut matching.room[node as usize]));
            excess[node as usize] += room;
            excess[self.source as usize] -= room;
        }
        for node in whites().filter(|&node| matching.potential[node as usize] < matching.sink) {
            let room = i32::from(std::mem::take(&mut matching.room[node as usize]));
            excess[node as usize] -= room;
            excess[self.sink as usize] += room;
        }
        excess
    }

    /// Dijkstra from some nodes, each at a length of its own, to the node at which all ends:
    /// reached from those that give what that adds to the length.
    /// `None` if it is not nearer than the limit.
    fn shortest(
        &mut self,
        matching: &Matching<'_>,
        starts: &[(Node, i32)],
        closes: impl Fn(Node) -> Option<i32>,
        limit: i32,
    ) -> Option<()> {
        let end = self.end();
        // Only now, for most layers need no search at all.
        self.labels.resize(end as usize + 1, Label::default());
        self.round += 1;
        self.reached.clear();
        self.later.clear();
        self.length = 0;
        if limit <= 0 {
            return None;
        }
        for &(node, length) in starts {
            self.see(node, node, length);
        }
        let mut next = 0;
        loop {
            while let Some(&node) = self.reached.get(next) {
                next += 1;
                if node == end {
                    return Some(());
                }
                if let Some(more) = closes(node) {
                    self.see(end, node, self.length + more);
                    // Nothing is nearer than what is reached at no further cost.
                    if more == 0 {
                        return Some(());
                    }
                }
                self.expand(matching, node);
            }
            loop {
                let Reverse((length, node)) = self.later.pop()?;
                if length >= limit {
                    return None;
                }
                let label = &mut self.labels[node as usize];
                if !label.is_final && label.length == length {
                    label.is_final = true;
                    self.length = length;
                    self.reached.push(node);
                    break;
                }
            }
        }
    }

    fn expand(&mut self, matching: &Matching<'_>, node: Node) {
        let length = self.length;
        let draws = |cell: Node| matching.capacity[cell as usize] > matching.room[cell as usize];
        if node == self.source {
            for &black in matching.board.cells.iter().filter(|&&cell| Board::is_black(cell)) {
                if matching.room[black as usize] > 0 {
                    self.see(
                        black,
                        node,
                        length + matching.source - matching.potential[black as usize],
                    );
                }
            }
        } else if node == self.sink {
            for &white in matching.board.cells.iter().filter(|&&cell| !Board::is_black(cell)) {
                if draws(white) {
                    self.see(
                        white,
                        node,
                        length + matching.sink - matching.potential[white as usize],
                    );
                }
            }
        } else {
            for dir in steps(matching, node) {
                self.see(
                    matching.board.step(node, dir),
                    node,
                    length + step_cost(matching, node, dir),
                );
            }
            let potential = matching.potential[node as usize];
            if !Board::is_black(node) {
                if matching.room[node as usize] > 0 {
                    self.see(self.sink, node, length + potential - matching.sink);
                }
            } else if draws(node) {
                self.see(self.source, node, length + potential - matching.source);
            }
        }
    }

    #[inline]
    fn see(&mut self, node: Node, before: Node, length: i32) {
        let label = &mut self.labels[node as usize];
        if label.round == self.round && (label.is_final || label.length <= length) {
            return;
        }
        // Reduced costs are negative only where a locked link was exchanged; then the path found
        // may not be the shortest, which a search for a good cover can bear.
        let length = length.max(self.length);
        let is_final = length == self.length;
        *label = Label { round: self.round, length, before, is_final };
        if is_final {
            self.reached.push(node);
        } else {
            self.later.push(Reverse((length, node)));
        }
    }

    /// Exchanges along the path found last, and makes its steps free of reduced cost.
    fn take(&mut self, matching: &mut Matching<'_>) {
        let end = self.end();
        self.taken.clear();
        // What is beyond the last node is no step but the caller's.
        let mut node = self.labels[end as usize].before;
        while self.labels[node as usize].before != node {
            let before = self.labels[node as usize].before;
            self.taken.push((before, node));
            node = before;
        }
        self.toggle_taken(matching);
        for &node in self.reached.iter().filter(|&&node| node != end) {
            let length = self.labels[node as usize].length;
            let potential = match node {
                _ if node == self.source => &mut matching.source,
                _ if node == self.sink => &mut matching.sink,
                _ => &mut matching.potential[node as usize],
            };
            *potential += length - self.length;
        }
    }

    fn toggle_taken(&self, matching: &mut Matching<'_>) {
        for &(from, to) in &self.taken {
            if to == self.source {
                matching.room[from as usize] += 1;
            } else if from == self.source {
                matching.room[to as usize] -= 1;
            } else if to == self.sink {
                matching.room[from as usize] -= 1;
            } else if from == self.sink {
                matching.room[to as usize] += 1;
            } else {
                let towards = (0..4).find(|&dir| matching.board.step(from, dir) == to);
                matching.toggle(from, towards.expect("a step leads to a neighbour"));
            }
        }
    }
}
