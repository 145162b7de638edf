//! The genetic algorithm of Aali et al., section "Genetic algorithm".
//!
//! An individual is a list of moves, its *genes*, of fixed length: shorter lists end in blanks.
//! It is judged by replaying the genes one after the other from the start path, skipping those that
//! don't apply; its cost is the lowest seen on the way.
//! The first population are the moves of the best of many annealing runs ([`annealed`]).
//! In each generation ([`evolve`]) the best individuals and others drawn at random are carried
//! over, nobody twice, and children of tournament winners fill the rest; a child that costs much
//! more than its better parent is dropped for a copy of that one.
//!
//! Two things make it fast.
//! The paper's variants look at links alone, so they are replayed on [`Links`] instead of a
//! [`Path`]: a few nanoseconds a gene. And a child begins like one of its parents, so it is replayed from the last
//! state of that parent which was kept before the first gene that differs.
//!
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::genetic::{self, Preset, Settings};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Islands).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let outcome = genetic::solve(&start, &Crossings::new(&region, &zones), &Settings::preset(Preset::Short, 7));
//! let annealed = outcome.generations[0].best;
//! assert!(outcome.cost <= annealed && annealed < outcome.initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What it can find is made of the annealers' moves; how much it adds to their best run,
//! docs/results/zones.md tells.

mod crossover;
mod individual;
mod preset;
mod replay;
mod seeding;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beadwork_grid::{Links, Path};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

pub use crossover::Crossover;
pub use preset::{Preset, UnknownPreset};
pub use seeding::{Seeding, annealed};

use crate::parallel::in_parallel;
use crate::random::{below, unit};
use crate::stop::is_cancelled;
use crate::{Cost, Move, Stop};
use individual::{Gene, Individual};
use replay::{Replay, State};

/// Parameters of the evolution; the default is the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evolution {
    /// Individuals, at least 1.
    pub population: usize,
    /// Generations after the first population.
    pub generations: u32,
    /// Individuals drawn for a parent, of which the best becomes one; at least 1.
    pub tournament: u32,
    /// How two parents make a child.
    pub crossover: Crossover,
    /// Share of the children, 0..=1, that have two parents; the others begin as copies of one.
    pub crossover_rate: f64,
    /// Share of the population, 0..=1, that is carried over to the next generation.
    pub carry_over: f64,
    /// The best individuals, which are always among those carried over.
    pub elites: usize,
    /// By how much a child may cost more than its better parent without being dropped.
    pub tolerance: i64,
    /// Genes of each child that are replaced by random variants anywhere in the plane; 0 in the
    /// paper.
    pub mutations: u32,
}

impl Default for Evolution {
    fn default() -> Self {
        Self {
            population: 200,
            generations: 500,
            tournament: 3,
            crossover: Crossover::OnePoint { first: 0.6 },
            crossover_rate: 0.9,
            carry_over: 0.6,
            elites: 6,
            tolerance: 2,
            mutations: 0,
        }
    }
}

/// What a run needs beside its path and cost.
#[derive(Clone)]
pub struct Settings<'a> {
    /// Where the first population comes from.
    pub seeding: Seeding,
    /// How it evolves.
    pub evolution: Evolution,
    /// Seed of all random choices.
    pub seed: u64,
    /// A proven lower bound of the cost, at which it stops: it can't be beaten.
    pub bound: Option<i64>,
    /// Stops the run soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Told after each annealing run and each generation how far the run has come; perhaps from
    /// another thread.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
    /// The threads to work on; without one it works on the caller's.
    /// The result is the same.
    pub pool: Option<&'a rayon::ThreadPool>,
}

impl Settings<'_> {
    /// The settings of a preset, without bound, cancel token, observer and threads.
    pub fn preset(preset: Preset, seed: u64) -> Self {
        let (seeding, evolution) = preset.parameters();
        Self { seeding, evolution, seed, bound: None, cancel: None, observer: None, pool: None }
    }

    fn is_cancelled(&self) -> bool {
        is_cancelled(self.cancel)
    }
}

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// So many annealing runs are done.
    Seeded(u64),
    /// A generation has been bred.
    Bred(Generation),
}

