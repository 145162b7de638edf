//! The genetic algorithm of Aali et al., section "Genetic algorithm".
//!
//! An **individual** is a list of moves, its **genes**, of a fixed length; shorter lists are padded
//! with blanks.
//! To evaluate it, its genes are replayed one after the other from the start path, skipping those
//! that do not apply; its cost is the lowest one on the way.
//!
//! The first population consists of the moves of the best of many annealing runs ([`annealed`]).
//! In each generation ([`evolve`]), the best individuals and some others, drawn at random without
//! replacement, are carried over, and children of tournament winners fill the rest.
//! A child that costs much more than its better parent is replaced by a copy of that parent.
//!
//! Two things make it fast:
//! - The paper's variants depend on links only, so they are replayed on [`Links`] instead of a
//!   [`Path`], at a few nanoseconds a gene.
//! - A child begins with the same genes as one of its parents.
//!   Parents keep snapshots of their replay, and the child is replayed from the last snapshot
//!   before its first different gene.
//!
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::genetic::{self, Preset, Settings};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Islands).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let cost = Crossings::new(&region, &zones);
//! let settings = Settings::preset(Preset::Short, 7);
//! let outcome = genetic::solve(&start, &cost, &settings, &Control::default());
//! let annealed = outcome.generations[0].best;
//! assert!(outcome.cost <= annealed && annealed < outcome.initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Crossover can only combine the annealers' moves.
//! See docs/results/zones.md for how much it improves on the best annealing run.

mod crossover;
mod gene;
mod individual;
mod parameters;
mod preset;
mod replay;
mod run;
mod seeding;
mod settings;
#[cfg(test)]
mod tests;

use beadwork_base::Control;
use beadwork_grid::{Links, Path};

pub use crossover::Crossover;
pub use parameters::{Evolution, Seeding};
pub use preset::Preset;
pub use seeding::annealed;
pub use settings::{Generation, Outcome, Settings};

use self::run::run;
use crate::{Cost, Move};

/// Anneals a first population and evolves it.
///
/// Progress counts annealing runs and generations.
/// Works on `control.threads`; the result does not depend on them.
///
/// Takes the time of the annealing runs, and O(1) for each gene that is replayed: at most children
/// times length in each generation, and usually far fewer.
///
/// # Panics
/// If the population or the tournament is empty.
pub fn solve<C: Cost + Sync>(
    start: &Path,
    cost: &C,
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Outcome {
    let runs = settings.seeding.runs as usize;
    let total = runs + settings.evolution.generations as usize;
    let seeded = |progress: beadwork_base::Progress| control.report(progress.done, total);
    let bred = |progress: beadwork_base::Progress| control.report(runs + progress.done, total);
    let population =
        annealed(start, cost, settings, &Control { progress: Some(&seeded), ..*control });
    evolve(start, cost, &population, settings, &Control { progress: Some(&bred), ..*control })
}

/// Evolves a population of lists of moves, each of which is replayed from `start`.
///
/// If there are more lists than individuals, the first ones are taken; if there are fewer, they are
/// repeated; without any, the population consists of the start path alone.
///
/// Progress counts generations.
/// Works on `control.threads`; the result does not depend on them.
///
/// See [`solve`] for the time.
/// Memory: 12 bytes for each gene, and up to 256 MB of snapshots.
/// With the paper's parameters, breeding a generation temporarily adds half as much, since the
/// parents stay until all children are complete.
///
/// # Panics
/// If the population or the tournament is empty.
pub fn evolve<C: Cost + Sync>(
    start: &Path,
    cost: &C,
    population: &[Vec<Move>],
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Outcome {
    let only_variants = population.iter().flatten().all(|gene| matches!(gene, Move::Variant(_)));
    if only_variants {
        run(&Links::new(start), start, cost, population, settings, control)
    } else {
        run(start, start, cost, population, settings, control)
    }
}
