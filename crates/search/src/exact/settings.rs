//! Settings of the exact search, and callbacks that observe it.

use beadwork_grid::{Cell, Path};

use super::terminal::Terminal;
use crate::CostMatrix;

/// Settings of [`solve`](super::solve).
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// Seed of the random choices.
    pub seed: u64,
    /// Maximum number of attempts at each connected component of the region; 0 counts as 1.
    pub attempts: u32,
    /// Cost of a crossing for each ordered pair of zones; `None` for 1 each.
    pub costs: Option<&'a CostMatrix>,
    /// Where the first piece begins.
    pub start: Terminal,
    /// Where the last piece ends.
    pub end: Terminal,
    /// Whether the first attempt lays its ladders, and with them most long straight runs of the
    /// path, along the columns instead of the rows.
    /// Alternating it from layer to layer makes the paths of successive layers cross each other.
    pub columns_first: bool,
    /// Path of the layer below, on a grid of the same width and height.
    /// The first four attempts at each component start from its links inside the zones, where both
    /// layers have the cells, instead of ladders.
    pub below: Option<&'a Path>,
    /// Callbacks for diagnostics and pictures.
    pub observers: Observers<'a>,
}

impl Default for Settings<'_> {
    /// Seed 0, 50 attempts, crossings that cost 1 each, free ends, ladders along the rows, no layer
    /// below, no observers.
    fn default() -> Self {
        Self {
            seed: 0,
            attempts: 50,
            costs: None,
            start: Terminal::Any,
            end: Terminal::Any,
            columns_first: false,
            below: None,
            observers: Observers::default(),
        }
    }
}

/// Callbacks for diagnostics and pictures, none of which influences the result.
///
/// For a progress bar use [`Control::progress`](beadwork_base::Control::progress).
///
/// Construct it with `..Observers::default()`: fields may be added.
#[derive(Clone, Copy, Default)]
pub struct Observers<'a> {
    /// Called after each attempt.
    pub attempt: Option<&'a (dyn Fn(AttemptReport) + Sync)>,
    /// Called at each stage of the first attempt at each component.
    pub stage: Option<&'a StageObserver<'a>>,
}

/// Takes a stage, and the links at that stage as pairs of neighbouring cells.
pub type StageObserver<'a> = dyn Fn(Stage, &[[Cell; 2]]) + Sync + 'a;

/// The state of the search of one component after an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttemptReport {
    /// Number of cells of the component.
    pub cells: u32,
    /// Number of attempts made at the component so far.
    pub attempts: u32,
    /// Number of pieces of its best cover so far.
    pub pieces: u32,
    /// Cost of its best cover so far, in the unit of the costs.
    pub cost: f64,
}

/// A stage of an attempt, in the order in which attempts reach them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Ladders inside the zones, and links between the cells that the ladders leave over.
    Ladders,
    /// The cheapest 2-matching, whose cost is a lower bound.
    Cheapest,
    /// The 2-matching after links were added between groups of zones that it left unconnected.
    Linked,
    /// The 2-matching after switches joined most of its cycles.
    Merged,
    /// The cover: paths only, after the last cycles were joined.
    Settled,
}