/// What a population came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generation {
    /// 0 for the first population.
    pub number: u32,
    /// Lowest cost.
    pub best: i64,
    /// Mean cost.
    pub mean: f64,
    /// Share of the genes, 0..=1, in which an individual differs from the best one, on average; of
    /// at most 256 genes at equal distances.
    pub diversity: f64,
    /// Children that stayed, and neither cost too much nor equal a parent.
    pub stayed: u32,
}

/// What a run found.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best path.
    pub path: Path,
    /// Cost of the start.
    pub initial: i64,
    /// Cost of the best path, at most `initial`.
    pub cost: i64,
    /// The lower bound it was given.
    pub bound: Option<i64>,
    /// Why it stopped.
    pub stop: Stop,
    /// The moves from the start to the best path: replayed in order, they all apply and give it.
    pub moves: Vec<Move>,
    /// Each population, the first one included.
    pub generations: Vec<Generation>,
    /// Genes in each individual.
    pub length: usize,
    /// Genes tried in replays, blanks not counted.
    pub replayed: u64,
    /// Genes of children that kept states saved from being replayed, blanks included.
    pub spared: u64,
}

/// Anneals a first population and lets it evolve.
///
/// Costs the annealing runs, and then O(1) a gene that is replayed: at most children x length a
/// generation, and mostly much less.
pub fn solve<C: Cost + Sync>(start: &Path, cost: &C, settings: &Settings<'_>) -> Outcome {
    let population = annealed(start, cost, settings);
    evolve(start, cost, &population, settings)
}

/// Lets a population of lists of moves evolve, each to be replayed from `start`.
/// Of a longer list than asked, the first ones; a shorter one is repeated from its beginning, and
/// an empty one stands for the start alone.
///
/// See [`solve`] for its cost.
/// Memory: 12 bytes a gene, and up to 256 MB of kept states; of both half as much again with the
/// paper's parameters while a generation is bred, for parents stay until their children are there.
///
/// # Panics
/// If the evolution has no individuals or no tournament.
pub fn evolve<C: Cost + Sync>(
    start: &Path,
    cost: &C,
    population: &[Vec<Move>],
    settings: &Settings<'_>,
) -> Outcome {
    let variants = population.iter().flatten().all(|gene| matches!(gene, Move::Variant(_)));
    if variants {
        run(&Links::new(start), start, cost, population, settings)
    } else {
        run(start, start, cost, population, settings)
    }
}

