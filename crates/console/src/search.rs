//! Any search method on one layer, reported as one row of a table.

use std::time::Instant;

use anyhow::bail;
use beadwork_base::{Control, Progress};
use beadwork_grid::{Crossings, Path, Region, Start, Zones};
use beadwork_search::bound::{self, Bounds};
use beadwork_search::{Move, Stop, anneal, exact, genetic};
use serde::{Deserialize, Serialize};

use crate::learned::{self, Fusion};
use crate::{cancel, output};

/// A search method, as named on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MethodName {
    /// The start path itself, unchanged.
    Zigzag,
    /// Simulated annealing from the start path.
    Anneal,
    /// The genetic algorithm, seeded with the moves of many annealing runs.
    Genetic,
    /// The fewest pieces, then the fewest crossings, with a proven bound.
    Exact,
    /// A walk along moves that a trained network proposes.
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
    /// Facts of an exact search.
    #[serde(flatten)]
    pub exact: Option<ExactRow>,
    /// Facts of the genetic algorithm.
    #[serde(flatten)]
    pub genetic: Option<GeneticRow>,
    /// Facts of a walk by a network.
    #[serde(flatten)]
    pub fusion: Option<FusionRow>,
}

impl Row {
    /// Whether it is proven that no path with as many pieces is better.
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

/// Facts of an exact search, in addition to the common row.
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

/// Facts of the genetic algorithm, in addition to the common row.
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
    /// Genes that did not have to be replayed, since a parent's state was reused.
    pub spared: u64,
    /// Statistics of each generation, the first population included.
    pub history: Vec<Generation>,
}

/// Facts of a walk by a network, in addition to the common row, whose `moves` are those to the best
/// path.
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
    /// Proven lower bounds; `None` bounds the crossings by the number of zone components only.
    pub bounds: Option<Bounds>,
}

impl Search<'_> {
    /// Runs the search from a start path; returns the best path and its row.
    ///
    /// The exact search ignores the start path, except to compare with it in the row.
    /// Ctrl-C cancels all methods; those of the networks do not use the rest of the control yet.
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
