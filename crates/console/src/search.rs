//! One search of one layer, and the row that tells of it.

use std::time::Instant;

use anyhow::bail;
use beadwork_grid::{Crossings, Path, Region, Start, Zones};
use beadwork_search::bound::{self, Bounds};
use beadwork_search::{Move, Preset, Settings, Stop, anneal, exact, genetic};
use serde::{Deserialize, Serialize};

use crate::cancel;
use crate::learned::{self, Fusion};

/// The methods of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MethodName {
    /// The start itself.
    Zigzag,
    /// Simulated annealing from the start.
    Anneal,
    /// The genetic algorithm, on the moves of many annealing runs.
    Genetic,
    /// The fewest pieces, then the fewest crossings, with a proof where one is found.
    Exact,
    /// Moves that a trained network proposes.
    Fusion,
}

impl MethodName {
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

/// What `--json` prints for one layer.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    pub layout: String,
    pub width: u32,
    pub height: u32,
    pub zones: u32,
    pub seed: u64,
    pub method: String,
    pub preset: Option<String>,
    pub start: String,
    pub initial: u32,
    pub crossings: u32,
    /// Of the crossings, or of what they cost if they don't all cost 1.
    pub bound: Option<u64>,
    pub pieces: u32,
    pub piece_bound: u32,
    pub moves: u64,
    pub seconds: f64,
    /// What only the exact search has.
    #[serde(flatten)]
    pub exact: Option<ExactRow>,
    /// What only the genetic algorithm has.
    #[serde(flatten)]
    pub genetic: Option<GeneticRow>,
    /// What only the network has.
    #[serde(flatten)]
    pub fusion: Option<FusionRow>,
}

impl Row {
    /// Whether nothing better in as many pieces exists.
    pub fn is_proven(&self) -> bool {
        match &self.exact {
            Some(exact) => exact.optimal,
            None => self.bound == Some(u64::from(self.crossings)),
        }
    }

    /// By how many per cent the crossings fell.
    pub fn reduction(&self) -> f64 {
        100.0 * (1.0 - f64::from(self.crossings) / f64::from(self.initial.max(1)))
    }
}

/// What the exact search tells beside the common row.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ExactRow {
    /// What the crossings cost: their number, unless costs were given.
    pub cost: u64,
    pub optimal: bool,
    pub attempts: u32,
    pub stop: String,
}

/// What the genetic algorithm tells beside the common row.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GeneticRow {
    /// Crossings of the best annealing run it began with.
    pub seeded: i64,
    /// Of `seconds`, those of the annealing runs.
    pub seeding_seconds: f64,
    /// Genes of an individual.
    pub length: usize,
    /// Genes tried in replays.
    pub replayed: u64,
    /// Genes that were known from parents.
    pub spared: u64,
    pub history: Vec<Generation>,
}

/// What a walk led by a network tells beside the common row, whose moves are those to the best path
/// alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FusionRow {
    /// Crossings that are enough.
    pub target: u32,
    /// Whether it got there, rather than to the end of its budget.
    pub reached: bool,
    /// All moves made, those that were given up included.
    pub made: u64,
    /// Those of them that were made at random.
    pub perturbed: u64,
}

/// What a population came to.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Generation {
    pub number: u32,
    pub best: i64,
    pub mean: f64,
    pub diversity: f64,
    pub stayed: u32,
}

impl From<&genetic::Generation> for Generation {
    fn from(of: &genetic::Generation) -> Self {
        let genetic::Generation { number, best, mean, diversity, stayed } = *of;
        Self { number, best, mean, diversity, stayed }
    }
}

/// How the path is chosen, with what the method needs to know.
#[derive(Clone, Copy)]
pub enum Choice<'a> {
    /// The start itself.
    Zigzag,
    Anneal(Preset),
    Genetic(Breeding<'a>),
    Exact(exact::Settings<'a>),
    Fusion(Fusion<'a>),
}

/// What the genetic algorithm needs to know.
#[derive(Clone, Copy)]
pub struct Breeding<'a> {
    pub preset: genetic::Preset,
    pub pool: Option<&'a rayon::ThreadPool>,
    pub observer: Option<&'a (dyn Fn(genetic::Progress) + Sync)>,
    /// A population annealed by the same preset's seeding and seed before, and the seconds that it
    /// took.
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

/// What a search is asked to do with a layer.
pub struct Search<'a> {
    pub region: &'a Region,
    pub zones: &'a Zones,
    pub choice: Choice<'a>,
    pub seed: u64,
    pub start: Start,
    /// Lower bounds; `None` where only the pieces and the number of zone components shall bound the
    /// crossings.
    pub bounds: Option<Bounds>,
}

impl Search<'_> {
    /// Runs it from the path of its start; gives the best path and the row that tells of it.
    ///
    /// The exact search needs no start: it is there to compare with.
    pub fn run(&self, layout: &str, start: &Path) -> anyhow::Result<(Path, Row)> {
        let &Self { region, zones, choice, seed, bounds, .. } = self;
        let cancel = cancel::token()?.as_flag();
        let crossings = Crossings::new(region, zones);
        let pieces = start.pieces();
        let lower = match bounds {
            Some(bounds) if bounds.pieces == pieces => bounds.crossings(),
            _ => bound::components(region, zones, pieces),
        };
        let (mut lower, mut piece_bound) =
            (u64::from(lower), bounds.map_or(1, |bounds| bounds.pieces));
        let (mut exact, mut genetic, mut fusion) = (None, None, None);
        let mut seconds_before = 0.0;
        let begin = Instant::now();
        let (best, moves) = match choice {
            Choice::Zigzag => (start.clone(), 0),
            Choice::Anneal(preset) => {
                let settings = Settings {
                    bound: Some(lower as i64),
                    cancel: Some(cancel),
                    ..Settings::preset(preset, seed)
                };
                let outcome = anneal(start.clone(), &crossings, &settings);
                if outcome.stop == Stop::Cancelled {
                    bail!("stopped");
                }
                (outcome.path, outcome.moves.len() as u64)
            }
            Choice::Genetic(breeding) => {
                let settings = genetic::Settings {
                    bound: Some(lower as i64),
                    cancel: Some(cancel),
                    observer: breeding.observer,
                    pool: breeding.pool,
                    ..genetic::Settings::preset(breeding.preset, seed)
                };
                let made;
                let (population, seeding_seconds) = if let Some(annealed) = breeding.population {
                    seconds_before = annealed.1;
                    annealed
                } else {
                    made = genetic::annealed(start, &crossings, &settings);
                    (&made[..], begin.elapsed().as_secs_f64())
                };
                let outcome = genetic::evolve(start, &crossings, population, &settings);
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
                let plan = exact::solve(
                    region,
                    zones,
                    &exact::Settings { seed, cancel: Some(cancel), ..settings },
                )?;
                (lower, piece_bound) = (plan.bound, plan.piece_bound);
                let optimal = plan.is_optimal();
                let (cost, attempts) = (plan.cost, plan.attempts);
                let stop = format!("{:?}", plan.stop).to_lowercase();
                exact = Some(ExactRow { cost, optimal, attempts, stop });
                (plan.path, 0)
            }
            Choice::Fusion(of) => {
                let target = of.target.max(lower as u32);
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
            bound: Some(lower),
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
