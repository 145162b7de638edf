//! Parameters of the first population and of its evolution.

use super::crossover::Crossover;
use crate::anneal::{self, Method};

/// The annealing runs that the first population is made from.
///
/// The default follows the paper's data: 22,111 runs of five presets over 24 combinations of layout
/// and size, about 920 for each combination.
#[derive(Clone, Debug, PartialEq)]
pub struct Seeding {
    /// The annealers, which take turns.
    /// All should be [`Method::Pooled`], or all [`Method::Free`], if the moves are to be recorded.
    pub methods: Vec<Method>,
    /// Number of runs in all; the best of them make up the population.
    pub runs: u32,
}

impl Default for Seeding {
    fn default() -> Self {
        let presets = anneal::Preset::ALL.map(anneal::Preset::method);
        let pooled = presets.into_iter().filter(|method| matches!(method, Method::Pooled(_)));
        Self { methods: pooled.collect(), runs: 920 }
    }
}

/// Parameters of the evolution; the default is the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evolution {
    /// Number of individuals, at least 1.
    pub population: usize,
    /// Number of generations after the first population.
    pub generations: u32,
    /// Number of individuals, at least 1, that are drawn for each parent; the best of them becomes
    /// the parent.
    pub tournament: u32,
    /// How two parents make a child.
    pub crossover: Crossover,
    /// Share of the children, 0..=1, that have two parents; the others start as copies of one.
    pub crossover_rate: f64,
    /// Share of the population, 0..=1, that is carried over to the next generation.
    pub carry_over: f64,
    /// Number of the best individuals that are always carried over.
    pub elites: usize,
    /// Maximum amount by which a child may cost more than its better parent.
    pub tolerance: i64,
    /// Number of genes of each child that are replaced by random variants anywhere in the grid; 0
    /// in the paper.
    pub mutations: u32,
}

impl Default for Evolution {
    fn default() -> Self {
        Self {
            population: 200,
            generations: 500,
            tournament: 3,
            crossover: Crossover::OnePoint { first: 0.6 },
            crossover_rate: 0.9,
            carry_over: 0.6,
            elites: 6,
            tolerance: 2,
            mutations: 0,
        }
    }
}
