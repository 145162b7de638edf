//! Cheapest exchanges of links, found as shortest paths in the residual graph.
//!
//! # Problems
//! All three change an optimal 2-matching into another one with the same number of links, which is
//! optimal under one more condition:
//!
//! - [`ShortestPaths::insertion_cost`] and [`insert`](ShortestPaths::insert): it contains a given
//!   link.
//! - [`ShortestPaths::reserve_end`]: one of some given cells has room, as an end of a path has.
//! - [`ShortestPaths::restore_optimum`]: the costs have changed.
//!
//! # Method
//! Two 2-matchings with the same number of links differ by cycles of the residual graph.
//! So each problem is to find a cheapest cycle through a given arc: that arc and a shortest path
//! from its end to its start.
//!
//! ```text
//!   b ----------> w       To insert the link from b to w, follow a shortest path from w back to b:
//!   ^             |       it removes a link at w, inserts another one where that was, and so on,
//!   +--- ... <----+       until it removes a link at b.
//! ```
//!
//! A path may also run through the source or the sink: then one cell gains a link and another one
//! of its colour loses one.
//!
//! Distances d are computed by Dijkstra's method on reduced costs, up to the distance D of the end
//! of the path.
//! Adding min(d, D) - D to the potential of each node keeps all reduced costs at 0 or more, and
//! makes them 0 along the path, so that its reversed arcs have reduced cost 0 too.
//! This is the same step as in successive shortest paths, see `grow.rs`.
//!
//! # Time
//! A search visits the nodes that are nearer than its end, or than a limit: mostly a small
//! neighbourhood, at worst all cells.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::board::{Board, Dir, Node, dirs};
use super::two_matching::TwoMatching;

/// A search for shortest paths in the residual graphs of one board; keeps memory between searches.
pub(crate) struct ShortestPaths {
    /// Number of the search; labels of earlier ones are invalid.
    search: u32,
    /// For each node a label; then for the source, the sink and the goal.
    /// Allocated by the first search, as most layers need none.
    labels: Vec<Label>,
    /// The nodes whose labels are final, in the order of their lengths.
    reached: Vec<Node>,
    /// Tentative labels, shortest first; entries that a shorter label has replaced are skipped.
    tentative: BinaryHeap<Reverse<(i32, Node)>>,
    /// Length of the paths to the nodes reached last, in reduced costs.
    length: i32,
    /// The arcs of the last exchange, each from its start to its end.
    last_path: Vec<(Node, Node)>,
    /// The number of the source, after those of the nodes.
    source: Node,
    /// The number of the sink.
    sink: Node,
    /// The number of the goal, an additional node at which every path ends.
    goal: Node,
}

/// State of a node in a search.
#[derive(Clone, Copy, Default)]
struct Label {
    /// The search that set the label.
    search: u32,
    /// Length of the shortest path found to the node.
    length: i32,
    /// The node before it on that path; a start is its own predecessor.
    before: Node,
    /// Whether no shorter path exists.
    is_final: bool,
}

impl ShortestPaths {
    /// A limit that no path reaches.
    pub(crate) const UNLIMITED: i32 = i32::MAX / 2;

    pub(crate) fn new(board: &Board) -> Self {
        let source = board.node_count() as Node;
        Self {
            search: 0,
            labels: Vec::new(),
            reached: Vec::new(),
            tentative: BinaryHeap::new(),
            length: 0,
            last_path: Vec::new(),
            source,
            sink: source + 1,
            goal: source + 2,
        }
    }

    /// The cost of inserting the link from a black cell in a direction: the cost of the cheapest
    /// 2-matching of the same size with this link, minus that of the present one.
    /// `None` if that is not below `limit`.
    pub(crate) fn insertion_cost(
        &mut self,
        matching: &TwoMatching<'_>,
        black: Node,
        dir: Dir,
        limit: i32,
    ) -> Option<i32> {
        let link = matching.reduced_cost(black, dir);
        let white = matching.board.neighbour(black, dir);
        let closing_cost = |node: Node| (node == black).then_some(0);
        self.shortest_path(matching, &[(white, 0)], closing_cost, limit - link)?;
        Some(self.length + link)
    }

