//! Cheapest exchanges: one link put in, or an optimum restored after its costs have changed.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rand::Rng;

use super::board::{Board, Dir, Node, dirs};
use super::flow::{Matching, step_cost, steps};

/// A search for shortest residual paths; kept between searches to spare allocations.
///
/// Beside the cells there are the **source**, from which black cells draw, and the **sink**, into which white cells drain: a
/// path through one of them moves room from one cell to another.
pub(crate) struct Paths {
    round: u32,
    /// Of each node and then of the source and the sink.
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
            labels: vec![Label::default(); board.nodes() + 2],
            reached: Vec::new(),
            later: BinaryHeap::new(),
            length: 0,
            taken: Vec::new(),
            source,
            sink: source + 1,
        }
    }

    /// What it adds to the cost at least to have the link from this black cell in this direction, if that is below `limit`.
    ///
    /// The exchange leads from the link's white cell back to its black one. It visits what is nearer than the limit.
    pub(crate) fn cost_of_link(
        &mut self,
        matching: &Matching<'_>,
        black: Node,
        dir: Dir,
        limit: i32,
    ) -> Option<i32> {
        let link = matching.reduced(black, dir);
        let white = matching.board.step(black, dir);
        self.shortest(matching, white, |node| node == black, limit - link)?;
        Some(self.length + link)
    }

    /// Puts in the link whose cost was found last.
    pub(crate) fn put_in(&mut self, matching: &mut Matching<'_>, black: Node, dir: Dir) {
        self.take(matching, black);
        matching.toggle(black, dir);
    }

    /// Takes back the last link put in, which must have cost nothing: then the potentials are as they were.
    pub(crate) fn undo(&mut self, matching: &mut Matching<'_>, black: Node, dir: Dir) {
        self.taken.iter_mut().for_each(|(from, to)| std::mem::swap(from, to));
        self.toggle_taken(matching);
        matching.toggle(black, dir);
    }

    /// Moves room to one of these cells, the cheapest, and keeps it there for good: its path ends there. Of equally cheap cells
    /// it takes one at random. Gives what that adds to the cost; `None`, and nothing changes, if no cell can have room.
    ///
    /// A cell that gives up a link gets room, and the link moves on along a shortest path to a cell of its colour that has
    /// room.
    pub(crate) fn reserve(
        &mut self,
        matching: &mut Matching<'_>,
        cells: &[Node],
        rng: &mut impl Rng,
    ) -> Option<i32> {
        let mut best: Option<(i32, Node)> = None;
        let mut ties = 0;
        for &cell in cells {
            let limit = best.map_or(i32::MAX / 2, |(cost, _)| cost + 1);
            let Some(cost) = self.cost_of_room(matching, cell, limit) else { continue };
            ties = if best.is_some_and(|(least, _)| least == cost) { ties + 1 } else { 1 };
            if rng.next_u64().is_multiple_of(ties) {
                best = Some((cost, cell));
            }
        }
        let (cost, cell) = best?;
        if matching.room[cell as usize] == 0 {
            self.cost_of_room(matching, cell, i32::MAX / 2);
            self.take(matching, if Board::is_black(cell) { cell } else { self.sink });
            matching.room[cell as usize] += 1;
        }
        matching.capacity[cell as usize] -= 1;
        matching.room[cell as usize] -= 1;
        matching.spare -= 1;
        Some(cost)
    }

    /// What it adds to the cost at least that a cell has room, if that is below the limit.
    fn cost_of_room(&mut self, matching: &Matching<'_>, cell: Node, limit: i32) -> Option<i32> {
        if matching.room[cell as usize] > 0 {
            return (limit > 0).then_some(0);
        }
        if matching.capacity[cell as usize] < 2 {
            return None;
        }
        // The cell draws one less and another of its colour one more, or drains so.
        let potential = matching.potential[cell as usize];
        let less =
            if Board::is_black(cell) { potential - matching.source } else { matching.sink - potential };
        let [from, to] = if Board::is_black(cell) { [self.source, cell] } else { [cell, self.sink] };
        self.shortest(matching, from, |node| node == to, limit - less)?;
        Some(self.length + less)
    }

    /// Makes a 2-matching the cheapest of its size again after costs have changed.
    ///
    /// Links whose reduced cost has the wrong sign go in or out; each cell that this leaves with a link too many or too few
    /// begins or ends a shortest path along which the surplus moves on. O(cells) for each such cell at most.
    pub(crate) fn repair(&mut self, matching: &mut Matching<'_>) {
        let mut excess = self.saturate(matching);
        let nodes = matching.board.cells.iter().copied().chain([self.source, self.sink]);
        for node in nodes.collect::<Vec<_>>() {
            while excess[node as usize] > 0 {
                let end = self
                    .shortest(matching, node, |end| excess[end as usize] < 0, i32::MAX / 2)
                    .expect("what one cell has too many another one has too few");
                excess[node as usize] -= 1;
                excess[end as usize] += 1;
                self.take(matching, end);
            }
        }
        matching.spare = matching.room.iter().map(|&room| u32::from(room)).sum();
    }

    /// Puts links of negative reduced cost in and takes those of positive cost out; gives what each node has too many.
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

    /// Dijkstra to the nearest of the nodes asked for, if that is nearer than the limit.
    fn shortest(
        &mut self,
        matching: &Matching<'_>,
        from: Node,
        is_end: impl Fn(Node) -> bool,
        limit: i32,
    ) -> Option<Node> {
        self.round += 1;
        self.reached.clear();
        self.later.clear();
        self.length = 0;
        if limit <= 0 {
            return None;
        }
        self.see(from, from, 0);
        let mut next = 0;
        loop {
            while let Some(&node) = self.reached.get(next) {
                next += 1;
                if is_end(node) {
                    return Some(node);
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
                    self.see(black, node, length + matching.source - matching.potential[black as usize]);
                }
            }
        } else if node == self.sink {
            for &white in matching.board.cells.iter().filter(|&&cell| !Board::is_black(cell)) {
                if draws(white) {
                    self.see(white, node, length + matching.sink - matching.potential[white as usize]);
                }
            }
        } else {
            for dir in steps(matching, node) {
                self.see(matching.board.step(node, dir), node, length + step_cost(matching, node, dir));
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
        debug_assert!(length >= self.length, "reduced costs are not negative");
        let is_final = length == self.length;
        *label = Label { round: self.round, length, before, is_final };
        if is_final {
            self.reached.push(node);
        } else {
            self.later.push(Reverse((length, node)));
        }
    }

    /// Exchanges along the path found last, and makes its steps free of reduced cost.
    fn take(&mut self, matching: &mut Matching<'_>, end: Node) {
        self.taken.clear();
        let mut node = end;
        while self.labels[node as usize].before != node {
            let before = self.labels[node as usize].before;
            self.taken.push((before, node));
            node = before;
        }
        self.toggle_taken(matching);
        for &node in &self.reached {
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
