//! Growing a 2-matching by cheapest augmenting paths.
//!
//! # Problem
//! Given the cheapest 2-matching with some number of links, find the cheapest one with more links.
//!
//! # Method
//! Augmenting the cheapest flow of some value along a *shortest* augmenting path of the residual
//! graph gives the cheapest flow of the next value (successive shortest paths: Busacker and Gowen
//! 1961; with potentials: Edmonds and Karp 1972).
//! Here all paths of the same length are used together, in one *phase* (the primal-dual method of
//! Ford and Fulkerson):
//!
//! 1. [`Phases::label`] computes the distance d(v) from each node v to the nearest white cell with
//!    room, by Dijkstra's method on reduced costs, backwards from all of these cells at once.
//!    It stops at the distance D of the nearest black cell with room, and adds D - d(v) to the
//!    potential of each node nearer than D. Then every arc on a shortest path has reduced cost 0,
//!    and no arc has a negative one: the arc from u to v with reduced cost c changes to c + d(v) -
//!    d(u), and d(u) <= c + d(v).
//! 2. [`Phases::augment`] augments along paths of reduced cost 0 until there are none.
//!    Each inserts and removes links alternately from a black cell with room to a white one:
//!
//!    ```text
//!     before:  B   w---b   w---b   W       "---" is a link; B and W have room for one more.
//!     after:   B---w   b---w   b---W       One link more in all; w and b have as many as before.
//!    ```
//!
//! The next phase finds longer paths only.
//! So the number of phases is at most the number of different path lengths, which are sums of a few
//! costs.
//!
//! # Time
//! A phase is linear in the cells, apart from the searches for its paths.
//! These run from a single cell towards the nearest goals (A*), and usually visit only a narrow
//! strip of cells between two cells with room.
//! Nodes visited by a failed search are skipped for the rest of the phase.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::board::{Board, Dir, Node, dirs, opposite};
use super::bucket_queue::BucketQueue;
use super::two_matching::TwoMatching;
use crate::disjoint_sets::DisjointSets;

impl TwoMatching<'_> {
    /// Adds links along cheapest augmenting paths until the total room is down to `total_room`, or
    /// there is no augmenting path: then the number of links is the maximum.
    ///
    /// The matching must be the cheapest of its size, and stays so.
    pub(crate) fn grow(&mut self, total_room: u32) {
        if self.total_room <= total_room {
            return;
        }
        let mut phases = Phases::new(self);
        while self.total_room > total_room && phases.label(self, i32::MAX) {
            phases.augment(self, total_room);
        }
    }

    /// Adds links along augmenting paths that cross no zones, as long as there are any.
    pub(crate) fn grow_inside_zones(&mut self) {
        let mut phases = Phases::new(self);
        while phases.label(self, 0) {
            phases.augment(self, 0);
        }
    }
}

/// State of a node in a phase.
#[derive(Clone, Copy, Default)]
struct Label {
    /// The phase that set the label.
    phase: u32,
    /// Length of the shortest path found from the node to a white cell with room, in reduced costs.
    length: i32,
    /// Index in [`Phases::sinks`] of the cell that this path leads to, with the bit
    /// [`Label::TENTATIVE`] set while a shorter path may still be found.
    sink: u32,
}

impl Label {
    const TENTATIVE: u32 = 1 << 31;

    fn is_tentative(self) -> bool {
        self.sink & Self::TENTATIVE != 0
    }
}

/// State of a node in the search for one path.
#[derive(Clone, Copy, Default)]
struct Visit {
    /// The search that visited the node last; [`Phases::dead`] if no sink can be reached from it in
    /// this phase.
    search: u32,
    /// The direction back to the node from which it was visited.
    back: u8,
}

/// The phases of one call, and memory that they share.
struct Phases {
    phase: u32,
    labels: Vec<Label>,
    /// The black cells with room.
    sources: Vec<Node>,
    /// The white cells with room.
    sinks: Vec<Node>,
    /// The sinks in groups that are connected by arcs of reduced cost 0, whatever the direction of
    /// the arcs.
    /// A path of reduced cost 0 stays inside a group, even after other paths have been reversed.
    /// So a source can only reach the sinks of its own group.
    sink_groups: DisjointSets,
    /// The nodes whose labels are final, in the order of their lengths.
    reached: Vec<Node>,
    /// Tentative labels, shortest first; entries that a shorter label has replaced are skipped.
    tentative: BinaryHeap<Reverse<(i32, Node)>>,
    /// Number of the last search, over all phases.
    search: u32,
    /// Number that marks dead nodes; searches of this phase have higher ones.
    dead: u32,
    visits: Vec<Visit>,
    /// The nodes that the present search has visited.
    visited: Vec<Node>,
    /// The nodes from which the present search goes on, with the number of steps to each.
    queue: BucketQueue<(u32, Node)>,
    /// Coordinates of the cells that the present search heads for.
    goals: Vec<(u32, u32)>,
}

