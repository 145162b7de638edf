//! Walks that follow proposals to better paths (Aali et al., section FusionNet, inference).
//!
//! A walk is an iterated local search with a tabu list:
//! - Each step applies the proposed move with the lowest change of crossings, even if that is an
//!   increase; among equals, the one with the highest score.
//!   Moves that return to a state visited before are excluded.
//! - After [`Settings::patience`] moves without a new best, or when no proposal is left, the walk
//!   is perturbed.
//!   It returns to its best path, unless its present path is as good, and applies some random
//!   moves, accepted as by an annealer at a fixed temperature.
//!   The number of random moves grows with each perturbation until a new best is found.
//!
//! All applied moves count towards the budget.
//! Several layers are walked in lockstep, so that the network sees them in batches.

use std::collections::HashSet;

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Links, Path, PlacedVariant};
use beadwork_search::{Move, Stop};
use rand::SeedableRng;
use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;
use rand_chacha::ChaCha8Rng;

use super::layer::{AppliedMove, Layer, State};
use super::propose::{Proposal, Proposer};

/// How to walk.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// Maximum number of moves of a walk, random ones included.
    pub budget: usize,
    /// Moves without a new best after which the walk is perturbed; with 0, all moves are random.
    pub patience: usize,
    /// Whether a perturbation starts from the best path so far, rather than from the present path.
    /// A present path that is as good as the best one replaces it.
    pub returns: bool,
    /// Number of random moves of the first perturbation after a new best; 0 counts as 1.
    pub perturbation: usize,
    /// Growth limit: the n-th perturbation since the last new best has n times as many moves, but
    /// at most `escalation` times as many; 0 counts as 1.
    pub escalation: usize,
    /// Temperature at which random moves are accepted, in crossings; positive.
    pub temperature: f64,
    /// Called before each forward pass and at the end, with the status of all walks.
    /// It also receives the crossings, which [`Control::progress`] does not.
    pub observer: Option<&'a dyn Fn(Status)>,
}

/// Status of a group of walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// Moves applied by the longest walk.
    pub moves: usize,
    /// Crossings of the best paths, summed over all walks.
    pub crossings: u64,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self {
            budget: 2000,
            patience: 16,
            returns: true,
            perturbation: 4,
            escalation: 8,
            temperature: 1.0,
            observer: None,
        }
    }
}

/// A path to improve.
#[derive(Debug)]
pub struct Task<'a> {
    /// Its layer.
    pub layer: &'a Layer,
    /// The start path.
    pub start: &'a Path,
    /// Number of crossings at which the walk ends.
    pub target: u32,
    /// Seed of the random moves.
    pub seed: u64,
}

/// The result of a walk.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best path.
    pub path: Path,
    /// Crossings of the start path.
    pub initial: u32,
    /// Crossings of the best path.
    pub crossings: u32,
    /// The moves from the start path to the best path.
    pub moves: Vec<Move>,
    /// Number of all moves applied, including those that do not lead to the best path.
    pub total_moves: usize,
    /// Number of random moves among all moves applied.
    pub random_moves: usize,
    /// [`Stop::TargetReached`]; [`Stop::Done`] if the budget is spent or no move applies;
    /// [`Stop::Cancelled`] or [`Stop::TimeUp`] if the walk was interrupted.
    pub stop: Stop,
}

