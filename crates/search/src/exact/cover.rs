//! A cover of one component: its pieces, in the order and directions of the final path.

use super::strands::Strands;
use crate::CostMatrix;
use crate::matching::{Board, Node, TwoMatching};

/// Paths that together hold every cell of a component once.
pub(super) struct Cover {
    /// The cells, piece after piece.
    pub(super) order: Vec<Node>,
    /// Index in `order` at which the last piece begins.
    pub(super) last_piece: usize,
    /// Number of pieces.
    pub(super) pieces: u32,
    /// Cost of the crossings, in the direction of each piece.
    pub(super) cost: u64,
}

/// Constraints on the ends of a component's cover.
#[derive(Clone, Copy)]
pub(super) struct CoverEnds {
    /// The cell at which the first piece begins, if it is given.
    pub(super) first: Option<Node>,
    /// The cell at which the last piece ends, if it is given.
    pub(super) last: Option<Node>,
    /// Whether these two must lie on different pieces.
    pub(super) in_different_pieces: bool,
}

impl Cover {
    /// Makes a cover of the paths of a 2-matching; cycles that are left are cut open.
    ///
    /// Each piece takes the direction in which its crossings cost less, unless one of its ends is
    /// given.
    /// Linear in the cells.
    pub(super) fn new(
        matching: &TwoMatching<'_>,
        strands: &Strands,
        board: &Board,
        costs: &CostMatrix,
        ends: CoverEnds,
    ) -> Self {
        let mut pieces = strands.pieces(matching);
        order_pieces(&mut pieces, ends);
        let CoverEnds { first, last, .. } = ends;
        let cost = |piece: &[Node]| -> u64 {
            piece
                .windows(2)
                .map(|step| u64::from(costs.scaled(board.zone(step[0]), board.zone(step[1]))))
                .sum()
        };
        let mut total = 0;
        for piece in &mut pieces {
            let forward = cost(piece);
            let is_fixed = first == Some(piece[0]) || last == Some(piece[piece.len() - 1]);
            piece.reverse();
            let backward = cost(piece);
            if is_fixed || forward <= backward {
                piece.reverse();
            }
            total += if is_fixed { forward } else { forward.min(backward) };
        }
        let cells = pieces.iter().map(Vec::len).sum::<usize>();
        let last_piece = cells - pieces.last().map_or(0, Vec::len);
        Self { pieces: pieces.len() as u32, cost: total, last_piece, order: pieces.concat() }
    }
}

/// Sorts pieces, and reverses those that hold a given end, so that the path begins at `first` and
/// ends at `last`; cuts a piece in two if it holds both and must not.
///
/// The 2-matching reserves room for both ends, so each is an end of a piece.
fn order_pieces(pieces: &mut Vec<Vec<Node>>, ends: CoverEnds) {
    let CoverEnds { first, last, in_different_pieces } = ends;
    // From top to bottom and left to right, so that the travel moves between pieces stay short.
    pieces.sort_unstable_by_key(|piece| piece.iter().min().copied());
    let ends_at =
        |piece: &Vec<Node>, node: Node| piece[0] == node || piece[piece.len() - 1] == node;
    if let Some(first) = first {
        let index = pieces
            .iter()
            .position(|piece| ends_at(piece, first))
            .expect("a reserved cell is an end of a piece");
        let mut piece = pieces.remove(index);
        if piece[0] != first {
            piece.reverse();
        }
        pieces.insert(0, piece);
    }
    if let Some(last) = last {
        let index = pieces
            .iter()
            .position(|piece| ends_at(piece, last))
            .expect("a reserved cell is an end of a piece");
        let mut piece = pieces.remove(index);
        let holds_both = first.is_some_and(|first| ends_at(&piece, first));
        if holds_both && (in_different_pieces || !pieces.is_empty()) {
            if piece[0] == last {
                piece.reverse();
            }
            let rest = piece.split_off(piece.len() / 2);
            pieces.insert(0, piece);
            piece = rest;
        }
        if piece[piece.len() - 1] != last {
            piece.reverse();
        }
        pieces.push(piece);
    }
}
