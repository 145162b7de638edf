//! Any search method on one layer, reported as one row of a table.

use std::time::Instant;

use anyhow::bail;
use beadwork_base::{Control, Progress};
use beadwork_grid::{Crossings, Path, Region, Start, Zones};
use beadwork_search::bound::{self, Bounds};
use beadwork_search::{Move, Stop, anneal, exact, genetic};

pub use crate::row::{ExactRow, FusionRow, Generation, GeneticRow, Row};

use crate::cancel;
use crate::learned::{self, Fusion};

/// A search method, as named on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MethodName {
    /// The start path itself, unchanged.
    Zigzag,
    /// Simulated annealing from the start path.
    Anneal,
    /// The genetic algorithm, seeded with the moves of many annealing runs.
    Genetic,
    /// Exact search: the fewest pieces, then the fewest crossings, with a proven bound.
    Exact,
    /// Moves that a trained network (FusionNet) proposes, applied one after another.
    Fusion,
}

impl MethodName {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Zigzag => "zigzag",
            Self::Anneal => "anneal",
            Self::Genetic => "genetic",
            Self::Exact => "exact",
            Self::Fusion => "fusion",
        }
    }
}

/// The method of a search with its settings.
#[derive(Clone, Copy)]
pub enum Choice<'a> {
    /// The start path itself, unchanged.
    Zigzag,
    /// Simulated annealing.
    Anneal(anneal::Preset),
    /// The genetic algorithm.
    Genetic(Breeding<'a>),
    /// The exact search.
    Exact(exact::Settings<'a>),
    /// A walk by a trained network.
    Fusion(Fusion<'a>),
}

/// Settings of the genetic algorithm.
#[derive(Clone, Copy)]
pub struct Breeding<'a> {
    /// Named settings.
    pub preset: genetic::Preset,
    /// A first population annealed earlier with the same preset and seed, and the seconds it took.
    pub population: Option<(&'a [Vec<Move>], f64)>,
}

impl Choice<'_> {
    fn method(&self) -> MethodName {
        match self {
            Self::Zigzag => MethodName::Zigzag,
            Self::Anneal(_) => MethodName::Anneal,
            Self::Genetic(_) => MethodName::Genetic,
            Self::Exact(_) => MethodName::Exact,
            Self::Fusion(_) => MethodName::Fusion,
        }
    }

    fn preset(&self) -> Option<String> {
        match self {
            Self::Anneal(preset) => Some(preset.name().to_owned()),
            Self::Genetic(breeding) => Some(breeding.preset.name().to_owned()),
            Self::Zigzag | Self::Exact(_) | Self::Fusion(_) => None,
        }
    }
}

/// A search on one layer.
pub struct Search<'a> {
    /// The cells of the layer.
    pub region: &'a Region,
    /// The zone of each cell.
    pub zones: &'a Zones,
    /// Method and settings.
    pub choice: Choice<'a>,
    /// Seed of the search.
    pub seed: u64,
    /// Kind of the start path, for the row.
    pub start: Start,
    /// Proven lower bounds; if `None`, the number of zone components alone bounds the crossings.
    pub bounds: Option<Bounds>,
}

impl Search<'_> {
    /// Runs the search from a start path; returns the best path and its row.
    ///
    /// The exact search uses the start path only as the reference in the row.
    /// Ctrl-C cancels every method; a walk by a network ignores the rest of `control`.
    pub fn run(
        &self,
        layout: &str,
        start: &Path,
        control: &Control<'_>,
    ) -> anyhow::Result<(Path, Row)> {
        let &Self { region, zones, choice, seed, bounds, .. } = self;
        let control = &Control { cancel: Some(cancel::token()?), ..*control };
        let crossings = Crossings::new(region, zones);
        let pieces = start.pieces();
        let lower = match bounds {
            Some(bounds) if bounds.pieces == pieces => bounds.crossings(),
            _ => bound::components(region, zones, pieces),
        };
        let proven_bound = Some(i64::from(lower));
        let (mut bound, mut piece_bound) =
            (f64::from(lower), bounds.map_or(1, |bounds| bounds.pieces));
        let (mut exact, mut genetic, mut fusion) = (None, None, None);
        let mut seconds_before = 0.0;
        let begin = Instant::now();
        let (best, moves) = match choice {
            Choice::Zigzag => (start.clone(), 0),
            Choice::Anneal(preset) => {
                let settings =
                    anneal::Settings { proven_bound, ..anneal::Settings::preset(preset, seed) };
                let outcome = anneal::solve(start, &crossings, &settings, control);
                if outcome.stop == Stop::Cancelled {
                    bail!("stopped");
                }
                (outcome.path, outcome.moves.len() as u64)
            }
            Choice::Genetic(breeding) => {
                let settings = genetic::Settings {
                    proven_bound,
                    ..genetic::Settings::preset(breeding.preset, seed)
                };
                let runs = settings.seeding.runs as usize;
                let total = runs + settings.evolution.generations as usize;
                let seeded = |progress: Progress| control.report(progress.done, total);
                let bred = |progress: Progress| control.report(runs + progress.done, total);
                let made;
                let (population, seeding_seconds) = if let Some(annealed) = breeding.population {
                    seconds_before = annealed.1;
                    annealed
                } else {
                    let control = Control { progress: Some(&seeded), ..*control };
                    made = genetic::annealed(start, &crossings, &settings, &control);
                    (&made[..], begin.elapsed().as_secs_f64())
                };
                let control = Control { progress: Some(&bred), ..*control };
                let outcome = genetic::evolve(start, &crossings, population, &settings, &control);
                if outcome.stop == Stop::Cancelled {
                    bail!("stopped");
                }
                let genetic::Outcome { generations, length, replayed, spared, .. } = &outcome;
                genetic = Some(GeneticRow {
                    seeded: generations[0].best,
                    seeding_seconds,
                    length: *length,
                    replayed: *replayed,
                    spared: *spared,
                    history: generations.iter().map(Generation::from).collect(),
                });
                (outcome.path, outcome.moves.len() as u64)
            }
            Choice::Exact(settings) => {
                let settings = exact::Settings { seed, ..settings };
                let outcome = exact::solve(region, zones, &settings, control)?;
                (bound, piece_bound) = (outcome.bound, outcome.piece_bound);
                let optimal = outcome.is_optimal();
                let (cost, attempts) = (outcome.cost, outcome.attempts);
                let stop = format!("{:?}", outcome.stop).to_lowercase();
                exact = Some(ExactRow { cost, optimal, attempts, stop });
                (outcome.path, 0)
            }
            Choice::Fusion(of) => {
                let target = of.target.max(lower);
                let (path, moves, row) =
                    learned::fusion(&Fusion { target, ..of }, region, zones, start, seed)?;
                fusion = Some(row);
                (path, moves)
            }
        };
        let seconds = seconds_before + begin.elapsed().as_secs_f64();
        let row = Row {
            layout: layout.to_owned(),
            width: region.width(),
            height: region.height(),
            zones: zones.count(),
            seed,
            method: choice.method().name().to_owned(),
            preset: choice.preset(),
            start: self.start.name().to_owned(),
            initial: crossings.count(start),
            crossings: crossings.count(&best),
            bound: Some(bound),
            pieces: best.pieces(),
            piece_bound,
            moves,
            seconds,
            exact,
            genetic,
            fusion,
        };
        Ok((best, row))
    }
}
