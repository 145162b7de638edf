//! Growing a 2-matching along cheapest alternating paths.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use beadwork_grid::Path;

use super::board::{Board, Dir, Node, back, dirs};
use super::ladder::{Grain, as_below, ladders};
use crate::union::Union;

/// A set of links of a board, at most two at each cell; the cheapest of its size until links are
/// locked or paid for.
///
/// Black cells send, white cells receive: a link is a unit of flow.
/// The proof of its optimality is a **potential** for each cell, such that every residual step has
/// a reduced cost of at least 0: cost + potential(from) - potential(to), where a step from black to
/// white puts a link in and costs what it costs, and one from white to black takes a link out and
/// gives that back.
/// Each black cell draws from one source, each white one drains into one sink.
#[derive(Clone)]
pub(crate) struct Matching<'a> {
    pub(crate) board: &'a Board,
    /// For each node a bit for each direction in which it is linked.
    pub(crate) links: Vec<u8>,
    /// How many links each cell may have, 0 for nodes that are no cells.
    pub(crate) capacity: Vec<u8>,
    /// How many more links each cell may have.
    pub(crate) room: Vec<u8>,
    /// Sum of the room.
    pub(crate) spare: u32,
    pub(crate) potential: Vec<i32>,
    pub(crate) source: i32,
    pub(crate) sink: i32,
    /// For each node a bit for each link that must stay.
    pub(crate) locked: Vec<u8>,
    /// What the links of each node to the right and below cost beside the board's cost; empty if
    /// nothing.
    extra: Vec<[i32; 2]>,
}

impl<'a> Matching<'a> {
    /// Inside the zones: ladders and what fits beside them.
    /// Linear in the cells.
    pub(crate) fn inside_zones(board: &'a Board, grain: Grain) -> Self {
        Self::of_links(board, |room| ladders(board, grain, room))
    }

    /// Inside the zones: what a path of the layer below links, and what fits beside that.
    /// Linear in the cells.
    pub(crate) fn as_below(board: &'a Board, below: &Path) -> Self {
        Self::of_links(board, |room| as_below(board, below, room))
    }

    /// Links inside the zones, chosen within the room of each cell.
    /// They cost 0, so the potentials are 0.
    fn of_links(board: &'a Board, choose: impl FnOnce(&mut [u8]) -> Vec<u8>) -> Self {
        let mut capacity = vec![0; board.nodes()];
        board.cells.iter().for_each(|&node| capacity[node as usize] = 2);
        let mut room = capacity.clone();
        let links = choose(&mut room);
        let spare = room.iter().map(|&room| u32::from(room)).sum();
        let potential = vec![0; board.nodes()];
        let locked = vec![0; board.nodes()];
        Self {
            board,
            links,
            capacity,
            room,
            spare,
            potential,
            source: 0,
            sink: 0,
            locked,
            extra: Vec::new(),
        }
    }

    /// Whether a cell is linked in a direction.
    pub(crate) fn is_linked(&self, node: Node, dir: Dir) -> bool {
        self.links[node as usize] & (1 << dir) != 0
    }

    /// Puts a link in, or takes it out.
    #[inline]
    pub(crate) fn toggle(&mut self, node: Node, dir: Dir) {
        self.links[node as usize] ^= 1 << dir;
        self.links[self.board.step(node, dir) as usize] ^= 1 << back(dir);
    }

    /// Makes a link stay whatever follows.
    pub(crate) fn lock(&mut self, node: Node, dir: Dir) {
        self.locked[node as usize] |= 1 << dir;
        self.locked[self.board.step(node, dir) as usize] |= 1 << back(dir);
    }

