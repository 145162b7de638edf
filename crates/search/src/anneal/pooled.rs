//! The annealer of Aali et al., section "Simulated annealing": variants drawn from a pool of
//! feasible ones.

use beadwork_grid::{Path, PlacedVariant, VariantKind};

use super::{Outcome, Run, Settings};
use crate::random::{below, unit};
use crate::{Cost, Move};

/// Parameters of the paper's annealer; the default is its standard run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pooled {
    /// Moves to propose.
    pub iterations: u32,
    /// Temperature at the beginning, in units of the cost.
    pub hot: f64,
    /// Temperature at the end.
    pub cold: f64,
    /// Share of the iterations in which only transposes are tried, 0..=1; then flips too.
    pub transposes_only: f64,
    /// Largest number of moves in the pool.
    pub pool: usize,
    /// Iterations after which the pool is made anew.
    pub pool_life: u32,
    /// Iterations without a new best after which the run is heated up.
    pub patience: u32,
    /// Factor on `hot` at each reheat.
    pub reheat: f64,
    /// Largest `hot` that reheats lead to.
    pub hottest: f64,
}

impl Default for Pooled {
    fn default() -> Self {
        Self {
            iterations: 5000,
            hot: 80.0,
            cold: 0.5,
            transposes_only: 0.6,
            pool: 5000,
            pool_life: 250,
            patience: 3000,
            reheat: 1.5,
            hottest: 600.0,
        }
    }
}

impl Pooled {
    /// The temperature at an iteration, given the present `hot`: a sigmoid from there down to
    /// `cold`.
    fn temperature(&self, iteration: u32, hot: f64) -> f64 {
        let n = f64::from(self.iterations);
        let at = 10.0 / n * (n / 2.0 - f64::from(iteration));
        self.cold + (hot - self.cold) / (1.0 + libm::exp(-at))
    }
}

pub(super) fn run<C: Cost>(
    pooled: &Pooled,
    start: Path,
    cost: &C,
    settings: &Settings<'_>,
) -> Outcome {
    let mut run = Run::new(start, cost, settings);
    let width = run.path.width();
    let first_flips = (f64::from(pooled.iterations) * pooled.transposes_only) as u32;
    let mut hot = pooled.hot;
    let mut pool = Pool::new(pooled.pool);
    let mut pool_age = pooled.pool_life;
    let mut last_gain = 0;

    for iteration in 0..pooled.iterations {
        if iteration - last_gain >= pooled.patience {
            hot = pooled.hottest.min(hot * pooled.reheat);
            last_gain = iteration;
            pool_age = pooled.pool_life;
        }
        if pool_age >= pooled.pool_life || iteration == first_flips {
            let kinds: &[VariantKind] = if iteration < first_flips {
                &[VariantKind::Transpose]
            } else {
                &[VariantKind::Transpose, VariantKind::Flip]
            };
            pool.fill(&run.path, kinds);
            pool_age = 0;
            let temperature = pooled.temperature(iteration, hot);
            run.observe(u64::from(iteration), u64::from(pooled.iterations), temperature);
            if let Some(stop) = run.stop() {
                return run.finish(stop, u64::from(iteration));
            }
        }
        pool_age += 1;
        if pool.moves.is_empty() {
            // Nothing to draw until the pool is made anew, and the path does not change before.
            continue;
        }
        let placed = pool.moves[below(&mut run.rng, pool.moves.len())];
        if !run.path.allows_variant(placed) {
            continue;
        }
        let change = cost.change(placed.switches(width));
        let taken = change <= 0
            || unit(&mut run.rng)
                < libm::exp(-(change as f64) / pooled.temperature(iteration, hot));
        if taken && run.path.apply_variant(placed) && run.accept(Move::Variant(placed), change) {
            last_gain = iteration;
        }
    }
    run.complete(u64::from(pooled.iterations))
}

/// The moves to draw from.
struct Pool {
    capacity: usize,
    moves: Vec<PlacedVariant>,
    /// Those of each ring of windows, the outermost first.
    rings: Vec<Vec<PlacedVariant>>,
}

impl Pool {
    fn new(capacity: usize) -> Self {
        Self { capacity, moves: Vec::new(), rings: Vec::new() }
    }

    /// Takes the moves that apply now, from the border of the plane inwards, ring by ring, row by
    /// row in each, as far as the capacity goes.
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
