//! Settings and results of annealing runs.

use beadwork_grid::Path;

use super::method::Method;
use super::preset::Preset;
use crate::{Move, Stop};

/// Settings of an annealing run.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// The method and its parameters.
    pub method: Method,
    /// Seed of all random choices.
    pub seed: u64,
    /// A lower bound of the cost of all paths, which **the caller has proven**.
    /// A run that reaches it stops with [`Stop::Optimal`].
    pub proven_bound: Option<i64>,
    /// A cost that is good enough: a run that reaches it stops with [`Stop::TargetReached`].
    pub target: Option<i64>,
    /// Called periodically with the state of the run.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl Default for Settings<'_> {
    /// The preset `paper` with seed 0, without bound, target and observer.
    fn default() -> Self {
        Self {
            method: Preset::Paper.method(),
            seed: 0,
            proven_bound: None,
            target: None,
            observer: None,
        }
    }
}

impl Settings<'_> {
    /// The method of a preset with a seed, and otherwise the default settings.
    pub fn preset(preset: Preset, seed: u64) -> Self {
        Self { method: preset.method(), seed, ..Self::default() }
    }
}

/// State of an annealing run, for its observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Moves proposed so far.
    pub proposals: u64,
    /// Moves that the run will propose unless it stops early.
    pub planned: u64,
    /// Temperature, in units of the cost.
    pub temperature: f64,
    /// Cost of the current path.
    pub cost: i64,
    /// Lowest cost so far.
    pub best: i64,
}

/// Result of an annealing run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The path of the lowest cost; the first such path that the run visited.
    pub path: Path,
    /// Cost of the start path.
    pub initial: i64,
    /// Cost of the best path, at most `initial`.
    pub cost: i64,
    /// The lower bound of [`Settings::proven_bound`].
    pub proven_bound: Option<i64>,
    /// Why the run stopped.
    pub stop: Stop,
    /// The accepted moves from the start path to the best one: replayed in order, all of them apply
    /// and lead to it.
    pub moves: Vec<Move>,
    /// Number of proposed moves, applicable or not.
    pub proposals: u64,
    /// Number of accepted moves, including those after the best path.
    pub accepted: u64,
}