/// Walks from all starts, each until its target or the budget is reached.
///
/// The walks do not influence each other, apart from rounding in the network's batches.
///
/// Costs a forward pass for each move of the longest walk, on all layers that are still walking.
/// Progress counts the moves of the longest walk; `total` is the budget.
/// When `control` interrupts, the outcomes hold the best paths so far.
/// Its threads are not used: libtorch has its own.
///
/// # Panics
/// If the temperature is not positive.
pub fn solve(
    tasks: &[Task<'_>],
    proposer: &mut dyn Proposer,
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Vec<Outcome> {
    assert!(
        settings.temperature > 0.0,
        "temperature is {}: expected a positive number",
        settings.temperature
    );
    let mut walks: Vec<_> = tasks.iter().map(Walk::new).collect();
    let interrupted = loop {
        let moves = walks.iter().map(|walk| walk.total_moves).max().unwrap_or_default();
        if let Some(observer) = settings.observer {
            let crossings = walks.iter().map(|walk| u64::from(walk.best)).sum();
            observer(Status { moves, crossings });
        }
        control.report(moves, settings.budget);
        let mut active: Vec<_> =
            walks.iter_mut().filter(|walk| !walk.has_ended(settings)).collect();
        if active.is_empty() {
            break None;
        }
        if let Some(interrupted) = control.interrupted() {
            break Some(interrupted);
        }
        let states: Vec<_> = active.iter().map(|walk| walk.state()).collect();
        let proposed = proposer.propose(&states);
        for (walk, proposals) in active.iter_mut().zip(proposed) {
            walk.step(&proposals, settings);
        }
    };
    walks.into_iter().map(|walk| walk.finish(settings, interrupted)).collect()
}

/// The state of one walk.
struct Walk<'a> {
    task: &'a Task<'a>,
    links: Links,
    initial: u32,
    crossings: u32,
    /// Crossings of the best path.
    best: u32,
    /// The moves from the start path to the present path.
    moves: Vec<AppliedMove>,
    /// Number of the first `moves` that lead to the best path.
    moves_to_best: usize,
    /// Number of all moves applied, including those that were taken back.
    total_moves: usize,
    /// `total_moves` at the last new best or after the last perturbation.
    last_reset: usize,
    random_moves: usize,
    /// Perturbations since the last new best.
    perturbations: usize,
    /// Zobrist hashes of all states visited, relative to the start: the tabu list.
    visited: HashSet<u64>,
    /// Hash of the present state.
    hash: u64,
    rng: ChaCha8Rng,
    /// Whether no move applies.
    stuck: bool,
}

impl<'a> Walk<'a> {
    fn new(task: &'a Task<'a>) -> Self {
        let initial = task.layer.crossings().count(task.start);
        Self {
            task,
            links: Links::new(task.start),
            initial,
            crossings: initial,
            best: initial,
            moves: Vec::new(),
            moves_to_best: 0,
            total_moves: 0,
            last_reset: 0,
            random_moves: 0,
            perturbations: 0,
            visited: HashSet::from([0]),
            hash: 0,
            rng: ChaCha8Rng::seed_from_u64(task.seed),
            stuck: false,
        }
    }

    fn has_ended(&self, settings: &Settings<'_>) -> bool {
        self.best <= self.task.target || self.total_moves >= settings.budget || self.stuck
    }

    fn state(&self) -> State<'_> {
        State {
            layer: self.task.layer,
            links: &self.links,
            crossings: self.crossings,
            initial: self.initial,
            moves: &self.moves,
        }
    }

    /// Applies the best proposal that is not tabu, or perturbs the path.
    fn step(&mut self, proposals: &[Proposal], settings: &Settings<'_>) {
        let width = self.task.layer.size().0;
        let allowed = proposals
            .iter()
            .filter(|proposal| !self.visited.contains(&(self.hash ^ hash(proposal.placed, width))));
        // `min_by_key` returns the first of equal ones, which has the highest score.
        let chosen = allowed.min_by_key(|proposal| proposal.change).copied();
        match chosen {
            Some(proposal) if self.total_moves - self.last_reset < settings.patience => {
                self.apply(proposal.placed, proposal.change);
            }
            _ => self.perturb(settings),
        }
    }

    /// Applies random moves, from the best path if the settings say so.
    fn perturb(&mut self, settings: &Settings<'_>) {
        if settings.returns {
            if self.crossings == self.best {
                // The present path is as good as the recorded best path, from which no better path
                // was found: it becomes the recorded one.
                self.moves_to_best = self.moves.len();
            } else {
                self.return_to_best();
            }
        }
        self.perturbations += 1;
        let factor = self.perturbations.min(settings.escalation.max(1));
        for _ in 0..settings.perturbation.max(1) * factor {
            let Some((placed, change)) = self.draw_move(settings.temperature) else {
                self.stuck = true;
                return;
            };
            self.apply(placed, change);
            self.random_moves += 1;
            if self.has_ended(settings) {
                return;
            }
        }
        self.last_reset = self.total_moves;
    }

    /// Draws a move as an annealer would accept it: rejection-free Metropolis sampling.
    /// `None` if no move applies.
    ///
    /// An annealer proposes moves uniformly and accepts a move that adds d crossings with
    /// probability min(1, e^(-d / T)).
    /// So the probability that a move is the accepted one is proportional to that, and drawing from
    /// this distribution directly avoids the rejections.
    fn draw_move(&mut self, temperature: f64) -> Option<(PlacedVariant, i32)> {
        let mut moves = Vec::new();
        let layer = self.task.layer;
        self.links.for_each_variant(|placed| moves.push((placed, layer.change(placed))));
        // Subtracting the lowest increase leaves all ratios as they are, and makes the largest
        // weight 1: not all of them can underflow to 0.
        let lowest = moves.iter().map(|&(_, change)| change.max(0)).min()?;
        let weights = moves
            .iter()
            .map(|&(_, change)| (f64::from(lowest - change.max(0)) / temperature).exp());
        let distribution = WeightedIndex::new(weights).expect("the largest weight is 1");
        Some(moves[distribution.sample(&mut self.rng)])
    }

    /// Restores the best path by replaying its moves, which are not counted again.
    fn return_to_best(&mut self) {
        self.moves.truncate(self.moves_to_best);
        self.links = Links::new(self.task.start);
        self.hash = 0;
        for applied in &self.moves {
            assert!(self.links.apply_variant(applied.placed), "applied moves apply in a replay");
            self.hash ^= hash(applied.placed, self.task.layer.size().0);
        }
        self.crossings = self.best;
    }

    fn apply(&mut self, placed: PlacedVariant, change: i32) {
        assert!(self.links.apply_variant(placed), "proposed moves apply");
        let before = self.crossings;
        self.crossings = before.saturating_add_signed(change);
        self.moves.push(AppliedMove { placed, before, after: self.crossings });
        self.total_moves += 1;
        self.hash ^= hash(placed, self.task.layer.size().0);
        self.visited.insert(self.hash);
        if self.crossings < self.best {
            self.best = self.crossings;
            self.moves_to_best = self.moves.len();
            self.last_reset = self.total_moves;
            self.perturbations = 0;
        }
    }

    fn finish(self, settings: &Settings<'_>, interrupted: Option<Interrupted>) -> Outcome {
        let moves: Vec<_> = self.moves[..self.moves_to_best]
            .iter()
            .map(|applied| Move::Variant(applied.placed))
            .collect();
        let mut path = self.task.start.clone();
        for step in &moves {
            assert!(step.apply(&mut path), "a move that applies to the links applies to the path");
        }
        let stop = match interrupted {
            _ if self.best <= self.task.target => Stop::TargetReached,
            Some(interrupted) if !self.has_ended(settings) => interrupted.into(),
            _ => Stop::Done,
        };
        Outcome {
            path,
            initial: self.initial,
            crossings: self.best,
            moves,
            total_moves: self.total_moves,
            random_moves: self.random_moves,
            stop,
        }
    }
}

