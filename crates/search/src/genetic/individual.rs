//! Individuals, and what a population of them comes to.

use std::sync::Arc;

use super::Generation;
use super::replay::Mark;
use crate::Move;

/// One place of a list of moves; blanks do nothing.
pub(super) type Gene = Option<Move>;

/// A list of moves that has been replayed.
#[derive(Clone)]
pub(super) struct Individual<S> {
    pub(super) genes: Arc<[Gene]>,
    /// Lowest cost on the way.
    pub(super) cost: i64,
    /// Genes up to there.
    pub(super) best_at: usize,
    /// States on the way, to replay children from.
    pub(super) marks: Vec<Arc<Mark<S>>>,
    /// Genes that were tried to find out, blanks not counted.
    pub(super) replayed: u64,
    /// Genes that were known from a parent.
    pub(super) spared: u64,
    /// Whether it differs from its parents.
    pub(super) is_new: bool,
}

impl<S: Clone> Individual<S> {
    /// A child that is no different.
    pub(super) fn copy(&self) -> Self {
        Self { replayed: 0, spared: self.genes.len() as u64, is_new: false, ..self.clone() }
    }
}

/// Moves as genes.
pub(super) fn padded(moves: &[Move], length: usize) -> Vec<Gene> {
    let mut genes: Vec<Gene> = moves.iter().copied().map(Some).collect();
    genes.resize(length, None);
    genes
}

/// What a population, sorted by cost, comes to.
pub(super) fn describe<S>(all: &[Individual<S>], number: u32, stayed: u32) -> Generation {
    let best = &all[0];
    let sum: i64 = all.iter().map(|individual| individual.cost).sum();
    let differences: f64 =
        all.iter().map(|individual| difference(&individual.genes, &best.genes)).sum();
    Generation {
        number,
        best: best.cost,
        mean: sum as f64 / all.len() as f64,
        diversity: differences / all.len() as f64,
        stayed,
    }
}

/// Share of the genes that differ, of at most 256 at equal distances.
fn difference(one: &Arc<[Gene]>, other: &Arc<[Gene]>) -> f64 {
    const LOOKED_AT: usize = 256;

    if Arc::ptr_eq(one, other) || one.is_empty() {
        return 0.0;
    }
    let step = one.len().div_ceil(LOOKED_AT);
    let pairs = one.iter().step_by(step).zip(other.iter().step_by(step));
    let differing = pairs.filter(|(a, b)| a != b).count();
    differing as f64 / one.len().div_ceil(step) as f64
}
