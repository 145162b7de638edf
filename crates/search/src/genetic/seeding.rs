//! The first population: the best of many annealing runs.

use std::sync::atomic::{AtomicU64, Ordering};

use beadwork_grid::Path;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{Progress, Settings};
use crate::anneal::{self, Method, Outcome, anneal};
use crate::parallel::in_parallel;
use crate::{Cost, Move};

/// Which annealing runs the first population comes from.
///
/// The default is what the paper says of its data: 22,111 runs of five presets over 24 combinations
/// of layout and size are 920 for each.
#[derive(Clone, Debug, PartialEq)]
pub struct Seeding {
    /// The annealers, which take turns.
    /// All of one sort, [`Method::Pooled`] or [`Method::Free`], if their moves are to be recorded.
    pub methods: Vec<Method>,
    /// Runs in all; the best make up the population.
    pub runs: u32,
}

impl Default for Seeding {
    fn default() -> Self {
        let presets = anneal::Preset::ALL.map(anneal::Preset::method);
        let pooled = presets.into_iter().filter(|method| matches!(method, Method::Pooled(_)));
        Self { methods: pooled.collect(), runs: 920 }
    }
}

/// Anneals a first population: the moves of the best runs, the best first, at most as many as there
/// shall be individuals.
///
/// Runs are told apart by seeds of their own, so the result does not depend on the threads.
/// A cancelled call gives those that were done.
pub fn annealed<C: Cost + Sync>(start: &Path, cost: &C, settings: &Settings<'_>) -> Vec<Vec<Move>> {
    let Settings { seeding, bound, cancel, .. } = settings;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let methods = seeding.methods.iter().cycle();
    let runs: Vec<(Method, u64)> =
        methods.map(|&method| (method, rng.next_u64())).take(seeding.runs as usize).collect();
    let done = AtomicU64::new(0);
    let run = |(): &mut (), &(method, seed): &(Method, u64)| {
        if settings.is_cancelled() {
            return None;
        }
        let settings_of_run =
            anneal::Settings { method, seed, bound: *bound, cancel: *cancel, observer: None };
        let Outcome { cost, moves, .. } = anneal(start.clone(), cost, &settings_of_run);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(observer) = settings.observer {
            observer(Progress::Seeded(done));
        }
        Some((cost, moves))
    };
    let mut outcomes: Vec<(i64, Vec<Move>)> =
        in_parallel(settings.pool, &runs, || (), run).into_iter().flatten().collect();
    // Stable: of equally good ones the first.
    outcomes.sort_by_key(|&(cost, _)| cost);
    outcomes.truncate(settings.evolution.population);
    outcomes.into_iter().map(|(_, moves)| moves).collect()
}
