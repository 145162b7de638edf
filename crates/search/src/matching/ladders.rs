//! The links that the search starts from: ladders along rows or columns, inside the zones.
//!
//! Two adjacent rows of a zone form a *ladder*: a closed cycle around each stretch that both rows
//! have in common.
//! Its *rails* run along the rows, its *rungs* join the two rows at both ends of the stretch:
//!
//! ```text
//!   o--o--o--o--o     rail
//!   |           |     rungs at the ends
//!   o--o--o--o--o     rail
//! ```
//!
//! This is a good start for three reasons.
//! It costs nothing, as no link crosses zones.
//! Nearly every cell has its two links; only cells along the borders of zones lack some, so little
//! is left to do for the augmenting paths.
//! And long cycles side by side meet at many unit cells, where switches can join them later.

use beadwork_grid::Path;

use super::board::{Board, Dir, Node, dirs, opposite};

/// Which way the ladders run, and which rows or columns form pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LadderLayout {
    /// Direction of the rails: 0 along the rows, 1 along the columns.
    pub(crate) along: Dir,
    /// Whether ladders begin at the odd rows or columns of the board, instead of the even ones.
    pub(crate) odd: bool,
}

/// Links cells of the same zone by ladders, then links the cells that still have room to neighbours
/// with room.
///
/// `room` is the number of links that each cell may still have; it is reduced by those made.
/// Returns for each node the set of directions in which it is linked.
/// Linear in the cells.
pub(crate) fn ladders(board: &Board, layout: LadderLayout, room: &mut [u8]) -> Vec<u8> {
    let mut links = LinksInside { board, links: vec![0; board.node_count()], room };
    let LadderLayout { along, odd } = layout;
    let across = 1 - along;
    // A ladder is described by its upper (left) cells: such a cell and its partner in the next row
    // (column) can have a rung between them.
    let has_partner = |node: Node| {
        let (x, y) = board.xy(node);
        let line = if along == 0 { y } else { x };
        (line % 2 == 1) == odd && board.stays_in_zone(node, across)
    };
    // Whether both rails continue from here to the next cell and its partner.
    let continues = |node: Node| {
        let next = board.neighbour(node, along);
        let partner = board.neighbour(node, across);
        board.stays_in_zone(node, along) && has_partner(next) && board.stays_in_zone(partner, along)
    };
    for &node in board.cells.iter().filter(|&&node| has_partner(node)) {
        let back = opposite(along);
        let previous = board.neighbour(node, back);
        let from_previous =
            board.stays_in_zone(node, back) && has_partner(previous) && continues(previous);
        let to_next = continues(node);
        if to_next {
            links.insert(node, along);
            links.insert(board.neighbour(node, across), along);
        }
        // Rungs only at both ends of a stretch: elsewhere the rails use up the two links.
        if !(from_previous && to_next) {
            links.insert(node, across);
        }
    }
    links.fill()
}

/// Links cells of the same zone where the path of the layer below links them, then links the cells
/// that still have room to neighbours with room.
///
/// Where the layer below has other cells or other zones, its path is interrupted, and the cells
/// around keep room.
/// `room` and the result are as for [`ladders`].
/// Linear in the cells.
pub(crate) fn as_below(board: &Board, below: &Path, room: &mut [u8]) -> Vec<u8> {
    let mut links = LinksInside { board, links: vec![0; board.node_count()], room };
    for &node in &board.cells {
        let cell = board.cell(node);
        for (dir, is_linked) in [(0, below.linked_right(cell)), (1, below.linked_below(cell))] {
            if is_linked && board.stays_in_zone(node, dir) {
                links.insert(node, dir);
            }
        }
    }
    links.fill()
}

/// Links inside the zones, and how many more each cell may have.
struct LinksInside<'a> {
    board: &'a Board,
    links: Vec<u8>,
    room: &'a mut [u8],
}

impl LinksInside<'_> {
    /// Inserts a link if both cells have room and it is not there yet.
    fn insert(&mut self, node: Node, dir: Dir) {
        let other = self.board.neighbour(node, dir);
        let is_full = self.room[node as usize] == 0 || self.room[other as usize] == 0;
        if is_full || self.links[node as usize] & (1 << dir) != 0 {
            return;
        }
        self.links[node as usize] |= 1 << dir;
        self.links[other as usize] |= 1 << opposite(dir);
        self.room[node as usize] -= 1;
        self.room[other as usize] -= 1;
    }

    /// Inserts links between neighbours of the same zone that both have room; returns all links.
    fn fill(mut self) -> Vec<u8> {
        let board = self.board;
        for &node in &board.cells {
            for dir in dirs(board.neighbours[node as usize] & !board.across[node as usize] & 0b11) {
                self.insert(node, dir);
            }
        }
        self.links
    }
}
