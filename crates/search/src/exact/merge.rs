//! Joining cycles to other strands by switches of unit cells.
//!
//! A *unit cell* is a square of four neighbouring cells.
//! If two of its sides are links and these are parallel, a *switch* replaces them by the other two
//! sides:
//!
//! ```text
//!    a---b          a   b
//!            <->    |   |
//!    c---d          c   d
//! ```
//!
//! If a-b and c-d belong to different strands, and at least one of these is a cycle, the switch
//! makes them one strand: the cycle is cut open and inserted where the other strand is cut.
//! (Two paths would only exchange their tails; a switch within a single strand would split it or
//! reverse a part of it.)
//! The number of links at each cell stays the same.
//!
//! Strands only grow in this process, so disjoint sets keep track of them.

use crate::disjoint_sets::DisjointSets;
use crate::matching::{Node, TwoMatching};

/// Switches unit cells at which a cycle meets another strand, as long as one can be found that does
/// not raise the cost.
///
/// Each pass over the cells is linear; a few passes are enough.
pub(super) fn merge(matching: &mut TwoMatching<'_>) {
    let mut strands = StrandSets::new(matching);
    while merge_once(matching, &mut strands) {}
}

/// Switches unit cells at which a cycle meets another strand, each time the cheapest, until no
/// cycle is left or none can be joined by a switch.
///
/// Each switch that costs something takes a pass over the cells.
pub(super) fn merge_at_any_cost(matching: &mut TwoMatching<'_>) {
    let mut strands = StrandSets::new(matching);
    loop {
        while merge_once(matching, &mut strands) {}
        let board = matching.board;
        let mut cheapest: Option<(i32, Node)> = None;
        for &corner in &board.cells {
            let Some(change) = cost_change(matching, corner) else { continue };
            let is_cheaper = cheapest.is_none_or(|(min, _)| change < min);
            if is_cheaper && strands.can_join(corner, opposite_corner(matching, corner)) {
                cheapest = Some((change, corner));
            }
        }
        let Some((_, corner)) = cheapest else { return };
        strands.join(corner, opposite_corner(matching, corner));
        switch(matching, corner);
    }
}

/// One pass over all unit cells.
/// Returns whether any was switched.
fn merge_once(matching: &mut TwoMatching<'_>, strands: &mut StrandSets) -> bool {
    let board = matching.board;
    let mut is_changed = false;
    for &corner in &board.cells {
        let Some(change) = cost_change(matching, corner) else { continue };
        let opposite = opposite_corner(matching, corner);
        if change <= 0 && strands.can_join(corner, opposite) {
            strands.join(corner, opposite);
            switch(matching, corner);
            is_changed = true;
        }
    }
    is_changed
}

/// The bottom-right cell of the unit cell whose top-left cell is `corner`.
///
/// In a unit cell with two parallel links these two corners are at different links, whichever way
/// the links run.
fn opposite_corner(matching: &TwoMatching<'_>, corner: Node) -> Node {
    corner + matching.board.stride() as Node + 1
}

/// Change of the cost by switching a unit cell, named by its top-left cell.
/// `None` if the unit cell can't be switched: two of its sides have to be links, and parallel, and
/// all four cells have to exist.
#[inline]
fn cost_change(matching: &TwoMatching<'_>, corner: Node) -> Option<i32> {
    const RIGHT_AND_DOWN: u8 = 0b11;
    const LEFT_AND_UP: u8 = 0b1100;

    let board = matching.board;
    let opposite = opposite_corner(matching, corner);
    // The top and left sides are seen from the top-left cell, the bottom and right sides from the
    // bottom-right cell.
    let sides = |sets: &[u8]| {
        sets[corner as usize] & RIGHT_AND_DOWN | sets[opposite as usize] & LEFT_AND_UP
    };
    let is_horizontal = match sides(&matching.links) {
        0b0101 => true,
        0b1010 => false,
        _ => return None,
    };
    if sides(&board.neighbours) != RIGHT_AND_DOWN | LEFT_AND_UP {
        return None;
    }
    if sides(&board.across) == 0 {
        return Some(0);
    }
    let horizontal = board.link_cost(corner, 0) + board.link_cost(opposite, 2);
    let vertical = board.link_cost(corner, 1) + board.link_cost(opposite, 3);
    Some(if is_horizontal { vertical - horizontal } else { horizontal - vertical })
}

/// Switches a unit cell, named by its top-left cell.
fn switch(matching: &mut TwoMatching<'_>, corner: Node) {
    let opposite = opposite_corner(matching, corner);
    for (node, dir) in [(corner, 0), (corner, 1), (opposite, 2), (opposite, 3)] {
        matching.toggle(node, dir);
    }
}

/// The strand of each cell, while strands are only joined.
struct StrandSets {
    sets: DisjointSets,
    /// For each representative whether its strand is a cycle.
    is_cycle: Vec<bool>,
}

impl StrandSets {
    fn new(matching: &TwoMatching<'_>) -> Self {
        let board = matching.board;
        let mut sets = DisjointSets::new(board.node_count());
        let mut is_cycle = vec![true; board.node_count()];
        for &node in &board.cells {
            for dir in [0, 1] {
                if matching.is_linked(node, dir) {
                    sets.union(board.neighbour(node, dir), node);
                }
            }
        }
        let is_end = |&&node: &&Node| matching.links[node as usize].count_ones() < 2;
        for &node in board.cells.iter().filter(is_end) {
            is_cycle[sets.find(node) as usize] = false;
        }
        Self { sets, is_cycle }
    }

    /// Whether two cells belong to different strands, at least one of which is a cycle.
    fn can_join(&mut self, a: Node, b: Node) -> bool {
        let (a, b) = (self.sets.find(a), self.sets.find(b));
        a != b && (self.is_cycle[a as usize] || self.is_cycle[b as usize])
    }

    /// Records that the strands of two cells have been joined.
    fn join(&mut self, a: Node, b: Node) {
        let (a, b) = (self.sets.find(a), self.sets.find(b));
        self.sets.union(b, a);
        self.is_cycle[a as usize] &= self.is_cycle[b as usize];
    }
}
