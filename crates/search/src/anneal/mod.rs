//! Simulated annealing of a path.

mod free;
mod pooled;
#[cfg(test)]
mod tests;

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::AtomicBool;

use beadwork_grid::Path;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use thiserror::Error;

pub use free::Free;
pub use pooled::Pooled;

use crate::stop::is_cancelled;
use crate::{Cost, Move, Stop};

/// How to anneal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// As Aali et al. do: variants drawn from a pool.
    Pooled(Pooled),
    /// Any two switches, drawn anew each time.
    Free(Free),
}

/// Named settings of the two methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// The paper's annealer: 5000 iterations from 80 to 0.5.
    Paper,
    /// 1000 iterations from 60 to 0.5.
    Short,
    /// 3000 iterations from 80 to 0.5.
    Medium,
    /// 8000 iterations from 100 to 0.3.
    Long,
    /// 15,000 iterations from 120 to 0.2.
    ExtraLong,
    /// [`Free`] with its defaults.
    Fast,
}

/// A name that is no [`Preset`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no annealing preset: choose paper, short, medium, long, extra_long or fast")]
pub struct UnknownPreset(pub String);

impl Preset {
    /// All of them, those of the paper first.
    pub const ALL: [Self; 6] =
        [Self::Paper, Self::Short, Self::Medium, Self::Long, Self::ExtraLong, Self::Fast];

    /// Its name in configurations and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Short => "short",
            Self::Medium => "medium",
            Self::Long => "long",
            Self::ExtraLong => "extra_long",
            Self::Fast => "fast",
        }
    }

    /// What it stands for.
    pub fn method(self) -> Method {
        let pooled = |iterations, hot, cold| {
            Method::Pooled(Pooled { iterations, hot, cold, ..Pooled::default() })
        };
        match self {
            Self::Paper => Method::Pooled(Pooled::default()),
            Self::Short => pooled(1000, 60.0, 0.5),
            Self::Medium => pooled(3000, 80.0, 0.5),
            Self::Long => pooled(8000, 100.0, 0.3),
            Self::ExtraLong => pooled(15_000, 120.0, 0.2),
            Self::Fast => Method::Free(Free::default()),
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(name: &str) -> Result<Self, UnknownPreset> {
        Self::ALL
            .into_iter()
            .find(|preset| preset.name() == name)
            .ok_or_else(|| UnknownPreset(name.to_owned()))
    }
}

/// What an annealing run needs beside its path and cost.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// The method and its parameters.
    pub method: Method,
    /// Seed of its random choices.
    pub seed: u64,
    /// A proven lower bound of the cost, at which it stops: it can't be beaten.
    pub bound: Option<i64>,
    /// Stops the run soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Told now and then how far the run has come.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl Settings<'_> {
    /// The settings of a preset, without bound, cancel token and observer.
    pub fn preset(preset: Preset, seed: u64) -> Self {
        Self { method: preset.method(), seed, bound: None, cancel: None, observer: None }
    }
}

/// How far an annealing run has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Moves proposed so far.
    pub proposals: u64,
    /// Moves it will propose if nothing stops it.
    pub planned: u64,
    /// The temperature, in units of the cost.
    pub temperature: f64,
    /// Cost of the present path.
    pub cost: i64,
    /// Lowest cost so far.
    pub best: i64,
}

/// What an annealing run found.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best path; the first of equally good ones.
    pub path: Path,
    /// Cost of the start.
    pub initial: i64,
    /// Cost of the best path, at most `initial`.
    pub cost: i64,
    /// The lower bound it was given.
    pub bound: Option<i64>,
    /// Why it stopped.
    pub stop: Stop,
    /// The accepted moves from the start to the best path: replayed in order, they give it.
    pub moves: Vec<Move>,
    /// Moves proposed, applicable or not.
    pub proposals: u64,
    /// Moves accepted, including those after the best path.
    pub accepted: u64,
}

/// Anneals a path: proposes moves, takes those that lower the cost, and others with a probability
/// that falls with the temperature (Metropolis et al. 1953).
///
/// Costs O(1) a proposal, a pass over the cells for each new best and, in [`Pooled`], for each
/// pool, and the cells between the first and the last cut for each accepted move.
pub fn anneal<C: Cost>(start: Path, cost: &C, settings: &Settings<'_>) -> Outcome {
    match settings.method {
        Method::Pooled(pooled) => pooled::run(&pooled, start, cost, settings),
        Method::Free(free) => free::run(&free, start, cost, settings),
    }
}

/// The state of a run that both methods share.
struct Run<'a> {
    settings: &'a Settings<'a>,
    rng: Xoshiro256PlusPlus,
    path: Path,
    initial: i64,
    present: i64,
    best: i64,
    best_path: Path,
    /// Accepted moves, of which the first `moves_to_best` lead to the best path.
    moves: Vec<Move>,
    moves_to_best: usize,
}

impl<'a> Run<'a> {
    fn new<C: Cost>(path: Path, cost: &C, settings: &'a Settings<'a>) -> Self {
        let initial = cost.total(&path);
        Self {
            settings,
            rng: Xoshiro256PlusPlus::seed_from_u64(settings.seed),
            initial,
            present: initial,
            best: initial,
            best_path: path.clone(),
            path,
            moves: Vec::new(),
            moves_to_best: 0,
        }
    }

    /// Notes a move that was just applied; true if it led to a new best.
    #[inline]
    fn accept(&mut self, step: Move, change: i64) -> bool {
        self.present += change;
        self.moves.push(step);
        let better = self.present < self.best;
        if better {
            self.best = self.present;
            self.best_path.copy_from(&self.path);
            self.moves_to_best = self.moves.len();
        }
        better
    }

    /// Whether to stop before the planned end, and why.
    fn stop(&self) -> Option<Stop> {
        if self.settings.bound.is_some_and(|bound| self.best <= bound) {
            return Some(Stop::Optimal);
        }
        is_cancelled(self.settings.cancel).then_some(Stop::Cancelled)
    }

    fn observe(&self, proposals: u64, planned: u64, temperature: f64) {
        if let Some(observer) = self.settings.observer {
            observer(Progress {
                proposals,
                planned,
                temperature,
                cost: self.present,
                best: self.best,
            });
        }
    }

    /// Ends a run that made all of its proposals.
    fn complete(self, proposals: u64) -> Outcome {
        let stop = self.stop().filter(|&stop| stop == Stop::Optimal).unwrap_or(Stop::Done);
        self.finish(stop, proposals)
    }

    fn finish(mut self, stop: Stop, proposals: u64) -> Outcome {
        let accepted = self.moves.len() as u64;
        self.moves.truncate(self.moves_to_best);
        Outcome {
            path: self.best_path,
            initial: self.initial,
            cost: self.best,
            bound: self.settings.bound,
            stop,
            moves: self.moves,
            proposals,
            accepted,
        }
    }
}
