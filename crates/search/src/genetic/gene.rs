//! Genes: the entries of an individual's list of moves.

use crate::Move;

/// An entry of an individual's list of moves; `None` is a blank, which does nothing.
pub(super) type Gene = Option<Move>;

/// Moves as genes, padded with blanks.
pub(super) fn padded(moves: &[Move], length: usize) -> Vec<Gene> {
    let mut genes: Vec<Gene> = moves.iter().copied().map(Some).collect();
    genes.resize(length, None);
    genes
}