    /// Inserts the link whose insertion cost was the last one computed.
    ///
    /// If it costs more than 0, the arc that removes the link again has a negative reduced cost;
    /// then the caller has to [`lock`](TwoMatching::lock) the link.
    pub(crate) fn insert(&mut self, matching: &mut TwoMatching<'_>, black: Node, dir: Dir) {
        self.exchange(matching);
        matching.toggle(black, dir);
    }

    /// Undoes the last insertion, which must have cost 0: then all reduced costs along the cycle
    /// were 0, and the potentials did not change.
    pub(crate) fn undo_insertion(&mut self, matching: &mut TwoMatching<'_>, black: Node, dir: Dir) {
        self.last_path.iter_mut().for_each(|(from, to)| std::mem::swap(from, to));
        self.toggle_last_path(matching);
        matching.toggle(black, dir);
    }

    /// Makes room at the one of some cells where that is cheapest, and reserves it for the end of a
    /// path by reducing the cell's capacity.
    /// Returns the increase of the cost and the cell.
    /// If no cell can have room, returns `None` and changes nothing.
    ///
    /// A cell without room gives up a link, which moves on along a shortest path to a cell of its
    /// colour that has room.
    /// So there is one search for each colour.
    pub(crate) fn reserve_end(
        &mut self,
        matching: &mut TwoMatching<'_>,
        cells: &[Node],
    ) -> Option<(i32, Node)> {
        let is_free = |&&cell: &&Node| matching.capacity[cell as usize] == 2;
        let with_room = cells.iter().filter(is_free).find(|&&cell| matching.has_room(cell));
        let (cost, cell) = if let Some(&cell) = with_room {
            (0, cell)
        } else {
            let (blacks, whites): (Vec<Node>, Vec<Node>) =
                cells.iter().filter(is_free).partition(|&&cell| Board::is_black(cell));
            let black = self.cheapest_room(matching, &blacks, Self::UNLIMITED);
            let limit = black.map_or(Self::UNLIMITED, |(cost, _)| cost);
            let white = self.cheapest_room(matching, &whites, limit);
            if white.is_none() {
                // The exchange below follows the last path found.
                self.cheapest_room(matching, &blacks, Self::UNLIMITED);
            }
            let (cost, cell) = white.or(black)?;
            self.exchange(matching);
            matching.room[cell as usize] += 1;
            (cost, cell)
        };
        matching.capacity[cell as usize] -= 1;
        matching.room[cell as usize] -= 1;
        matching.total_room -= 1;
        Some((cost, cell))
    }

    /// Among cells of one colour, all without room, finds the one that gets room at the lowest
    /// cost, which must be below a limit.
    fn cheapest_room(
        &mut self,
        matching: &TwoMatching<'_>,
        cells: &[Node],
        limit: i32,
    ) -> Option<(i32, Node)> {
        if Board::is_black(*cells.first()?) {
            // A cycle through an arc from a black cell to the source, which takes a link from the
            // cell: a path from the source to the cell, then that arc.
            let release_cost =
                |node: Node| cells.contains(&node).then(|| matching.release_cost(node));
            self.shortest_path(matching, &[(self.source, 0)], release_cost, limit)?;
            Some((self.length, self.labels[self.goal as usize].before))
        } else {
            // A cycle through an arc from the sink to a white cell, which takes a link from the
            // cell: that arc, then a path from the cell to the sink.
            let starts: Vec<(Node, i32)> =
                cells.iter().map(|&cell| (cell, matching.release_cost(cell))).collect();
            let sink = self.sink;
            self.shortest_path(matching, &starts, |node| (node == sink).then_some(0), limit)?;
            let mut first = sink;
            while self.labels[first as usize].before != first {
                first = self.labels[first as usize].before;
            }
            Some((self.length, first))
        }
    }

