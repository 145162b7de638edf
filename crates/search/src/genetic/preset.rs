//! Named settings of the genetic algorithm.

use super::crossover::Crossover;
use super::parameters::{Evolution, Seeding};
use crate::anneal;

/// Named settings of the genetic algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// The paper's: the best 200 of 920 annealing runs, 500 generations, one-point crossover.
    Paper,
    /// `Paper` with two-point crossover, which the paper leaves to future work.
    TwoPoint,
    /// `Paper` with window crossover and one mutation for each child: the best preset for the
    /// paper's moves.
    Window,
    /// `Window` in a tenth of the time: the best 40 of 100 annealing runs, 60 generations.
    Short,
    /// Eight runs of the annealer `fast`, 50 generations.
    /// Crossover hardly ever improves on these runs.
    Fast,
}

beadwork_base::named_enum! {
    Preset, "genetic preset":
    Paper = "paper",
    TwoPoint = "two_point",
    Window = "window",
    Short = "short",
    Fast = "fast",
}

impl Preset {
    /// The parameters that the name stands for.
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
