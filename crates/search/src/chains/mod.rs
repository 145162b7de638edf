//! Local search by chains of variants, which lowers the cost in few moves.
//!
//! On a zigzag, almost no single variant lowers the cost.
//! Variants apply where the path turns, at the sides of the layer, and a turn has to be moved to a
//! zone border, window by window, before the cost changes.
//! An annealer finds such sequences by chance, within many hundreds of moves.
//!
//! This search finds them on purpose.
//! A **chain** is a sequence of variants of which each overlaps the one before.
//! From every variant that applies, a beam search (`grow.rs`) looks for the chain with the largest
//! gain per move; the best chain of all is applied, and so on until none has a gain.
//! A beam search depends only on the cells that it examined, so its result is kept until a move
//! changes one of them.
//!
//! The few moves make records of this search good examples to learn from.
//! With [`noise`](Settings::noise) some moves are replaced by random ones, and the chains after
//! them show how to recover.
//! For the lowest cost regardless of the moves, see [`exact`](crate::exact).
//!
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::chains::{self, Settings};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Islands).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let cost = Crossings::new(&region, &zones);
//! let settings = Settings { target: Some(28), ..Settings::default() };
//! let outcome = chains::solve(&start, &cost, &settings, &Control::default());
//! assert!(outcome.cost <= 28 && outcome.moves.len() < 60);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod grow;
mod preset;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use beadwork_base::Control;
use beadwork_grid::{Links, Path, PlacedVariant};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

pub use preset::Preset;

use self::grow::{Beam, Chain, Extent, Grower};
use crate::random::{below, unit};
use crate::stop::Goal;
use crate::{Cost, Move, Stop};

/// Settings of the search for chains.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width of the beam, at least 1: the number of chains from one variant that are extended
    /// together.
    pub beam: usize,
    /// Maximum number of moves of a chain.
    pub depth: usize,
    /// Number of moves beyond the best chain so far after which its beam search ends.
    pub patience: usize,
    /// Probability, 0..=1, that a random move is made instead of the next move of a chain, whose
    /// rest is then dropped.
    pub noise: f64,
    /// Seed of the random moves.
    pub seed: u64,
    /// A lower bound of the cost of all paths, which **the caller has proven**.
    /// A search that reaches it stops with [`Stop::Optimal`].
    pub proven_bound: Option<i64>,
    /// A cost that is good enough: a search that reaches it stops with [`Stop::TargetReached`].
    pub target: Option<i64>,
}

impl Default for Settings {
    /// No noise, bound or target.
    fn default() -> Self {
        Self {
            beam: 4,
            depth: 60,
            patience: 4,
            noise: 0.0,
            seed: 0,
            proven_bound: None,
            target: None,
        }
    }
}

impl Settings {
    /// The noise of a preset with a seed, and otherwise the default settings.
    pub fn preset(preset: Preset, seed: u64) -> Self {
        Self { noise: preset.noise(), seed, ..Self::default() }
    }

    fn limits(&self) -> Beam {
        Beam { width: self.beam, depth: self.depth, patience: self.patience }
    }
}

/// Result of a search for chains.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The path of the lowest cost.
    pub path: Path,
    /// Cost of the start path.
    pub initial: i64,
    /// Cost of the best path, at most `initial`.
    pub cost: i64,
    /// The lower bound of [`Settings::proven_bound`].
    pub proven_bound: Option<i64>,
    /// Why the search stopped.
    pub stop: Stop,
    /// The moves from the start path to the best one: replayed in order, all of them apply and lead
    /// to it.
    pub moves: Vec<Move>,
}

/// Lowers the cost of a path by chains of variants.
///
/// Reports no progress, since the number of chains is not known in advance.
/// Works on the calling thread.
///
/// The time of the beam search from one variant is proportional to the cells that it reaches: about
/// 100 µs on a zigzag of 30 x 30 cells, milliseconds where short chains have no gain.
/// The first step searches from every variant that applies, later steps only where cells changed.
pub fn solve<C: Cost>(
    start: &Path,
    cost: &C,
    settings: &Settings,
    control: &Control<'_>,
) -> Outcome {
    let &Settings { noise, proven_bound, target, .. } = settings;
    let goal = Goal { proven_bound, target };
    let grower = Grower::new(start, cost, settings.limits());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let mut links = Links::new(start);
    let initial = cost.total(start);
    let (mut current, mut best) = (initial, initial);
    let (mut moves, mut moves_to_best) = (Vec::new(), 0);
    // The best chain from each variant, and the cells that the search for it examined.
    let mut known: HashMap<PlacedVariant, (Option<Chain>, Extent)> = HashMap::new();
    let stop = 'search: loop {
        if let Some(reached) = goal.reached(best) {
            break reached;
        }
        let firsts = applicable(&links);
        for &first in &firsts {
            if let Some(interrupted) = control.interrupted() {
                break 'search interrupted.into();
            }
            known.entry(first).or_insert_with(|| grower.grow(&mut links, first));
        }
        let last = moves.last().copied();
        let mut chosen: Option<&Chain> = None;
        for chain in firsts.iter().filter_map(|first| known[first].0.as_ref()) {
            if chosen.is_none_or(|chosen| chain.is_better_than(chosen, last)) {
                chosen = Some(chain);
            }
        }
        let Some(chain) = chosen.map(|chain| chain.moves.clone()) else { break Stop::Done };
        for planned in chain {
            let is_random = noise > 0.0 && unit(&mut rng) < noise;
            let placed = if is_random {
                let all = applicable(&links);
                all[below(&mut rng, all.len())]
            } else {
                planned
            };
            assert!(links.apply_variant(placed), "the moves of a chain apply in turn");
            current += cost.change(placed.switches(start.width()));
            moves.push(placed);
            let changed = Extent::window(placed);
            known.retain(|_, (_, examined)| !examined.overlaps(changed));
            if current < best {
                (best, moves_to_best) = (current, moves.len());
            }
            if is_random || goal.reached(best).is_some() {
                break;
            }
        }
    };
    moves.truncate(moves_to_best);
    let moves: Vec<_> = moves.into_iter().map(Move::Variant).collect();
    let mut path = start.clone();
    for step in &moves {
        assert!(step.apply(&mut path), "what applies to the links applies to the path");
    }
    Outcome { path, initial, cost: best, proven_bound, stop, moves }
}

/// All variants that apply, row by row.
fn applicable(links: &Links) -> Vec<PlacedVariant> {
    let mut all = Vec::new();
    links.for_each_variant(|placed| all.push(placed));
    all
}