/// Zobrist hash of a move: the exclusive or of the hashes of its switches.
///
/// The hash of a state is the exclusive or over all moves that led to it, so it depends only on
/// which unit cells were switched an odd number of times, which determines the links.
fn hash(placed: PlacedVariant, width: u32) -> u64 {
    placed.switches(width).iter().fold(0, |hash, switch| hash ^ switch.zobrist_key())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use std::collections::BTreeMap;

    use beadwork_grid::{Layout, LayoutSpec, Region, Start};
    use rand::RngExt;

    use super::*;

    /// Compares with an annealer's loop: propose uniformly, accept by the Metropolis rule.
    #[test]
    fn random_moves_are_distributed_as_an_annealer_accepts_them() {
        let region = Region::rectangle(12, 11).unwrap();
        let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 4).unwrap();
        let layer = Layer::new(&region, &zones);
        let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let task = Task { layer: &layer, start: &start, target: 0, seed: 3 };
        let mut walk = Walk::new(&task);
        (0..10).for_each(|_| {
            walk.draw_move(5.0).into_iter().for_each(|(placed, change)| walk.apply(placed, change));
        });
        let mut all = Vec::new();
        walk.links.for_each_variant(|placed| all.push((placed, layer.change(placed))));
        for temperature in [0.4, 2.0] {
            const DRAWS: usize = 20_000;
            let (mut drawn, mut accepted) = (BTreeMap::new(), BTreeMap::new());
            for _ in 0..DRAWS {
                *drawn.entry(walk.draw_move(temperature).unwrap().1).or_insert(0_usize) += 1;
                let change = loop {
                    let (_, change) = all[(walk.rng.random::<f64>() * all.len() as f64) as usize];
                    if walk.rng.random::<f64>() < (-f64::from(change) / temperature).exp() {
                        break change;
                    }
                };
                *accepted.entry(change).or_insert(0_usize) += 1;
            }
            assert!(drawn.len() > 2, "{drawn:?}");
            for change in drawn.keys().chain(accepted.keys()) {
                let [drawn, accepted] = [&drawn, &accepted]
                    .map(|counts| counts.get(change).copied().unwrap_or(0) as f64);
                assert!(
                    (drawn - accepted).abs() < 5.0 * (drawn + accepted).sqrt(),
                    "{change}: drawn {drawn} times, accepted {accepted} times"
                );
            }
        }
    }
}