    /// Takes links inside zones out until there is so much spare room; `choose` picks one of so
    /// many.
    pub(crate) fn drop_links_inside(&mut self, spare: u32, mut choose: impl FnMut(usize) -> usize) {
        while self.spare < spare {
            let inside = |node: Node| self.links[node as usize] & !self.board.across[node as usize];
            let linked: Vec<Node> =
                self.board.cells.iter().copied().filter(|&node| inside(node) != 0).collect();
            if linked.is_empty() {
                return;
            }
            let node = linked[choose(linked.len())];
            let dir = inside(node).trailing_zeros() as Dir;
            self.toggle(node, dir);
            self.room[node as usize] += 1;
            self.room[self.board.step(node, dir) as usize] += 1;
            self.spare += 2;
        }
    }

    /// Sum of the costs of its links.
    pub(crate) fn cost(&self) -> i64 {
        let cost_of = |&node: &Node| {
            let bits = self.links[node as usize] & self.board.across[node as usize] & 0b11;
            dirs(bits).map(|dir| i64::from(self.board.cost(node, dir))).sum::<i64>()
        };
        self.board.cells.iter().map(cost_of).sum()
    }

    /// Reduced cost of putting in the link from a cell, of either colour, in a direction; its
    /// negative for taking it out.
    #[inline]
    pub(crate) fn reduced(&self, node: Node, dir: Dir) -> i32 {
        let other = self.board.step(node, dir);
        let (black, white) = if Board::is_black(node) { (node, other) } else { (other, node) };
        let cost = self.board.cost(node, dir) + self.potential[black as usize]
            - self.potential[white as usize];
        if self.extra.is_empty() { cost } else { cost + self.extra(node, dir) }
    }

    fn extra(&self, node: Node, dir: Dir) -> i32 {
        let (node, dir) =
            if dir < 2 { (node, dir) } else { (self.board.step(node, dir), back(dir)) };
        self.extra[node as usize][dir]
    }

    /// The same links on a board whose costs are so many times as high.
    pub(crate) fn in_parts<'b>(&self, board: &'b Board, parts: i32) -> Matching<'b> {
        Matching {
            board,
            links: self.links.clone(),
            capacity: self.capacity.clone(),
            room: self.room.clone(),
            spare: self.spare,
            potential: self.potential.iter().map(|potential| potential * parts).collect(),
            source: self.source * parts,
            sink: self.sink * parts,
            locked: self.locked.clone(),
            extra: Vec::new(),
        }
    }

    /// Adds to the cost of every link inside a set of cells, and to the potentials so that few
    /// reduced costs change.
    /// The caller has to [`repair`](super::Paths::repair) the optimum.
    pub(crate) fn raise_inside(&mut self, members: &[Node], by: i32) {
        let board = self.board;
        self.extra.resize(board.nodes(), [0; 2]);
        let mut is_member = vec![false; board.nodes()];
        members.iter().for_each(|&node| is_member[node as usize] = true);
        for &node in members {
            for dir in dirs(board.neighbours[node as usize] & 0b11) {
                if is_member[board.step(node, dir) as usize] {
                    self.extra[node as usize][dir] += by;
                }
            }
            if Board::is_black(node) {
                self.potential[node as usize] -= by;
            }
        }
    }

    /// Sum of the costs of its links, with what was added to them.
    pub(crate) fn raised_cost(&self) -> i64 {
        let extra_of = |&node: &Node| {
            let bits = self.links[node as usize] & 0b11;
            dirs(bits).map(|dir| i64::from(self.extra(node, dir))).sum::<i64>()
        };
        self.cost() + self.board.cells.iter().map(extra_of).sum::<i64>()
    }

    /// Adds links along cheapest alternating paths until the spare room is down to `spare`, or no
    /// path is left.
    ///
    /// Successive shortest paths after Busacker and Gowen (1961) with the potentials of Edmonds and
    /// Karp (1972), all paths of one length in one round.
    /// There are few rounds, for the lengths, small multiples of the costs, only grow.
    /// A round is linear in the cells, and in what its searches look at: strips between cells with
    /// room, and once what they find without a way out.
    pub(crate) fn grow(&mut self, spare: u32) {
        if self.spare <= spare {
            return;
        }
        let mut rounds = Rounds::new(self);
        while self.spare > spare && rounds.label(self, i32::MAX) {
            rounds.augment(self, spare);
        }
    }

    /// Adds links along alternating paths that cross no zones, as long as there are any.
    pub(crate) fn grow_inside_zones(&mut self) {
        let mut rounds = Rounds::new(self);
        while rounds.label(self, 0) {
            rounds.augment(self, 0);
        }
    }
}

