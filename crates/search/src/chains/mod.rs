//! The fewest moves to a lower cost: chains of variants, each overlapping the one before.
//!
//! From a zigzag hardly any variant lowers the cost by itself: they apply where the path turns, at
//! the layer's sides, and have to be carried to where zones meet, window by window.
//! An annealer finds such chains by chance, in many hundred moves.
//! Here every variant that applies is followed up by a beam search (`grow.rs`), and the chain that
//! gains most for each of its moves is made; then again, until none gains.
//! What a chain's search looked at is noted, and the search is only repeated where a move changed
//! that.
//!
//! The moves are few and each has a purpose, which makes their records good examples to learn from.
//! With [`noise`](Settings::noise) some moves are made at random, and the chains after them show
//! how to go on from there.
//! For the lowest cost whatever the moves, see [`exact`](crate::exact).
//!
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::chains::{self, Settings};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Islands).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let outcome = chains::solve(&start, &Crossings::new(&region, &zones), &Settings { bound: Some(28), ..Settings::default() });
//! assert!(outcome.cost <= 28 && outcome.moves.len() < 60);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod grow;
mod preset;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::atomic::AtomicBool;

use beadwork_grid::{Links, Path, PlacedVariant};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

pub use preset::{Preset, UnknownPreset};

use self::grow::{Found, Grower, Reach};
use crate::random::{below, unit};
use crate::stop::is_cancelled;
use crate::{Cost, Move, Stop};

/// How to search for chains.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// Chains from one start that are pursued at a time, at least 1.
    pub beam: usize,
    /// Longest chain, in moves.
    pub depth: usize,
    /// Moves by which a chain that gains is lengthened in search of a better one.
    pub patience: usize,
    /// Probability, 0..=1, with which a random move is made in place of a chain's next one, and the
    /// rest of the chain given up.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// A cost at which it stops: a proven bound, or a target that is enough.
    pub bound: Option<i64>,
    /// Stops the search soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self { beam: 4, depth: 60, patience: 4, noise: 0.0, seed: 0, bound: None, cancel: None }
    }
}

impl Settings<'_> {
    /// The settings of a preset, without bound and cancel token.
    pub fn preset(preset: Preset, seed: u64) -> Self {
        Self { noise: preset.noise(), seed, ..Self::default() }
    }
}

/// What a search for chains found.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best path.
    pub path: Path,
    /// Cost of the start.
    pub initial: i64,
    /// Cost of the best path, at most `initial`.
    pub cost: i64,
    /// The bound it was given.
    pub bound: Option<i64>,
    /// Why it stopped.
    pub stop: Stop,
    /// The moves from the start to the best path: replayed in order, they give it.
    pub moves: Vec<Move>,
}

/// Lowers the cost of a path by chains of variants.
///
/// A chain costs its cells within reach, some 100 us on a zigzag of 30 x 30 cells and milliseconds
/// where few chains are short; the first one as much for each place where a variant applies.
pub fn solve<C: Cost>(start: &Path, cost: &C, settings: &Settings<'_>) -> Outcome {
    let grower = Grower::new(start, cost, settings);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let mut links = Links::new(start);
    let initial = cost.total(start);
    let (mut present, mut best) = (initial, initial);
    let (mut moves, mut moves_to_best) = (Vec::new(), 0);
    let mut known: HashMap<PlacedVariant, (Option<Found>, Reach)> = HashMap::new();
    let stop = 'search: loop {
        if settings.bound.is_some_and(|bound| best <= bound) {
            break Stop::Optimal;
        }
        let starts = applicable(&links);
        let mut chosen: Option<&Found> = None;
        for &first in &starts {
            if is_cancelled(settings.cancel) {
                break 'search Stop::Cancelled;
            }
            known.entry(first).or_insert_with(|| grower.grow(&mut links, first));
        }
        let last = moves.last().copied();
        for found in starts.iter().filter_map(|first| known[first].0.as_ref()) {
            if chosen.is_none_or(|chosen| found.is_better_than(chosen, last)) {
                chosen = Some(found);
            }
        }
        let Some(chain) = chosen.map(|found| found.moves.clone()) else { break Stop::Done };
        for planned in chain {
            let derailed = settings.noise > 0.0 && unit(&mut rng) < settings.noise;
            let placed = if derailed {
                let all = applicable(&links);
                all[below(&mut rng, all.len())]
            } else {
                planned
            };
            assert!(links.apply_variant(placed), "what was found applicable is");
            present += cost.change(placed.switches(start.width()));
            moves.push(placed);
            let changed = Reach::window(placed);
            known.retain(|_, (_, reach)| !reach.meets(changed));
            if present < best {
                (best, moves_to_best) = (present, moves.len());
            }
            if derailed || settings.bound.is_some_and(|bound| best <= bound) {
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
    Outcome { path, initial, cost: best, bound: settings.bound, stop, moves }
}

/// All variants that apply, row by row.
fn applicable(links: &Links) -> Vec<PlacedVariant> {
    let mut all = Vec::new();
    links.for_each_variant(|placed| all.push(placed));
    all
}
