//! The 2-matching that a search begins with: ladders along rows or columns, inside the zones.

use beadwork_grid::Path;

use super::board::{Board, Dir, Node, back, dirs};

/// Which way the ladders run, and where the first one begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Grain {
    /// 0 for ladders along the rows, 1 along the columns.
    pub(crate) along: Dir,
    /// Whether ladders begin at the odd rows or columns of the board.
    pub(crate) odd: bool,
}

/// Links each cell to at most `room` others of its zone.
///
/// Two rows of a zone make a ladder: the cycle around each stretch they have in common.
/// Cells left over are linked to neighbours left over.
/// Long cycles side by side have many unit cells at which they can be joined, and few cells are
/// left with room, all of them at borders: that leaves little to the search that follows.
/// Linear in the cells.
pub(crate) fn ladders(board: &Board, grain: Grain, room: &mut [u8]) -> Vec<u8> {
    let mut links = Inside { board, links: vec![0; board.nodes()], room };
    let across_grain = 1 - grain.along;
    // A rung is a cell whose pair lies in the next row; rails join it to the next rung.
    let is_rung = |node: Node| {
        let (x, y) = board.xy(node);
        let place = if grain.along == 0 { y } else { x };
        (place % 2 == 1) == grain.odd && board.in_zone(node, across_grain)
    };
    let has_rails = |node: Node| {
        let next = board.step(node, grain.along);
        let below = board.step(node, across_grain);
        board.in_zone(node, grain.along) && is_rung(next) && board.in_zone(below, grain.along)
    };
    for &node in board.cells.iter().filter(|&&node| is_rung(node)) {
        let back = back(grain.along);
        let before = board.step(node, back);
        let from_before = board.in_zone(node, back) && is_rung(before) && has_rails(before);
        let to_next = has_rails(node);
        if to_next {
            links.put(node, grain.along);
            links.put(board.step(node, across_grain), grain.along);
        }
        if !(from_before && to_next) {
            links.put(node, across_grain);
        }
    }
    links.fill()
}

/// Links each cell to at most `room` others of its zone: as a path of the layer below does, as far
/// as it goes, and what fits beside that.
///
/// Where the layer below has other cells or other zones, ends of the path's parts are left with
/// room.
/// Linear in the cells.
pub(crate) fn as_below(board: &Board, below: &Path, room: &mut [u8]) -> Vec<u8> {
    let mut links = Inside { board, links: vec![0; board.nodes()], room };
    for &node in &board.cells {
        let cell = board.cell(node);
        for (dir, is_linked) in [(0, below.linked_right(cell)), (1, below.linked_below(cell))] {
            if is_linked && board.in_zone(node, dir) {
                links.put(node, dir);
            }
        }
    }
    links.fill()
}

/// Links inside the zones, and how many more each cell may have.
struct Inside<'a> {
    board: &'a Board,
    links: Vec<u8>,
    room: &'a mut [u8],
}

impl Inside<'_> {
    /// Puts a link in if both cells have room.
    fn put(&mut self, node: Node, dir: Dir) {
        let other = self.board.step(node, dir);
        let full = self.room[node as usize] == 0 || self.room[other as usize] == 0;
        if full || self.links[node as usize] & (1 << dir) != 0 {
            return;
        }
        self.links[node as usize] |= 1 << dir;
        self.links[other as usize] |= 1 << back(dir);
        self.room[node as usize] -= 1;
        self.room[other as usize] -= 1;
    }

    /// Links cells left over to neighbours left over.
    fn fill(mut self) -> Vec<u8> {
        let board = self.board;
        for &node in &board.cells {
            for dir in dirs(board.neighbours[node as usize] & !board.across[node as usize] & 0b11) {
                self.put(node, dir);
            }
        }
        self.links
    }
}
