//! Settings and results of the genetic algorithm.

use beadwork_grid::Path;

use super::parameters::{Evolution, Seeding};
use super::preset::Preset;
use crate::{Move, Stop};

/// Settings of the genetic algorithm.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone)]
pub struct Settings<'a> {
    /// How the first population is made.
    pub seeding: Seeding,
    /// How the population evolves.
    pub evolution: Evolution,
    /// Seed of all random choices.
    pub seed: u64,
    /// A lower bound of the cost of all paths, which **the caller has proven**.
    /// A run that reaches it stops with [`Stop::Optimal`].
    pub proven_bound: Option<i64>,
    /// A cost that is good enough: a run that reaches it stops with [`Stop::TargetReached`].
    pub target: Option<i64>,
    /// Called with each generation, the first population included.
    pub observer: Option<&'a (dyn Fn(Generation) + Sync)>,
}

impl Default for Settings<'_> {
    /// The preset `paper` with seed 0, without bound, target and observer.
    fn default() -> Self {
        let (seeding, evolution) = Preset::Paper.parameters();
        Self { seeding, evolution, seed: 0, proven_bound: None, target: None, observer: None }
    }
}

impl Settings<'_> {
    /// The parameters of a preset with a seed, and otherwise the default settings.
    pub fn preset(preset: Preset, seed: u64) -> Self {
        let (seeding, evolution) = preset.parameters();
        Self { seeding, evolution, seed, ..Self::default() }
    }
}

/// Result of a run of the genetic algorithm.
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
    /// Why the run stopped.
    pub stop: Stop,
    /// The moves from the start path to the best one: replayed in order, all of them apply and lead
    /// to it.
    pub moves: Vec<Move>,
    /// Statistics of each population, the first one included.
    pub generations: Vec<Generation>,
    /// Number of genes of each individual.
    pub length: usize,
    /// Number of genes that were replayed, without blanks.
    pub replayed: u64,
    /// Number of genes of children, blanks included, that snapshots saved from being replayed.
    pub spared: u64,
}

/// Statistics of a population.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generation {
    /// Number of the generation; 0 for the first population.
    pub number: u32,
    /// Lowest cost.
    pub best: i64,
    /// Mean cost.
    pub mean: f64,
    /// Share of the genes, 0..=1, in which an individual differs from the best one, on average.
    /// Of long lists 256 genes at equal distances are compared.
    pub diversity: f64,
    /// Number of children that were kept: neither too expensive nor equal to a parent.
    pub stayed: u32,
}