    /// Makes a 2-matching the cheapest of its size again after its costs have changed.
    ///
    /// Using an arc reverses it and negates its reduced cost.
    /// So after each arc with a negative reduced cost has been used, none is left, but some cells
    /// have too many links and others too few.
    /// Each surplus moves along a shortest path to a deficit.
    /// Takes one search for each surplus.
    pub(crate) fn restore_optimum(&mut self, matching: &mut TwoMatching<'_>) {
        let mut excess = self.use_negative_arcs(matching);
        let nodes = matching.board.cells.iter().copied().chain([self.source, self.sink]);
        for node in nodes.collect::<Vec<_>>() {
            while excess[node as usize] > 0 {
                let closing_cost = |end: Node| (excess[end as usize] < 0).then_some(0);
                self.shortest_path(matching, &[(node, 0)], closing_cost, Self::UNLIMITED)
                    .expect("surplus and deficits sum to 0");
                let end = self.labels[self.goal as usize].before;
                excess[node as usize] -= 1;
                excess[end as usize] += 1;
                self.exchange(matching);
            }
        }
        matching.total_room = matching.room.iter().map(|&room| u32::from(room)).sum();
    }

    /// Inserts the links of negative reduced cost and removes those of positive reduced cost.
    ///
    /// Returns the excess of each node, and of the source and the sink: the flow into it minus the
    /// flow out of it.
    /// Inserting a link takes 1 from the excess of its black cell and adds 1 to that of its white
    /// cell.
    fn use_negative_arcs(&self, matching: &mut TwoMatching<'_>) -> Vec<i32> {
        let board = matching.board;
        let mut excess = vec![0; board.node_count() + 2];
        let blacks = || board.cells.iter().copied().filter(|&node| Board::is_black(node));
        let whites = || board.cells.iter().copied().filter(|&node| !Board::is_black(node));
        for black in blacks() {
            for dir in dirs(board.neighbours[black as usize]) {
                let reduced = matching.reduced_cost(black, dir);
                let is_linked = matching.is_linked(black, dir);
                if if is_linked { reduced > 0 } else { reduced < 0 } {
                    matching.toggle(black, dir);
                    let surplus = if is_linked { 1 } else { -1 };
                    excess[black as usize] += surplus;
                    excess[board.neighbour(black, dir) as usize] -= surplus;
                }
            }
        }
        // With these potentials of source and sink, the arcs by which cells get one link less have
        // reduced costs of 0 or more.
        // The opposite arcs may have negative ones: then cells with room use them.
        matching.source_potential =
            blacks().map(|node| matching.potential[node as usize]).min().unwrap_or(0);
        matching.sink_potential =
            whites().map(|node| matching.potential[node as usize]).max().unwrap_or(0);
        for &node in &board.cells {
            if matching.release_cost(node) > 0 {
                let room = i32::from(std::mem::take(&mut matching.room[node as usize]));
                if Board::is_black(node) {
                    excess[node as usize] += room;
                    excess[self.source as usize] -= room;
                } else {
                    excess[node as usize] -= room;
                    excess[self.sink as usize] += room;
                }
            }
        }
        excess
    }

