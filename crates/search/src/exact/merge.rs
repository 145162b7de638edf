//! Joining cycles by switches, nearly for nothing.

use crate::matching::{Matching, Node};
use crate::union::Union;

/// Which strand, path or cycle, each cell belongs to, while strands only ever unite.
struct Joined {
    union: Union,
    /// For each root, whether its strand is a cycle.
    is_cycle: Vec<bool>,
}

impl Joined {
    fn new(matching: &Matching<'_>) -> Self {
        let board = matching.board;
        let mut union = Union::new(board.nodes());
        let mut is_cycle = vec![true; board.nodes()];
        for &node in &board.cells {
            for dir in [0, 1] {
                if matching.is_linked(node, dir) {
                    union.unite(board.step(node, dir), node);
                }
            }
        }
        for &node in
            board.cells.iter().filter(|&&node| matching.links[node as usize].count_ones() < 2)
        {
            is_cycle[union.root(node) as usize] = false;
        }
        Self { union, is_cycle }
    }

    /// Whether these two belong to different strands, one of them a cycle: then a switch makes them
    /// one.
    fn can_unite(&mut self, a: Node, b: Node) -> bool {
        let (a, b) = (self.union.root(a), self.union.root(b));
        a != b && (self.is_cycle[a as usize] || self.is_cycle[b as usize])
    }

    fn unite(&mut self, a: Node, b: Node) {
        let (a, b) = (self.union.root(a), self.union.root(b));
        self.union.unite(b, a);
        self.is_cycle[a as usize] &= self.is_cycle[b as usize];
    }
}

/// Switches unit cells at which a cycle meets another strand, as long as that raises no cost.
///
/// Each pass is linear in the cells; there are few.
pub(crate) fn merge(matching: &mut Matching<'_>) {
    let mut joined = Joined::new(matching);
    while merge_once(matching, &mut joined) {}
}

/// Switches unit cells at which a cycle meets another strand, each time the cheapest, until no
/// cycle is left or none can be joined so.
pub(crate) fn merge_at_any_cost(matching: &mut Matching<'_>) {
    let mut joined = Joined::new(matching);
    loop {
        while merge_once(matching, &mut joined) {}
        let board = matching.board;
        let mut cheapest: Option<(i32, Node)> = None;
        for &corner in &board.cells {
            let Some(change) = switch_change(matching, corner) else { continue };
            let cheaper = cheapest.is_none_or(|(least, _)| change < least);
            if cheaper && joined.can_unite(corner, corner + board.stride() as Node + 1) {
                cheapest = Some((change, corner));
            }
        }
        let Some((_, corner)) = cheapest else { return };
        joined.unite(corner, corner + board.stride() as Node + 1);
        switch(matching, corner);
    }
}

fn merge_once(matching: &mut Matching<'_>, joined: &mut Joined) -> bool {
    let board = matching.board;
    let mut merged = false;
    for index in 0..board.cells.len() {
        let corner = board.cells[index];
        let Some(change) = switch_change(matching, corner) else { continue };
        let opposite = corner + board.stride() as Node + 1;
        if change <= 0 && joined.can_unite(corner, opposite) {
            joined.unite(corner, opposite);
            switch(matching, corner);
            merged = true;
        }
    }
    merged
}

/// What switching the unit cell whose top-left cell this is would add to the cost; `None` if it has
/// not two parallel links.
#[inline]
fn switch_change(matching: &Matching<'_>, corner: Node) -> Option<i32> {
    const RIGHT_BELOW: u8 = 0b11;
    const LEFT_ABOVE: u8 = 0b1100;
    let board = matching.board;
    let opposite = corner + board.stride() as Node + 1;
    let sides = matching.links[corner as usize] & RIGHT_BELOW
        | matching.links[opposite as usize] & LEFT_ABOVE;
    let horizontal = match sides {
        0b0101 => true,
        0b1010 => false,
        _ => return None,
    };
    let exists = board.neighbours[corner as usize] & RIGHT_BELOW == RIGHT_BELOW
        && board.neighbours[opposite as usize] & LEFT_ABOVE == LEFT_ABOVE;
    if !exists {
        return None;
    }
    let across =
        board.across[corner as usize] & RIGHT_BELOW | board.across[opposite as usize] & LEFT_ABOVE;
    if across == 0 {
        return Some(0);
    }
    let along_rows = board.cost(corner, 0) + board.cost(opposite, 2);
    let along_columns = board.cost(corner, 1) + board.cost(opposite, 3);
    Some(if horizontal { along_columns - along_rows } else { along_rows - along_columns })
}

fn switch(matching: &mut Matching<'_>, corner: Node) {
    let opposite = corner + matching.board.stride() as Node + 1;
    for (node, dir) in [(corner, 0), (corner, 1), (opposite, 2), (opposite, 3)] {
        matching.toggle(node, dir);
    }
}
