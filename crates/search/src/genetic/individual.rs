//! Individuals, and statistics of a population.

use std::sync::Arc;

use super::gene::Gene;
use super::settings::Generation;

/// Costs at some point of a replay.
#[derive(Clone, Copy)]
pub(super) struct Score {
    pub(super) current: i64,
    pub(super) best: i64,
    /// Number of genes up to the best cost.
    pub(super) best_at: usize,
}

/// A replay that has been stopped between two genes.
pub(super) struct Snapshot<S> {
    pub(super) score: Score,
    pub(super) state: S,
}

/// A list of moves that has been replayed, and the results of its replay.
#[derive(Clone)]
pub(super) struct Individual<S> {
    pub(super) genes: Arc<[Gene]>,
    /// Lowest cost during the replay.
    pub(super) cost: i64,
    /// Number of genes up to that cost.
    pub(super) best_at: usize,
    /// States during the replay, from which children can be replayed.
    pub(super) snapshots: Vec<Arc<Snapshot<S>>>,
    /// Number of genes replayed to find the cost, without blanks.
    pub(super) replayed: u64,
    /// Number of genes that a parent's snapshot saved from being replayed.
    pub(super) spared: u64,
    /// Whether it differs from its parents.
    pub(super) is_new: bool,
}

impl<S: Clone> Individual<S> {
    /// A child with the same genes.
    pub(super) fn copy(&self) -> Self {
        Self { replayed: 0, spared: self.genes.len() as u64, is_new: false, ..self.clone() }
    }
}

/// Statistics of a population that is sorted by cost.
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

/// Share of the genes that differ; of long lists, 256 genes at equal distances are compared.
fn difference(one: &Arc<[Gene]>, other: &Arc<[Gene]>) -> f64 {
    const COMPARED: usize = 256;

    if Arc::ptr_eq(one, other) || one.is_empty() {
        return 0.0;
    }
    let step = one.len().div_ceil(COMPARED);
    let pairs = one.iter().step_by(step).zip(other.iter().step_by(step));
    let differing = pairs.filter(|(a, b)| a != b).count();
    differing as f64 / one.len().div_ceil(step) as f64
}
