//! Named settings of the genetic algorithm.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::{Crossover, Evolution, Seeding};
use crate::anneal;

/// Named settings of the genetic algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// The paper's: the best 200 of 920 annealing runs, 500 generations, one-point crossover.
    Paper,
    /// The same with two-point crossover, which the paper leaves to future work.
    TwoPoint,
    /// The same with window crossover and a mutation for each child: our best with the paper's
    /// moves.
    Window,
    /// The best 40 of 100 annealing runs, 60 generations: as `Window` in a tenth of the time.
    Short,
    /// Eight runs of the annealer `fast`, 50 generations.
    /// Crossover hardly ever adds to those.
    Fast,
}

/// A name that is no [`Preset`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "'{0}' is no preset of the genetic algorithm: choose paper, two_point, window, short or fast"
)]
pub struct UnknownPreset(pub String);

impl Preset {
    /// All of them, the paper's first.
    pub const ALL: [Self; 5] = [Self::Paper, Self::TwoPoint, Self::Window, Self::Short, Self::Fast];

    /// Its name in configurations and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::TwoPoint => "two_point",
            Self::Window => "window",
            Self::Short => "short",
            Self::Fast => "fast",
        }
    }

    /// What it stands for.
    pub fn parameters(self) -> (Seeding, Evolution) {
        let paper = Evolution::default();
        let window = Evolution { crossover: Crossover::Window, mutations: 1, ..paper };
        match self {
            Self::Paper => (Seeding::default(), paper),
            Self::TwoPoint => {
                (Seeding::default(), Evolution { crossover: Crossover::TwoPoint, ..paper })
            }
            Self::Window => (Seeding::default(), window),
            Self::Short => {
                let seeding = Seeding { runs: 100, ..Seeding::default() };
                (seeding, Evolution { population: 40, generations: 60, elites: 2, ..window })
            }
            Self::Fast => {
                let seeding = Seeding { methods: vec![anneal::Preset::Fast.method()], runs: 8 };
                (seeding, Evolution { population: 8, generations: 50, elites: 2, ..paper })
            }
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