impl Phases {
    fn new(matching: &TwoMatching<'_>) -> Self {
        let (sources, sinks) = matching
            .board
            .cells
            .iter()
            .copied()
            .filter(|&node| matching.has_room(node))
            .partition(|&node| Board::is_black(node));
        let nodes = matching.board.node_count();
        Self {
            phase: 0,
            labels: vec![Label::default(); nodes],
            sources,
            sinks,
            sink_groups: DisjointSets::default(),
            reached: Vec::new(),
            tentative: BinaryHeap::new(),
            search: 0,
            dead: 0,
            visits: vec![Visit::default(); nodes],
            visited: Vec::new(),
            queue: BucketQueue::default(),
            goals: Vec::new(),
        }
    }

    /// Begins a phase: computes distances to the sinks and changes the potentials, so that shortest
    /// augmenting paths have reduced cost 0.
    ///
    /// Returns whether there is an augmenting path of at most `max_length`, in reduced costs.
    fn label(&mut self, matching: &mut TwoMatching<'_>, max_length: i32) -> bool {
        self.phase += 1;
        self.reached.clear();
        self.tentative.clear();
        self.sources.retain(|&node| matching.has_room(node));
        self.sinks.retain(|&node| matching.has_room(node));
        self.sink_groups.reset(self.sinks.len());
        for (sink, &node) in (0..).zip(&self.sinks) {
            self.labels[node as usize] = Label { phase: self.phase, length: 0, sink };
            self.reached.push(node);
        }
        let mut next = 0;
        let mut length = 0;
        let mut is_source_reached = false;
        loop {
            // All nodes at this length, including those that arcs of cost 0 add meanwhile.
            while let Some(&node) = self.reached.get(next) {
                next += 1;
                is_source_reached |= Board::is_black(node) && matching.has_room(node);
                self.relax_arcs_to(matching, node, length);
            }
            if is_source_reached {
                break;
            }
            match self.tentative.peek() {
                Some(&Reverse((shortest, _))) if shortest <= max_length => length = shortest,
                _ => return false,
            }
            while let Some(&Reverse((other, node))) = self.tentative.peek()
                && other == length
            {
                self.tentative.pop();
                let label = &mut self.labels[node as usize];
                if label.is_tentative() && label.length == length {
                    label.sink &= !Label::TENTATIVE;
                    self.reached.push(node);
                }
            }
        }
        // The source keeps its potential: it is at distance D, like the black cells with room.
        for &node in &self.reached {
            matching.potential[node as usize] += length - self.labels[node as usize].length;
        }
        matching.sink_potential += length;
        true
    }

    /// Labels the nodes from which arcs lead to a node whose label is final.
    #[inline]
    fn relax_arcs_to(&mut self, matching: &TwoMatching<'_>, node: Node, length: i32) {
        let sink = self.labels[node as usize].sink;
        for dir in dirs(matching.arcs_to(node)) {
            let other = matching.board.neighbour(node, dir);
            let cost = matching.arc_cost(other, opposite(dir));
            debug_assert!(cost >= 0, "a residual arc has a negative reduced cost");
            let label = &mut self.labels[other as usize];
            let is_labelled = label.phase == self.phase;
            if is_labelled && (!label.is_tentative() || label.length <= length + cost) {
                // No shorter path.
                // But if this one is as short, the arc's reduced cost becomes 0, and it connects
                // two sinks.
                let other_sink = label.sink & !Label::TENTATIVE;
                if other_sink != sink && label.length == length + cost {
                    self.sink_groups.union(other_sink, sink);
                }
                continue;
            }
            let tentative = if cost == 0 { 0 } else { Label::TENTATIVE };
            *label = Label { phase: self.phase, length: length + cost, sink: sink | tentative };
            if cost == 0 {
                self.reached.push(other);
            } else {
                self.tentative.push(Reverse((label.length, other)));
            }
        }
    }

    /// Augments along paths of reduced cost 0 until there are none, or the total room is down to
    /// `total_room`.
    fn augment(&mut self, matching: &mut TwoMatching<'_>, total_room: u32) {
        self.search += 1;
        self.dead = self.search;
        for index in 0..self.sources.len() {
            let source = self.sources[index];
            while matching.has_room(source) && matching.total_room > total_room {
                if !self.augment_from(matching, source) {
                    break;
                }
            }
        }
    }