fn run<C: Cost + Sync, S: State>(
    state: &S,
    start: &Path,
    cost: &C,
    population: &[Vec<Move>],
    settings: &Settings<'_>,
) -> Outcome {
    let evolution = &settings.evolution;
    assert!(evolution.population > 0 && evolution.tournament > 0, "there must be parents to draw");
    let length = population.iter().map(Vec::len).max().unwrap_or(0);
    let replay =
        Replay::new(state, start, cost, length, replay::marks(state, evolution.population));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    // Apart from the numbers that the annealing runs took their seeds from.
    rng.jump();
    let nobody = Vec::new();
    let lists = (0..evolution.population)
        .map(|place| population.get(place % population.len().max(1)).unwrap_or(&nobody));
    let first: Vec<Vec<Gene>> = lists.map(|moves| individual::padded(moves, length)).collect();
    let mut all: Vec<Individual<S>> = in_parallel(
        settings.pool,
        &first,
        || state.clone(),
        |state, genes| replay.first(genes, state),
    );
    drop(first);
    let mut replayed = all.iter().map(|individual| individual.replayed).sum();
    let mut spared = 0;
    let mut generations = Vec::new();
    let mut stayed = 0;
    let stop = loop {
        // Stable: of equally good ones, those that were there before come first.
        all.sort_by_key(|individual| individual.cost);
        let number = generations.len() as u32;
        let generation = individual::describe(&all, number, stayed);
        generations.push(generation);
        if let Some(observer) = settings.observer {
            observer(Progress::Bred(generation));
        }
        // First, for a cancelled run may have begun with fewer individuals than it would have
        // otherwise.
        if settings.is_cancelled() {
            break Stop::Cancelled;
        }
        if settings.bound.is_some_and(|bound| all[0].cost <= bound) {
            break Stop::Optimal;
        }
        if number == evolution.generations {
            break Stop::Done;
        }
        let (mut next, births) = draw(&all, evolution, &mut rng);
        let plane = (start.width(), start.height());
        let children = in_parallel(
            settings.pool,
            &births,
            || state.clone(),
            |state, birth: &Birth| {
                if settings.is_cancelled() {
                    return None;
                }
                let parents = [&all[birth.parents[0]], &all[birth.parents[1]]];
                if birth.copies(parents.map(|parent| &parent.genes), evolution) {
                    return Some(parents[0].copy());
                }
                let genes =
                    birth.genes::<S>(parents.map(|parent| &parent.genes[..]), evolution, plane);
                Some(replay.child(genes, parents, state))
            },
        );
        let Some(children) = children.into_iter().collect::<Option<Vec<Individual<S>>>>() else {
            break Stop::Cancelled;
        };
        stayed = 0;
        for (birth, child) in births.iter().zip(children) {
            replayed += child.replayed;
            spared += child.spared;
            let parents = birth.parents.map(|parent| &all[parent]);
            let better = if parents[0].cost <= parents[1].cost { parents[0] } else { parents[1] };
            let stays = child.cost <= better.cost.saturating_add(evolution.tolerance);
            stayed += u32::from(stays && child.is_new);
            next.push(if stays { child } else { better.clone() });
        }
        all = next;
    };
    let (path, moves) = replay.walk(start.clone(), &all[0]);
    Outcome {
        path,
        initial: replay.initial,
        cost: all[0].cost,
        bound: settings.bound,
        stop,
        moves,
        generations,
        length,
        replayed,
        spared,
    }
}

/// A child to be bred.
struct Birth {
    /// Two places in the sorted population; twice the same for a copy.
    parents: [usize; 2],
    /// Seed of its own random choices.
    seed: u64,
}

/// Those carried over, from a population sorted by cost, and the children to come.
fn draw<S: State>(
    all: &[Individual<S>],
    evolution: &Evolution,
    rng: &mut Xoshiro256PlusPlus,
) -> (Vec<Individual<S>>, Vec<Birth>) {
    let size = evolution.population;
    let elites = evolution.elites.min(size);
    let carried = ((evolution.carry_over * size as f64) as usize).clamp(elites, size);
    // Nobody twice: copies have nothing to cross.
    let mut places: Vec<usize> = (0..size).collect();
    for place in elites..carried {
        places.swap(place, place + below(rng, size - place));
    }
    let next = places[..carried].iter().map(|&place| all[place].clone()).collect();
    let mut births = Vec::new();
    for _ in carried..size {
        let mut parent = || {
            let drawn = (0..evolution.tournament).map(|_| below(rng, size));
            drawn.min().expect("a tournament has someone in it")
        };
        let (first, second) = (parent(), parent());
        let second = if unit(rng) < evolution.crossover_rate { second } else { first };
        births.push(Birth { parents: [first, second], seed: rng.next_u64() });
    }
    (next, births)
}

impl Birth {
    /// Whether the child will be like both parents, which is not even to be tried out: most pairs
    /// are such in a population that has converged.
    fn copies(&self, [one, other]: [&Arc<[Gene]>; 2], evolution: &Evolution) -> bool {
        // Window crossover moves blanks to the end, also where both parents are alike.
        let alike = Arc::ptr_eq(one, other) && evolution.crossover != Crossover::Window;
        evolution.mutations == 0 && (alike || self.parents[0] == self.parents[1])
    }

    /// The genes of the child.
    fn genes<S: State>(
        &self,
        parents: [&[Gene]; 2],
        evolution: &Evolution,
        plane: (u32, u32),
    ) -> Vec<Gene> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut genes = if self.parents[0] == self.parents[1] {
            parents[0].to_vec()
        } else {
            evolution.crossover.cross(parents, plane, &mut rng)
        };
        for _ in 0..evolution.mutations {
            crossover::mutate(&mut genes, plane, |placed| S::gene(placed, plane.0), &mut rng);
        }
        genes
    }
}
