//! The result of a search on one layer, as a row of a table.

use beadwork_search::genetic;
use serde::{Deserialize, Serialize};

use crate::output;

/// The result of one search on one layer, as `--json` prints it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Name of the layout, or of the picture.
    pub layout: String,
    /// Width of the grid in cells.
    pub width: u32,
    /// Height of the grid in cells.
    pub height: u32,
    /// Number of zones.
    pub zones: u32,
    /// Seed of the layout and the search.
    pub seed: u64,
    /// Name of the method.
    pub method: String,
    /// Name of the method's preset, if it has presets.
    pub preset: Option<String>,
    /// Name of the start path.
    pub start: String,
    /// Crossings of the start path.
    pub initial: u32,
    /// Crossings of the best path.
    pub crossings: u32,
    /// Proven lower bound on the crossings, or on their cost if a cost matrix was given.
    #[serde(serialize_with = "output::serialize_optional_number")]
    pub bound: Option<f64>,
    /// Pieces of the best path.
    pub pieces: u32,
    /// Proven lower bound on the pieces.
    pub piece_bound: u32,
    /// Moves from the start to the best path; 0 where the method makes none.
    pub moves: u64,
    /// Wall-clock time of the search.
    pub seconds: f64,
    /// Figures of an exact search.
    #[serde(flatten)]
    pub exact: Option<ExactRow>,
    /// Figures of the genetic algorithm.
    #[serde(flatten)]
    pub genetic: Option<GeneticRow>,
    /// Figures of a walk by a network.
    #[serde(flatten)]
    pub fusion: Option<FusionRow>,
}

impl Row {
    /// Whether the path is proven optimal among all paths with as many pieces.
    pub fn is_proven(&self) -> bool {
        match &self.exact {
            Some(exact) => exact.optimal,
            None => self.bound.is_some_and(|bound| bound >= f64::from(self.crossings)),
        }
    }

    /// Reduction of the crossings from the start path, in per cent.
    pub fn reduction(&self) -> f64 {
        100.0 * (1.0 - f64::from(self.crossings) / f64::from(self.initial.max(1)))
    }
}

/// Figures of an exact search, in addition to the common row.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ExactRow {
    /// Cost of the crossings: their number, unless a cost matrix was given.
    #[serde(serialize_with = "output::serialize_number")]
    pub cost: f64,
    /// Whether the path is proven optimal.
    pub optimal: bool,
    /// Attempts made.
    pub attempts: u32,
    /// Why the search stopped.
    pub stop: String,
}

/// Figures of the genetic algorithm, in addition to the common row.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GeneticRow {
    /// Crossings of the best annealing run of the first population.
    pub seeded: i64,
    /// Wall-clock time of the annealing runs, which `seconds` includes.
    pub seeding_seconds: f64,
    /// Genes per individual.
    pub length: usize,
    /// Genes applied in replays.
    pub replayed: u64,
    /// Genes that were not replayed, because the child started from a saved state of a parent.
    pub spared: u64,
    /// Statistics of each generation, the first population included.
    pub history: Vec<Generation>,
}

/// Figures of a walk by a network, in addition to the common row.
///
/// The `moves` of the row are those from the start to the best path.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FusionRow {
    /// Number of crossings at which the walk stops.
    pub target: u32,
    /// Whether the walk reached the target within its budget.
    pub reached: bool,
    /// All moves made, including those the walk later took back.
    pub made: u64,
    /// Random moves among them.
    pub perturbed: u64,
}

/// Statistics of one population.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Generation {
    /// Number of the generation; 0 for the first population.
    pub number: u32,
    /// Lowest cost.
    pub best: i64,
    /// Mean cost.
    pub mean: f64,
    /// Mean share of genes that differ from the best individual's, 0 to 1.
    pub diversity: f64,
    /// Children that entered the population.
    pub stayed: u32,
}

impl From<&genetic::Generation> for Generation {
    fn from(of: &genetic::Generation) -> Self {
        let genetic::Generation { number, best, mean, diversity, stayed } = *of;
        Self { number, best, mean, diversity, stayed }
    }
}