    /// Finds a shortest path from some starts, each with an initial length, to the goal.
    ///
    /// The goal is reached from each node for which `closing_cost` returns a cost, which is added
    /// to the length.
    /// Returns `None` if the length is not below `limit`; otherwise it is in [`Self::length`], and
    /// the labels lead back from the goal.
    fn shortest_path(
        &mut self,
        matching: &TwoMatching<'_>,
        starts: &[(Node, i32)],
        closing_cost: impl Fn(Node) -> Option<i32>,
        limit: i32,
    ) -> Option<()> {
        let goal = self.goal;
        self.labels.resize(goal as usize + 1, Label::default());
        self.search += 1;
        self.reached.clear();
        self.tentative.clear();
        self.length = 0;
        if limit <= 0 {
            return None;
        }
        for &(node, length) in starts {
            self.relax(node, node, length);
        }
        let mut next = 0;
        loop {
            // All nodes at this length, including those that arcs of cost 0 add meanwhile.
            while let Some(&node) = self.reached.get(next) {
                next += 1;
                if node == goal {
                    return Some(());
                }
                if let Some(cost) = closing_cost(node) {
                    self.relax(goal, node, self.length + cost);
                    // No path is shorter than one that ends at the present length.
                    if cost == 0 {
                        return Some(());
                    }
                }
                self.relax_arcs_from(matching, node);
            }
            loop {
                let Reverse((length, node)) = self.tentative.pop()?;
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

    /// Labels the nodes to which arcs lead from a node whose label is final.
    fn relax_arcs_from(&mut self, matching: &TwoMatching<'_>, node: Node) {
        let length = self.length;
        let cells = &matching.board.cells;
        if node == self.source {
            for &black in cells.iter().filter(|&&cell| Board::is_black(cell)) {
                if matching.has_room(black) {
                    self.relax(black, node, length - matching.release_cost(black));
                }
            }
        } else if node == self.sink {
            for &white in cells.iter().filter(|&&cell| !Board::is_black(cell)) {
                if matching.has_links(white) {
                    self.relax(white, node, length + matching.release_cost(white));
                }
            }
        } else {
            for dir in dirs(matching.arcs_from(node)) {
                let other = matching.board.neighbour(node, dir);
                self.relax(other, node, length + matching.arc_cost(node, dir));
            }
            let release_cost = matching.release_cost(node);
            if !Board::is_black(node) {
                if matching.has_room(node) {
                    self.relax(self.sink, node, length - release_cost);
                }
            } else if matching.has_links(node) {
                self.relax(self.source, node, length + release_cost);
            }
        }
    }

    /// Labels a node with a path to it, if no path as short is known.
    #[inline]
    fn relax(&mut self, node: Node, before: Node, length: i32) {
        let label = &mut self.labels[node as usize];
        if label.search == self.search && (label.is_final || label.length <= length) {
            return;
        }
        // An arc has a negative reduced cost only where an exchange has replaced a locked link
        // (`exact/exchange.rs`).
        // Counting it as 0 may miss a shorter path, which only makes a cover more expensive: bounds
        // are computed on matchings without locked links.
        let length = length.max(self.length);
        let is_final = length == self.length;
        *label = Label { search: self.search, length, before, is_final };
        if is_final {
            self.reached.push(node);
        } else {
            self.tentative.push(Reverse((length, node)));
        }
    }

    /// Exchanges links along the path found last, and changes the potentials so that its arcs have
    /// reduced cost 0.
    ///
    /// The step to the goal is left to the caller.
    fn exchange(&mut self, matching: &mut TwoMatching<'_>) {
        self.last_path.clear();
        let mut node = self.labels[self.goal as usize].before;
        while self.labels[node as usize].before != node {
            let before = self.labels[node as usize].before;
            self.last_path.push((before, node));
            node = before;
        }
        self.toggle_last_path(matching);
        for &node in self.reached.iter().filter(|&&node| node != self.goal) {
            let length = self.labels[node as usize].length;
            let potential = match node {
                _ if node == self.source => &mut matching.source_potential,
                _ if node == self.sink => &mut matching.sink_potential,
                _ => &mut matching.potential[node as usize],
            };
            *potential += length - self.length;
        }
    }

    /// Inserts or removes the link of each arc of the last path; arcs of source and sink change the
    /// room of a cell.
    fn toggle_last_path(&self, matching: &mut TwoMatching<'_>) {
        for &(from, to) in &self.last_path {
            if to == self.source {
                matching.room[from as usize] += 1;
            } else if from == self.source {
                matching.room[to as usize] -= 1;
            } else if to == self.sink {
                matching.room[from as usize] -= 1;
            } else if from == self.sink {
                matching.room[to as usize] += 1;
            } else {
                let dir = (0..4).find(|&dir| matching.board.neighbour(from, dir) == to);
                matching.toggle(from, dir.expect("an arc leads to a neighbour"));
            }
        }
    }
}