/// What a round knows of a node.
#[derive(Clone, Copy, Default)]
struct Label {
    /// The round that set it.
    round: u32,
    /// Reduced length of the shortest path from it to a white cell with room.
    length: i32,
    /// The white cell, as an index of the sinks, that the path leads to; with [`Label::OPEN`] while
    /// the length can still fall.
    sink: u32,
}

impl Label {
    const OPEN: u32 = 1 << 31;

    fn is_open(self) -> bool {
        self.sink & Self::OPEN != 0
    }
}

/// What a search for one path knows of a node.
#[derive(Clone, Copy, Default)]
struct Trace {
    /// The search that saw it last, or the mark of its round if nothing is reached from it.
    search: u32,
    /// The direction back to where it was seen from.
    back: u8,
}

/// Nodes to go on from, with the steps that lead to them: those whose steps and distance to a goal
/// sum to the least come first, of these the last one.
#[derive(Default)]
struct Open {
    /// By the sum.
    buckets: Vec<Vec<(u32, Node)>>,
    /// No bucket below it holds a node.
    least: usize,
}

impl Open {
    fn clear(&mut self) {
        self.buckets.iter_mut().skip(self.least).for_each(Vec::clear);
        self.least = self.buckets.len();
    }

    #[inline]
    fn push(&mut self, sum: u32, node: (u32, Node)) {
        let sum = sum as usize;
        if sum >= self.buckets.len() {
            self.buckets.resize_with(sum + 1, Vec::new);
        }
        self.buckets[sum].push(node);
        self.least = self.least.min(sum);
    }

    #[inline]
    fn pop(&mut self) -> Option<(u32, Node)> {
        while let Some(bucket) = self.buckets.get_mut(self.least) {
            if let Some(node) = bucket.pop() {
                return Some(node);
            }
            self.least += 1;
        }
        None
    }
}

struct Rounds {
    round: u32,
    labels: Vec<Label>,
    sources: Vec<Node>,
    sinks: Vec<Node>,
    /// Sinks between which residual steps of reduced cost 0 may lead, in any direction, have one
    /// root.
    basins: Union,
    /// Labelled nodes whose length is final.
    reached: Vec<Node>,
    later: BinaryHeap<Reverse<(i32, Node)>>,
    search: u32,
    /// The searches from this one on belong to the present round.
    dead: u32,
    traces: Vec<Trace>,
    seen: Vec<Node>,
    open: Open,
    goals: Vec<(u32, u32)>,
}

impl Rounds {
    fn new(matching: &Matching<'_>) -> Self {
        let has_room = |&node: &Node| matching.room[node as usize] > 0;
        let (sources, sinks) = matching
            .board
            .cells
            .iter()
            .copied()
            .filter(has_room)
            .partition(|&node| Board::is_black(node));
        Self {
            round: 0,
            labels: vec![Label::default(); matching.board.nodes()],
            sources,
            sinks,
            basins: Union::default(),
            reached: Vec::new(),
            later: BinaryHeap::new(),
            search: 0,
            dead: 0,
            traces: vec![Trace::default(); matching.board.nodes()],
            seen: Vec::new(),
            open: Open::default(),
            goals: Vec::new(),
        }
    }

