//! The 2-matching that a search begins with: ladders along rows or columns, inside the zones.

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
/// Two rows of a zone make a ladder: the cycle around each stretch they have in common. Cells left over are linked to
/// neighbours left over. Long cycles side by side have many unit cells at which they can be joined, and few cells are left
/// with room, all of them at borders: that leaves little to the search that follows. Linear in the cells.
pub(crate) fn ladders(board: &Board, grain: Grain, room: &mut [u8]) -> Vec<u8> {
    let mut links = vec![0; board.nodes()];
    let across_grain = 1 - grain.along;
    let same_zone = |node: Node, dir: Dir| {
        (board.neighbours[node as usize] & !board.across[node as usize]) & (1 << dir) != 0
    };
    let mut link = |room: &mut [u8], node: Node, dir: Dir| {
        let other = board.step(node, dir);
        let full = room[node as usize] == 0 || room[other as usize] == 0;
        if full || links[node as usize] & (1 << dir) != 0 {
            return;
        }
        links[node as usize] |= 1 << dir;
        links[other as usize] |= 1 << back(dir);
        room[node as usize] -= 1;
        room[other as usize] -= 1;
    };
    // A rung is a cell whose pair lies in the next row; rails join it to the next rung.
    let is_rung = |node: Node| {
        let (x, y) = board.xy(node);
        let place = if grain.along == 0 { y } else { x };
        (place % 2 == 1) == grain.odd && same_zone(node, across_grain)
    };
    let has_rails = |node: Node| {
        let next = board.step(node, grain.along);
        let below = board.step(node, across_grain);
        same_zone(node, grain.along) && is_rung(next) && same_zone(below, grain.along)
    };
    for &node in board.cells.iter().filter(|&&node| is_rung(node)) {
        let before = board.step(node, back(grain.along));
        let from_before = same_zone(node, back(grain.along)) && is_rung(before) && has_rails(before);
        let to_next = has_rails(node);
        if to_next {
            link(room, node, grain.along);
            link(room, board.step(node, across_grain), grain.along);
        }
        if !(from_before && to_next) {
            link(room, node, across_grain);
        }
    }
    for &node in &board.cells {
        for dir in dirs(board.neighbours[node as usize] & !board.across[node as usize] & 0b11) {
            link(room, node, dir);
        }
    }
    links
}
