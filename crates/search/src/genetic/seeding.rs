//! The first population: the best of many annealing runs.

use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::Control;
use beadwork_grid::Path;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::settings::Settings;
use crate::anneal::{self, Method, Outcome};
use crate::{Cost, Move};

/// Anneals a first population: returns the moves of the best runs, the best run first, at most as
/// many as there are to be individuals.
///
/// An interrupted call returns those of the runs that were complete.
///
/// Progress counts annealing runs.
/// Works on `control.threads`; each run has its own seed, so the result does not depend on them.
pub fn annealed<C: Cost + Sync>(
    start: &Path,
    cost: &C,
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Vec<Vec<Move>> {
    let &Settings { ref seeding, proven_bound, target, .. } = settings;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let methods = seeding.methods.iter().cycle();
    let runs: Vec<(Method, u64)> =
        methods.map(|&method| (method, rng.next_u64())).take(seeding.runs as usize).collect();
    let done = AtomicUsize::new(0);
    let run_control = control.without_progress().on_one_thread();
    let run = |&(method, seed): &(Method, u64)| {
        control.check().ok()?;
        let settings =
            anneal::Settings { method, seed, proven_bound, target, ..anneal::Settings::default() };
        let Outcome { cost, moves, .. } = anneal::solve(start, cost, &settings, &run_control);
        control.report(done.fetch_add(1, Ordering::Relaxed) + 1, runs.len());
        Some((cost, moves))
    };
    let mut outcomes: Vec<(i64, Vec<Move>)> =
        control.threads.map(&runs, run).into_iter().flatten().collect();
    // A stable sort: of equally good runs, the first one comes first.
    outcomes.sort_by_key(|&(cost, _)| cost);
    outcomes.truncate(settings.evolution.population);
    outcomes.into_iter().map(|(_, moves)| moves).collect()
}
