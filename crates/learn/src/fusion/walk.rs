//! From proposals to better paths: Aali et al., section FusionNet, inference.
//!
//! Of the proposed moves the one that lowers the crossings most is made, of equal ones the one that
//! scores most, and none that leads back to a state seen before.
//! Where no new best comes for long, or nothing is left to do, the walk goes back to its best path,
//! unless it has come to another that is as good, and from there some moves are made as an annealer
//! makes them, the more the longer it has been in vain.
//! All moves ever made are counted.
//! Many layers are walked together, so that the network sees them in batches.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};

use beadwork_grid::{Links, Path, PlacedVariant};
use beadwork_search::{Move, Stop};
use rand::SeedableRng;
use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;
use rand_chacha::ChaCha8Rng;

use super::layer::{Layer, Made, State};
use super::propose::{Proposal, Proposer};

/// How to walk.
#[derive(Clone, Copy)]
pub struct WalkSettings<'a> {
    /// Most moves, perturbations included; 0 for none.
    pub budget: usize,
    /// Moves without a new best after which some are made at random; with 0 no others are.
    pub patience: usize,
    /// Whether these are made from the best path so far, the last of equal ones, rather than from
    /// where the walk is.
    pub returns: bool,
    /// Number of those; 0 is taken as 1.
    pub perturbation: usize,
    /// As many times that number are made at most, after as many perturbations in vain; 0 is taken
    /// as 1.
    pub escalation: usize,
    /// The temperature at which they are accepted, in crossings: positive.
    pub temperature: f64,
    /// Ends all walks soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Told before each question, and at the end, how far the walks have come.
    pub observer: Option<&'a dyn Fn(Progress)>,
}

/// How far walks have come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Moves made by the longest.
    pub made: usize,
    /// Crossings of the best paths of all walks together.
    pub crossings: u64,
}

impl Default for WalkSettings<'_> {
    fn default() -> Self {
        Self {
            budget: 2000,
            patience: 16,
            returns: true,
            perturbation: 4,
            escalation: 8,
            temperature: 1.0,
            cancel: None,
            observer: None,
        }
    }
}

/// A path to be improved.
#[derive(Debug)]
pub struct Task<'a> {
    /// Its layer.
    pub layer: &'a Layer,
    /// The path to begin with.
    pub start: &'a Path,
    /// Crossings that are enough.
    pub target: u32,
    /// Seed of the moves made at random.
    pub seed: u64,
}

/// What a walk came to.
#[derive(Clone, Debug)]
pub struct Walked {
    /// The best path.
    pub path: Path,
    /// Crossings of the start.
    pub initial: u32,
    /// Crossings of the best path.
    pub crossings: u32,
    /// The moves to it.
    pub moves: Vec<Move>,
    /// All moves made.
    pub made: usize,
    /// Those of them that were made at random.
    pub perturbed: usize,
    /// [`Stop::TargetReached`] where the target is reached, [`Stop::Done`] where the budget is spent or
    /// nothing applies, [`Stop::Cancelled`].
    pub stop: Stop,
}

/// One of the walks.
struct Walk<'a> {
    task: &'a Task<'a>,
    links: Links,
    initial: u32,
    crossings: u32,
    best: u32,
    /// The moves from the start to the present path.
    trail: Vec<Made>,
    moves_to_best: usize,
    /// All moves made, and how many they were at the last new best or perturbation.
    made: usize,
    since: usize,
    perturbed: usize,
    /// Perturbations since the last new best.
    failures: usize,
    /// Keys of the states it has been in.
    seen: HashSet<u64>,
    key: u64,
    rng: ChaCha8Rng,
    stuck: bool,
}