    /// Dijkstra backwards from all white cells with room to the nearest black one, whose path it
    /// makes free of reduced cost; false if there is none of at most that reduced length.
    fn label(&mut self, matching: &mut Matching<'_>, longest: i32) -> bool {
        self.round += 1;
        self.reached.clear();
        self.later.clear();
        self.sources.retain(|&node| matching.room[node as usize] > 0);
        self.sinks.retain(|&node| matching.room[node as usize] > 0);
        self.basins.reset(self.sinks.len());
        for (sink, &node) in (0..).zip(&self.sinks) {
            self.labels[node as usize] = Label { round: self.round, length: 0, sink };
            self.reached.push(node);
        }
        let mut next = 0;
        let mut length = 0;
        let mut found = false;
        loop {
            while let Some(&node) = self.reached.get(next) {
                next += 1;
                found |= Board::is_black(node) && matching.room[node as usize] > 0;
                self.expand(matching, node, length);
            }
            if found {
                break;
            }
            match self.later.peek() {
                Some(&Reverse((shortest, _))) if shortest <= longest => length = shortest,
                _ => return false,
            }
            while let Some(&Reverse((other, node))) = self.later.peek()
                && other == length
            {
                self.later.pop();
                let label = &mut self.labels[node as usize];
                if label.is_open() && label.length == length {
                    label.sink &= !Label::OPEN;
                    self.reached.push(node);
                }
            }
        }
        for &node in &self.reached {
            matching.potential[node as usize] += length - self.labels[node as usize].length;
        }
        matching.sink += length;
        true
    }

    #[inline]
    fn expand(&mut self, matching: &Matching<'_>, node: Node, length: i32) {
        let sink = self.labels[node as usize].sink;
        for dir in steps_to(matching, node) {
            let other = matching.board.step(node, dir);
            let reduced = step_cost(matching, other, back(dir));
            debug_assert!(reduced >= 0, "a residual step has a negative reduced cost");
            let label = &mut self.labels[other as usize];
            if label.round == self.round && (!label.is_open() || label.length <= length + reduced) {
                let other_sink = label.sink & !Label::OPEN;
                if other_sink != sink && label.length == length + reduced {
                    let (a, b) = (other_sink, sink);
                    self.basins.unite(a, b);
                }
                continue;
            }
            let open = if reduced == 0 { 0 } else { Label::OPEN };
            *label = Label { round: self.round, length: length + reduced, sink: sink | open };
            if reduced == 0 {
                self.reached.push(other);
            } else {
                self.later.push(Reverse((label.length, other)));
            }
        }
    }

    /// Augments along paths free of reduced cost until there are none, or down to so much spare
    /// room.
    fn augment(&mut self, matching: &mut Matching<'_>, spare: u32) {
        self.dead = self.search + 1;
        self.search += 1;
        for index in 0..self.sources.len() {
            let source = self.sources[index];
            while matching.room[source as usize] > 0 && matching.spare > spare {
                if !self.reach(matching, source) {
                    break;
                }
            }
        }
    }

    /// A search of the kind A* for a path from one black cell with room, towards the nearest white
    /// ones.
    ///
    /// Paths need not be short, but short ones leave more of the ladders as they are.
    /// What a search in vain has seen leads nowhere for the rest of the round: no path enters it,
    /// so none opens a way out of it.
    fn reach(&mut self, matching: &mut Matching<'_>, source: Node) -> bool {
        if !self.choose_goals(matching, source) {
            return false;
        }
        self.search += 1;
        self.seen.clear();
        self.open.clear();
        self.see(matching, source, 0, 0);
        while let Some((steps_taken, node)) = self.open.pop() {
            if !Board::is_black(node) && matching.room[node as usize] > 0 {
                self.flip(matching, source, node);
                return true;
            }
            for dir in steps(matching, node) {
                let other = matching.board.step(node, dir);
                let trace = self.traces[other as usize].search;
                let is_new = trace != self.search && trace != self.dead;
                if is_new
                    && self.labels[other as usize].round == self.round
                    && step_cost(matching, node, dir) == 0
                {
                    self.see(matching, other, steps_taken + 1, back(dir) as u8);
                }
            }
        }
        for &node in &self.seen {
            self.traces[node as usize].search = self.dead;
        }
        false
    }