    /// Searches for a path of reduced cost 0 from a black cell with room to a white one, by A*
    /// towards the nearest goals, and augments along it.
    /// Returns whether there was one.
    ///
    /// Any such path will do, but short ones leave more of the ladders intact.
    ///
    /// Nodes visited by a failed search are *dead* for the rest of the phase: no arc of reduced
    /// cost 0 leads from them to a node not visited, and no sink is among them.
    /// This stays so: a new arc out of the dead nodes could only be the reverse of an arc by which
    /// an augmenting path entered them, but a path that enters them cannot reach a sink.
    fn augment_from(&mut self, matching: &mut TwoMatching<'_>, source: Node) -> bool {
        if !self.choose_goals(matching, source) {
            return false;
        }
        self.search += 1;
        self.visited.clear();
        self.queue.clear();
        self.visit(matching, source, 0, 0);
        while let Some((steps, node)) = self.queue.pop() {
            if !Board::is_black(node) && matching.has_room(node) {
                self.augment_along_visits(matching, source, node);
                return true;
            }
            for dir in dirs(matching.arcs_from(node)) {
                let other = matching.board.neighbour(node, dir);
                let search = self.visits[other as usize].search;
                let is_new = search != self.search && search != self.dead;
                // Nodes that this phase did not label are too far from the sinks.
                if is_new
                    && self.labels[other as usize].phase == self.phase
                    && matching.arc_cost(node, dir) == 0
                {
                    self.visit(matching, other, steps + 1, opposite(dir) as u8);
                }
            }
        }
        for &node in &self.visited {
            self.visits[node as usize].search = self.dead;
        }
        false
    }

    /// Chooses up to four of the nearest sinks that a source might reach as goals of a search.
    /// Returns whether it might reach any.
    ///
    /// Goals only direct the search: it ends at whichever sink it finds first.
    fn choose_goals(&mut self, matching: &TwoMatching<'_>, source: Node) -> bool {
        const MAX_GOALS: usize = 4;
        const MAX_DISTANCE_IN_LIST: usize = 1000;

        let label = self.labels[source as usize];
        self.goals.clear();
        if label.phase != self.phase || label.is_tentative() {
            return false;
        }
        let from = matching.board.xy(source);
        let group = self.sink_groups.find(label.sink);
        // Sinks are listed row by row.
        // If there are very many, only those listed near the sink that the label leads to are
        // compared.
        // If none of these qualifies, the search has no goals and becomes a breadth-first search.
        let near = label.sink as usize;
        let window = near.saturating_sub(MAX_DISTANCE_IN_LIST)
            ..(near + MAX_DISTANCE_IN_LIST).min(self.sinks.len());
        let is_complete = window.len() == self.sinks.len();
        for index in window {
            let sink = self.sinks[index];
            if !matching.has_room(sink) || self.sink_groups.find(index as u32) != group {
                continue;
            }
            let goal = matching.board.xy(sink);
            let position =
                self.goals.partition_point(|&other| distance(from, other) <= distance(from, goal));
            if position < MAX_GOALS {
                self.goals.insert(position, goal);
                self.goals.truncate(MAX_GOALS);
            }
        }
        !is_complete || !self.goals.is_empty()
    }

    /// Adds a node to the present search.
    fn visit(&mut self, matching: &TwoMatching<'_>, node: Node, steps: u32, back: u8) {
        // The estimate of the remaining steps need not be a lower bound, for any path will do.
        // A path across ladders zigzags, and takes about two steps for each cell of distance.
        const STEPS_PER_CELL: u32 = 2;

        let position = matching.board.xy(node);
        let ahead = self.goals.iter().map(|&goal| distance(position, goal)).min().unwrap_or(0);
        self.visits[node as usize] = Visit { search: self.search, back };
        self.visited.push(node);
        self.queue.push(steps + STEPS_PER_CELL * ahead, (steps, node));
    }

    /// Augments along the path by which the present search reached a sink.
    fn augment_along_visits(&self, matching: &mut TwoMatching<'_>, source: Node, sink: Node) {
        let mut node = sink;
        while node != source {
            let back = Dir::from(self.visits[node as usize].back);
            matching.toggle(node, back);
            node = matching.board.neighbour(node, back);
        }
        matching.room[source as usize] -= 1;
        matching.room[sink as usize] -= 1;
        matching.total_room -= 2;
    }
}

/// Distance of two cells in steps between neighbours.
fn distance(a: (u32, u32), b: (u32, u32)) -> u32 {
    a.0.abs_diff(b.0) + a.1.abs_diff(b.1)
}
