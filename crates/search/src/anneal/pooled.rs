//! The annealer of Aali et al., section "Simulated annealing": variants drawn from a pool of
//! feasible ones.
//!
//! A variant rewires a window of at most 3 x 3 cells and keeps the number of pieces.
//! Of all variants at all positions only few apply, so testing random ones would mostly fail.
//! The annealer therefore collects those that apply, the *pool*, and draws from it.
//! Accepted moves make pool entries obsolete and new ones possible, so each draw is tested again,
//! and the pool is filled again after a fixed number of iterations.
//!
//! The temperature follows a sigmoid: it stays high at first, falls steeply halfway through, and
//! stays low at the end.
//! When no new best path was found for many iterations, the run is *reheated*: the upper end of the
//! sigmoid is raised by a factor.

use beadwork_grid::{Path, PlacedVariant, VariantKind};

use super::method::Pooled;
use super::run::Run;
use super::settings::Outcome;
use crate::random::{below, unit};
use crate::{Cost, Move};

impl Pooled {
    /// The temperature at an iteration: a sigmoid from `hot`, which reheats may have raised, down
    /// to `cold`.
    fn temperature(&self, iteration: u32, hot: f64) -> f64 {
        let n = f64::from(self.iterations);
        // Falls from 5 at the first iteration through 0 halfway to -5 at the last.
        let x = 10.0 / n * (n / 2.0 - f64::from(iteration));
        self.cold + (hot - self.cold) / (1.0 + libm::exp(-x))
    }
}

pub(super) fn anneal<C: Cost>(pooled: &Pooled, mut run: Run<'_>, cost: &C) -> Outcome {
    let width = run.path.width();
    let planned = u64::from(pooled.iterations);
    let first_with_flips = (f64::from(pooled.iterations) * pooled.transposes_only) as u32;
    let mut hot = pooled.hot;
    let mut pool = Pool::new(pooled.pool);
    let mut pool_age = pooled.pool_life;
    let mut last_gain = 0;

    for iteration in 0..pooled.iterations {
        if iteration - last_gain >= pooled.patience {
            hot = pooled.hottest.min(hot * pooled.reheat);
            // The patience starts again, and the pool is filled again below.
            last_gain = iteration;
            pool_age = pooled.pool_life;
        }
        if pool_age >= pooled.pool_life || iteration == first_with_flips {
            let kinds: &[VariantKind] = if iteration < first_with_flips {
                &[VariantKind::Transpose]
            } else {
                &[VariantKind::Transpose, VariantKind::Flip]
            };
            pool.fill(&run.path, kinds);
            pool_age = 0;
            run.report(u64::from(iteration), planned, pooled.temperature(iteration, hot));
            if let Some(stop) = run.should_stop() {
                return run.finish(stop, u64::from(iteration));
            }
        }
        pool_age += 1;
        if pool.moves.is_empty() {
            // No move applies, so the path stays as it is; flips may apply later.
            continue;
        }
        let placed = pool.moves[below(&mut run.rng, pool.moves.len())];
        // An earlier move may have made this one obsolete.
        if !run.path.allows_variant(placed) {
            continue;
        }
        let change = cost.change(placed.switches(width));
        let is_accepted = change <= 0
            || unit(&mut run.rng)
                < libm::exp(-(change as f64) / pooled.temperature(iteration, hot));
        if is_accepted
            && run.path.apply_variant(placed)
            && run.accept(Move::Variant(placed), change)
        {
            last_gain = iteration;
        }
    }
    run.complete(planned)
}

/// The moves to draw from.
struct Pool {
    capacity: usize,
    moves: Vec<PlacedVariant>,
    /// The applicable moves of each ring of windows, the outermost ring first.
    rings: Vec<Vec<PlacedVariant>>,
}

impl Pool {
    fn new(capacity: usize) -> Self {
        Self { capacity, moves: Vec::new(), rings: Vec::new() }
    }

    /// Replaces the pool by the moves that apply now, up to its capacity.
    ///
    /// Moves are taken from the border of the grid inwards, ring by ring, and within a ring row by
    /// row: in a zigzag only the turns along the border allow moves, and the moves that rewire the
    /// inside start there.
    fn fill(&mut self, path: &Path, kinds: &[VariantKind]) {
        let (columns, rows) = (path.width().saturating_sub(1), path.height().saturating_sub(1));
        self.rings.iter_mut().for_each(Vec::clear);
        self.rings.resize(columns.min(rows).div_ceil(2) as usize, Vec::new());
        path.for_each_variant(kinds, |placed| {
            let (x, y) = (u32::from(placed.x), u32::from(placed.y));
            let ring = x.min(y).min(columns - 1 - x).min(rows - 1 - y);
            self.rings[ring as usize].push(placed);
        });
        self.moves.clear();
        self.moves.extend(self.rings.iter().flatten().take(self.capacity));
    }
}