    /// The nearest white cells with room that a source might reach; false if there are none.
    /// A few do, for they only say where to look first.
    fn choose_goals(&mut self, matching: &Matching<'_>, source: Node) -> bool {
        const MOST: usize = 4;
        const MOST_LOOKED_AT: usize = 1000;

        let label = self.labels[source as usize];
        self.goals.clear();
        if label.round != self.round || label.is_open() {
            return false;
        }
        let from = matching.board.xy(source);
        let root = self.basins.root(label.sink);
        // Of very many, those that come about where the nearest one does; without a goal the search
        // spreads evenly.
        let near = label.sink as usize;
        let window =
            near.saturating_sub(MOST_LOOKED_AT)..(near + MOST_LOOKED_AT).min(self.sinks.len());
        let all = window.len() == self.sinks.len();
        for index in window {
            let sink = self.sinks[index];
            if matching.room[sink as usize] == 0 || self.basins.root(index as u32) != root {
                continue;
            }
            let goal = matching.board.xy(sink);
            let place =
                self.goals.partition_point(|&other| distance(from, other) <= distance(from, goal));
            if place < MOST {
                self.goals.insert(place, goal);
                self.goals.truncate(MOST);
            }
        }
        !all || !self.goals.is_empty()
    }

    fn see(&mut self, matching: &Matching<'_>, node: Node, steps_taken: u32, back: u8) {
        // A path zigzags across ladders: two steps for a cell.
        const STEPS_A_CELL: u32 = 2;

        let place = matching.board.xy(node);
        let ahead = self.goals.iter().map(|&goal| distance(place, goal)).min().unwrap_or(0);
        self.traces[node as usize] = Trace { search: self.search, back };
        self.seen.push(node);
        self.open.push(steps_taken + STEPS_A_CELL * ahead, (steps_taken, node));
    }

    fn flip(&self, matching: &mut Matching<'_>, source: Node, sink: Node) {
        let mut node = sink;
        while node != source {
            let back = Dir::from(self.traces[node as usize].back);
            matching.toggle(node, back);
            node = matching.board.step(node, back);
        }
        matching.room[source as usize] -= 1;
        matching.room[sink as usize] -= 1;
        matching.spare -= 2;
    }
}

fn distance(a: (u32, u32), b: (u32, u32)) -> u32 {
    a.0.abs_diff(b.0) + a.1.abs_diff(b.1)
}

/// The directions from which residual steps lead to a node.
#[inline]
fn steps_to(matching: &Matching<'_>, node: Node) -> impl Iterator<Item = Dir> + use<> {
    let links = matching.links[node as usize];
    let free = !matching.locked[node as usize];
    dirs(
        free & if Board::is_black(node) {
            links
        } else {
            matching.board.neighbours[node as usize] & !links
        },
    )
}

/// The directions of the residual steps from a node, as bits: to put a link in from black, to take
/// one out from white.
#[inline]
pub(super) fn directions(matching: &Matching<'_>, node: Node) -> u8 {
    let links = matching.links[node as usize];
    let free = !matching.locked[node as usize];
    free & if Board::is_black(node) {
        matching.board.neighbours[node as usize] & !links
    } else {
        links
    }
}

/// The same, one by one.
#[inline]
pub(super) fn steps(matching: &Matching<'_>, node: Node) -> impl Iterator<Item = Dir> + use<> {
    dirs(directions(matching, node))
}

#[inline]
pub(super) fn step_cost(matching: &Matching<'_>, node: Node, dir: Dir) -> i32 {
    let reduced = matching.reduced(node, dir);
    if Board::is_black(node) { reduced } else { -reduced }
}
