//! A 2-matching with the potentials that prove it optimal.

use beadwork_grid::Path;

use super::board::{Board, Dir, Node, dirs, opposite};
use super::ladders::{LadderLayout, as_below, ladders};

/// A set of links of a board, at most two at each cell, with a potential for each cell.
///
/// Invariant: every arc of the residual graph has a reduced cost of at least 0 (see
/// [`matching`](super)), so no 2-matching with the same number of links costs less.
/// Two operations break it.
/// Inserting a link that costs something leaves its arc with a negative reduced cost, until
/// [`TwoMatching::lock`] takes that arc out of the residual graph.
/// After [`TwoMatching::add_surcharge`] the optimum has to be restored.
#[derive(Clone)]
pub(crate) struct TwoMatching<'a> {
    pub(crate) board: &'a Board,
    /// For each node the set of directions in which it is linked.
    pub(crate) links: Vec<u8>,
    /// For each node the maximum number of links: 2, or 1 at an end reserved for the path, or 0 for
    /// the padding.
    pub(crate) capacity: Vec<u8>,
    /// For each node how many more links it may have: its capacity minus its links.
    pub(crate) room: Vec<u8>,
    /// Sum of the room of all cells: twice the number of paths, minus the number of reserved ends.
    pub(crate) total_room: u32,
    /// For each node its potential.
    pub(crate) potential: Vec<i32>,
    /// Potential of the source, which supplies the flow of the black cells.
    pub(crate) source_potential: i32,
    /// Potential of the sink, which receives the flow of the white cells.
    pub(crate) sink_potential: i32,
    /// For each node the set of directions of its locked links, whose arcs are not part of the
    /// residual graph.
    pub(crate) locked: Vec<u8>,
    /// For each node the surcharges of its links to the right and down, which are added to the
    /// board's costs; empty if there are none.
    surcharge: Vec<[i32; 2]>,
}

impl<'a> TwoMatching<'a> {
    /// Ladders inside the zones, and links between the cells that they leave over.
    /// Linear in the cells.
    pub(crate) fn inside_zones(board: &'a Board, layout: LadderLayout) -> Self {
        Self::of_free_links(board, |room| ladders(board, layout, room))
    }

    /// The links of the path of the layer below that lie inside the zones, and links between the
    /// cells that they leave over.
    /// Linear in the cells.
    pub(crate) fn as_below(board: &'a Board, below: &Path) -> Self {
        Self::of_free_links(board, |room| as_below(board, below, room))
    }

    /// Links inside the zones that `choose` selects; it gets the room of each cell and reduces it
    /// by the links it makes.
    ///
    /// These links cost 0 and no link costs less, so the matching is optimal with all potentials 0.
    fn of_free_links(board: &'a Board, choose: impl FnOnce(&mut [u8]) -> Vec<u8>) -> Self {
        let mut capacity = vec![0; board.node_count()];
        board.cells.iter().for_each(|&node| capacity[node as usize] = 2);
        let mut room = capacity.clone();
        let links = choose(&mut room);
        Self {
            board,
            links,
            capacity,
            total_room: room.iter().map(|&room| u32::from(room)).sum(),
            room,
            potential: vec![0; board.node_count()],
            source_potential: 0,
            sink_potential: 0,
            locked: vec![0; board.node_count()],
            surcharge: Vec::new(),
        }
    }

    /// Whether a cell is linked in a direction.
    pub(crate) fn is_linked(&self, node: Node, dir: Dir) -> bool {
        self.links[node as usize] & (1 << dir) != 0
    }

    /// Whether a cell may have another link.
    #[inline]
    pub(crate) fn has_room(&self, node: Node) -> bool {
        self.room[node as usize] > 0
    }

    /// Whether a cell has a link.
    #[inline]
    pub(crate) fn has_links(&self, node: Node) -> bool {
        self.capacity[node as usize] > self.room[node as usize]
    }

    /// Inserts a link, or removes it.
    /// The caller keeps the room of both cells up to date.
    #[inline]
    pub(crate) fn toggle(&mut self, node: Node, dir: Dir) {
        self.links[node as usize] ^= 1 << dir;
        self.links[self.board.neighbour(node, dir) as usize] ^= 1 << opposite(dir);
    }

    /// Takes a link out of the residual graph, so that later exchanges keep it as it is.
    pub(crate) fn lock(&mut self, node: Node, dir: Dir) {
        self.locked[node as usize] |= 1 << dir;
        self.locked[self.board.neighbour(node, dir) as usize] |= 1 << opposite(dir);
    }

    /// Removes links inside zones until the total room is at least `total_room`.
    ///
    /// `choose(count)` picks one of `count` cells, and returns its index.
    /// These links are free, so the matching stays optimal.
    pub(crate) fn remove_links_inside(
        &mut self,
        total_room: u32,
        mut choose: impl FnMut(usize) -> usize,
    ) {
        while self.total_room < total_room {
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
            self.room[self.board.neighbour(node, dir) as usize] += 1;
            self.total_room += 2;
        }
    }

