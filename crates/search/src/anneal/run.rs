//! State of an annealing run that both methods share.

use beadwork_base::Control;
use beadwork_grid::Path;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::settings::{Outcome, Progress, Settings};
use crate::stop::Goal;
use crate::{Cost, Move, Stop};

/// State of an annealing run.
pub(super) struct Run<'a> {
    settings: &'a Settings<'a>,
    control: &'a Control<'a>,
    pub(super) rng: Xoshiro256PlusPlus,
    pub(super) path: Path,
    initial: i64,
    current: i64,
    best: i64,
    best_path: Path,
    /// Accepted moves, of which the first `moves_to_best` lead to the best path.
    moves: Vec<Move>,
    moves_to_best: usize,
}

impl<'a> Run<'a> {
    pub(super) fn new<C: Cost>(
        start: &Path,
        cost: &C,
        settings: &'a Settings<'a>,
        control: &'a Control<'a>,
    ) -> Self {
        let initial = cost.total(start);
        Self {
            settings,
            control,
            rng: Xoshiro256PlusPlus::seed_from_u64(settings.seed),
            initial,
            current: initial,
            best: initial,
            best_path: start.clone(),
            path: start.clone(),
            moves: Vec::new(),
            moves_to_best: 0,
        }
    }

    /// Records a move that was just applied to the path, and returns whether it led to a new best.
    #[inline]
    pub(super) fn accept(&mut self, applied: Move, change: i64) -> bool {
        self.current += change;
        self.moves.push(applied);
        let is_better = self.current < self.best;
        if is_better {
            self.best = self.current;
            self.best_path.copy_from(&self.path);
            self.moves_to_best = self.moves.len();
        }
        is_better
    }

    /// Why the run should stop before its planned end, if it should.
    pub(super) fn should_stop(&self) -> Option<Stop> {
        self.goal_reached().or_else(|| self.control.interrupted().map(Stop::from))
    }

    fn goal_reached(&self) -> Option<Stop> {
        let &Settings { proven_bound, target, .. } = self.settings;
        Goal { proven_bound, target }.reached(self.best)
    }

    /// Reports the progress of the run.
    pub(super) fn report(&self, proposals: u64, planned: u64, temperature: f64) {
        self.control.report(proposals as usize, planned as usize);
        if let Some(observer) = self.settings.observer {
            let (cost, best) = (self.current, self.best);
            observer(Progress { proposals, planned, temperature, cost, best });
        }
    }

    /// Ends a run that made all of its proposals.
    pub(super) fn complete(self, proposals: u64) -> Outcome {
        self.control.report(proposals as usize, proposals as usize);
        let stop = self.goal_reached().unwrap_or(Stop::Done);
        self.finish(stop, proposals)
    }

    /// Ends a run.
    pub(super) fn finish(mut self, stop: Stop, proposals: u64) -> Outcome {
        let accepted = self.moves.len() as u64;
        self.moves.truncate(self.moves_to_best);
        Outcome {
            path: self.best_path,
            initial: self.initial,
            cost: self.best,
            proven_bound: self.settings.proven_bound,
            stop,
            moves: self.moves,
            proposals,
            accepted,
        }
    }
}