/// Walks from all starts, each until its target or the budget is reached.
/// The walks do not depend on each other, but for what the proposer makes of them.
///
/// Costs a question for each move of the longest walk, with all layers that are still walked.
///
/// # Panics
/// If the temperature is not positive.
pub fn walk(
    tasks: &[Task<'_>],
    proposer: &mut dyn Proposer,
    settings: &WalkSettings<'_>,
) -> Vec<Walked> {
    assert!(
        settings.temperature > 0.0,
        "a temperature of {} is not positive",
        settings.temperature
    );
    let mut walks: Vec<_> = tasks.iter().map(Walk::new).collect();
    loop {
        if let Some(observer) = settings.observer {
            observer(Progress {
                made: walks.iter().map(|walk| walk.made).max().unwrap_or_default(),
                crossings: walks.iter().map(|walk| u64::from(walk.best)).sum(),
            });
        }
        let mut active: Vec<_> =
            walks.iter_mut().filter(|walk| !walk.has_ended(settings)).collect();
        let cancelled = settings.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if active.is_empty() || cancelled {
            break;
        }
        let states: Vec<_> = active.iter().map(|walk| walk.state()).collect();
        let proposed = proposer.propose(&states);
        for (walk, proposals) in active.iter_mut().zip(proposed) {
            walk.step(&proposals, settings);
        }
    }
    walks.into_iter().map(|walk| walk.finish(settings)).collect()
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
            trail: Vec::new(),
            moves_to_best: 0,
            made: 0,
            since: 0,
            perturbed: 0,
            failures: 0,
            seen: HashSet::from([0]),
            key: 0,
            rng: ChaCha8Rng::seed_from_u64(task.seed),
            stuck: false,
        }
    }

    fn has_ended(&self, settings: &WalkSettings<'_>) -> bool {
        self.best <= self.task.target || self.made >= settings.budget || self.stuck
    }

    fn state(&self) -> State<'_> {
        State {
            layer: self.task.layer,
            links: &self.links,
            crossings: self.crossings,
            initial: self.initial,
            made: &self.trail,
        }
    }

    fn step(&mut self, proposals: &[Proposal], settings: &WalkSettings<'_>) {
        let width = self.task.layer.size().0;
        let fresh = proposals
            .iter()
            .filter(|proposal| !self.seen.contains(&(self.key ^ key(proposal.placed, width))));
        // The first of equal ones scores most.
        let chosen = fresh.min_by_key(|proposal| proposal.change).copied();
        match chosen {
            Some(proposal) if self.made - self.since < settings.patience => {
                self.make(proposal.placed, proposal.change);
            }
            _ => self.perturb(settings),
        }
    }

    /// Moves as an annealer's at one temperature.
    fn perturb(&mut self, settings: &WalkSettings<'_>) {
        if settings.returns {
            if self.crossings == self.best {
                // As good as the one known so far, from which nothing better was found.
                self.moves_to_best = self.trail.len();
            } else {
                self.go_back();
            }
        }
        self.failures += 1;
        let count = settings.perturbation.max(1) * self.failures.min(settings.escalation.max(1));
        for _ in 0..count {
            let Some((placed, change)) = self.draw(settings.temperature) else {
                self.stuck = true;
                return;
            };
            self.make(placed, change);
            self.perturbed += 1;
            if self.has_ended(settings) {
                return;
            }
        }
        self.since = self.made;
    }

    /// A move that applies: drawn as if any were tried until one is accepted, whatever it adds to
    /// the crossings with a chance of e to the power of that, negative, by the temperature.
    fn draw(&mut self, temperature: f64) -> Option<(PlacedVariant, i32)> {
        let mut all = Vec::new();
        self.links.for_each_variant(|placed| all.push((placed, self.task.layer.change(placed))));
        // The least that any adds is taken from all, which changes no ratio, so that not all
        // chances are too small to tell.
        let least = all.iter().map(|&(_, change)| change.max(0)).min()?;
        let chances =
            all.iter().map(|&(_, change)| (f64::from(least - change.max(0)) / temperature).exp());
        let chances = WeightedIndex::new(chances).expect("one of them at least is 1");
        Some(all[chances.sample(&mut self.rng)])
    }

    /// Takes up the best path again, which is no move: it was never given away.
    fn go_back(&mut self) {
        self.trail.truncate(self.moves_to_best);
        self.links = Links::new(self.task.start);
        self.key = 0;
        for made in &self.trail {
            assert!(self.links.apply_variant(made.placed), "what was made can be made again");
            self.key ^= key(made.placed, self.task.layer.size().0);
        }
        self.crossings = self.best;
    }

    fn make(&mut self, placed: PlacedVariant, change: i32) {
        assert!(self.links.apply_variant(placed), "a proposed move applies");
        let before = self.crossings;
        self.crossings = before.saturating_add_signed(change);
        self.trail.push(Made { placed, before, after: self.crossings });
        self.made += 1;
        self.key ^= key(placed, self.task.layer.size().0);
        self.seen.insert(self.key);
        if self.crossings < self.best {
            self.best = self.crossings;
            self.moves_to_best = self.trail.len();
            self.since = self.made;
            self.failures = 0;
        }
    }

    fn finish(self, settings: &WalkSettings<'_>) -> Walked {
        let moves: Vec<_> = self.trail[..self.moves_to_best]
            .iter()
            .map(|made| Move::Variant(made.placed))
            .collect();
        let mut path = self.task.start.clone();
        for step in &moves {
            assert!(step.apply(&mut path), "what applies to the links applies to the path");
        }
        let stop = match (self.best <= self.task.target, self.has_ended(settings)) {
            (true, _) => Stop::TargetReached,
            (false, true) => Stop::Done,
            (false, false) => Stop::Cancelled,
        };
        Walked {
            path,
            initial: self.initial,
            crossings: self.best,
            moves,
            made: self.made,
            perturbed: self.perturbed,
            stop,
        }
    }
}

/// A number by which states are told apart: exclusive or of those of all unit cells switched an odd
/// number of times.
fn key(placed: PlacedVariant, width: u32) -> u64 {
    placed.switches(width).iter().fold(0, |key, switch| key ^ switch.zobrist_key())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use std::collections::BTreeMap;

    use beadwork_base::Control;
    use beadwork_grid::{Layout, LayoutSpec, Region, Start};
    use rand::RngExt;

    use super::*;

    /// An annealer tries any move, and makes it by a chance that falls with the crossings it adds.
    #[test]
    fn random_moves_are_drawn_as_an_annealer_accepts_them() {
        let region = Region::rectangle(12, 11).unwrap();
        let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 4).unwrap();
        let layer = Layer::new(&region, &zones);
        let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let task = Task { layer: &layer, start: &start, target: 0, seed: 3 };
        let mut walk = Walk::new(&task);
        (0..10).for_each(|_| {
            walk.draw(5.0).into_iter().for_each(|(placed, change)| walk.make(placed, change))
        });
        let mut all = Vec::new();
        walk.links.for_each_variant(|placed| all.push((placed, layer.change(placed))));
        for temperature in [0.4, 2.0] {
            const DRAWS: usize = 20_000;
            let (mut drawn, mut accepted) = (BTreeMap::new(), BTreeMap::new());
            for _ in 0..DRAWS {
                *drawn.entry(walk.draw(temperature).unwrap().1).or_insert(0_usize) += 1;
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
                let [ours, theirs] =
                    [&drawn, &accepted].map(|of| of.get(change).copied().unwrap_or(0) as f64);
                assert!(
                    (ours - theirs).abs() < 5.0 * (ours + theirs).sqrt(),
                    "{change}: {ours} {theirs}"
                );
            }
        }
    }
}