    /// Sum of the costs of its links, without surcharges.
    pub(crate) fn cost(&self) -> i64 {
        let cost_of = |&node: &Node| {
            let set = self.links[node as usize] & self.board.across[node as usize] & 0b11;
            dirs(set).map(|dir| i64::from(self.board.link_cost(node, dir))).sum::<i64>()
        };
        self.board.cells.iter().map(cost_of).sum()
    }

    /// Sum of the costs of its links, with surcharges.
    pub(crate) fn cost_with_surcharges(&self) -> i64 {
        let surcharge_of = |&node: &Node| {
            let set = self.links[node as usize] & 0b11;
            dirs(set).map(|dir| i64::from(self.surcharge(node, dir))).sum::<i64>()
        };
        self.cost() + self.board.cells.iter().map(surcharge_of).sum::<i64>()
    }

    /// Reduced cost of inserting the link from a cell, of either colour, in a direction: that of
    /// the arc from black to white.
    /// Removing the link costs the negative.
    #[inline]
    pub(crate) fn reduced_cost(&self, node: Node, dir: Dir) -> i32 {
        let other = self.board.neighbour(node, dir);
        let (black, white) = if Board::is_black(node) { (node, other) } else { (other, node) };
        let cost = self.board.link_cost(node, dir) + self.potential[black as usize]
            - self.potential[white as usize];
        if self.surcharge.is_empty() { cost } else { cost + self.surcharge(node, dir) }
    }

    /// The directions of the residual arcs from a cell to its neighbours, as a set: those of links
    /// that can be inserted from a black cell, or removed from a white one.
    #[inline]
    pub(crate) fn arcs_from(&self, node: Node) -> u8 {
        let links = self.links[node as usize];
        let candidates = if Board::is_black(node) {
            self.board.neighbours[node as usize] & !links
        } else {
            links
        };
        candidates & !self.locked[node as usize]
    }

    /// The directions from a cell to the neighbours from which residual arcs lead to it, as a set.
    #[inline]
    pub(crate) fn arcs_to(&self, node: Node) -> u8 {
        let links = self.links[node as usize];
        let candidates = if Board::is_black(node) {
            links
        } else {
            self.board.neighbours[node as usize] & !links
        };
        candidates & !self.locked[node as usize]
    }

    /// Reduced cost of the arc from a cell to its neighbour in a direction.
    #[inline]
    pub(crate) fn arc_cost(&self, node: Node, dir: Dir) -> i32 {
        let reduced = self.reduced_cost(node, dir);
        if Board::is_black(node) { reduced } else { -reduced }
    }

    /// Reduced cost of the arc by which a cell loses a link: from a black cell to the source, or
    /// from the sink to a white cell.
    /// The opposite arc, by which it gains a link, costs the negative.
    #[inline]
    pub(crate) fn release_cost(&self, node: Node) -> i32 {
        let potential = self.potential[node as usize];
        if Board::is_black(node) {
            potential - self.source_potential
        } else {
            self.sink_potential - potential
        }
    }

    /// The same links on a board with all costs multiplied by a factor.
    /// Potentials are multiplied too, so it is still optimal.
    pub(crate) fn scaled<'b>(&self, board: &'b Board, factor: i32) -> TwoMatching<'b> {
        TwoMatching {
            board,
            links: self.links.clone(),
            capacity: self.capacity.clone(),
            room: self.room.clone(),
            total_room: self.total_room,
            potential: self.potential.iter().map(|potential| potential * factor).collect(),
            source_potential: self.source_potential * factor,
            sink_potential: self.sink_potential * factor,
            locked: self.locked.clone(),
            surcharge: Vec::new(),
        }
    }

    /// Adds an amount to the cost of every link inside a set of cells.
    ///
    /// Afterwards the matching may not be optimal: the caller has to
    /// [`restore`](super::ShortestPaths::restore_optimum) it.
    /// Lowering the potentials of the black cells by the same amount keeps the reduced costs inside
    /// the set, so that only links along its border have to change.
    pub(crate) fn add_surcharge(&mut self, members: &[Node], amount: i32) {
        let board = self.board;
        self.surcharge.resize(board.node_count(), [0; 2]);
        let mut is_member = vec![false; board.node_count()];
        members.iter().for_each(|&node| is_member[node as usize] = true);
        for &node in members {
            for dir in dirs(board.neighbours[node as usize] & 0b11) {
                if is_member[board.neighbour(node, dir) as usize] {
                    self.surcharge[node as usize][dir] += amount;
                }
            }
            if Board::is_black(node) {
                self.potential[node as usize] -= amount;
            }
        }
    }

    /// The surcharge of the link from a cell in a direction.
    fn surcharge(&self, node: Node, dir: Dir) -> i32 {
        let (node, dir) =
            if dir < 2 { (node, dir) } else { (self.board.neighbour(node, dir), opposite(dir)) };
        self.surcharge[node as usize][dir]
    }
}
