//! The loop over the generations.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Path;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::crossover::{Crossover, mutate};
use super::gene::{Gene, padded};
use super::individual::{self, Individual};
use super::parameters::Evolution;
use super::replay::{self, Replay, State};
use super::settings::{Outcome, Settings};
use crate::random::{below, unit};
use crate::stop::Goal;
use crate::{Cost, Move, Stop};

/// Evolves a population whose moves are replayed on `state`, the state of the path `start`.
pub(super) fn run<C: Cost + Sync, S: State>(
    state: &S,
    start: &Path,
    cost: &C,
    population: &[Vec<Move>],
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Outcome {
    let &Settings { ref evolution, proven_bound, target, .. } = settings;
    assert!(evolution.population > 0 && evolution.tournament > 0, "there must be parents to draw");
    let length = population.iter().map(Vec::len).max().unwrap_or(0);
    let snapshots = replay::snapshots(state, evolution.population);
    let replay = Replay::new(state, start, cost, length, snapshots);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    // The annealing runs took their seeds from the same generator; this part of its sequence does
    // not overlap with theirs.
    rng.jump();
    let no_moves = Vec::new();
    let lists = (0..evolution.population)
        .map(|index| population.get(index % population.len().max(1)).unwrap_or(&no_moves));
    let first: Vec<Vec<Gene>> = lists.map(|moves| padded(moves, length)).collect();
    let new_state = || state.clone();
    let mut all: Vec<Individual<S>> =
        control.threads.map_with(&first, new_state, |state, genes| replay.first(genes, state));
    drop(first);
    let mut replayed = all.iter().map(|individual| individual.replayed).sum();
    let mut spared = 0;
    let mut generations = Vec::new();
    let mut stayed = 0;
    let stop = loop {
        // A stable sort: of equally good individuals, the older ones come first.
        all.sort_by_key(|individual| individual.cost);
        let number = generations.len() as u32;
        let generation = individual::describe(&all, number, stayed);
        generations.push(generation);
        control.report(number as usize, evolution.generations as usize);
        if let Some(observer) = settings.observer {
            observer(generation);
        }
        // Checked before the goal: an interrupted run may have started with fewer individuals, so
        // its result must not be reported as that of a complete run.
        if let Some(interrupted) = control.interrupted() {
            break interrupted.into();
        }
        if let Some(reached) = (Goal { proven_bound, target }).reached(all[0].cost) {
            break reached;
        }
        if number == evolution.generations {
            break Stop::Done;
        }
        let (mut next, births) = draw(&all, evolution, &mut rng);
        let grid = (start.width(), start.height());
        let breed = |state: &mut S, birth: &Birth| {
            control.check()?;
            let parents = birth.parents.map(|parent| &all[parent]);
            if birth.is_copy(parents.map(|parent| &parent.genes), evolution) {
                return Ok(parents[0].copy());
            }
            let genes = birth.genes::<S>(parents.map(|parent| &parent.genes[..]), evolution, grid);
            Ok(replay.child(genes, parents, state))
        };
        let children = control.threads.map_with(&births, new_state, breed);
        let children = match children.into_iter().collect() {
            Ok::<Vec<_>, beadwork_base::Interrupted>(children) => children,
            Err(interrupted) => break interrupted.into(),
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
        proven_bound,
        stop,
        moves,
        generations,
        length,
        replayed,
        spared,
    }
}

/// A child that is to be bred.
pub(super) struct Birth {
    /// The parents' indices in the sorted population; twice the same for a copy.
    pub(super) parents: [usize; 2],
    /// Seed of the child's own random choices, so that children can be bred in any order.
    pub(super) seed: u64,
}

/// Draws the individuals that are carried over from a population sorted by cost, and the parents of
/// the children.
fn draw<S: State>(
    all: &[Individual<S>],
    evolution: &Evolution,
    rng: &mut Xoshiro256PlusPlus,
) -> (Vec<Individual<S>>, Vec<Birth>) {
    let size = evolution.population;
    let elites = evolution.elites.min(size);
    let carried = ((evolution.carry_over * size as f64) as usize).clamp(elites, size);
    // Without replacement, by a partial Fisher-Yates shuffle: crossing two equal parents gives
    // nothing new.
    let mut indices: Vec<usize> = (0..size).collect();
    for index in elites..carried {
        indices.swap(index, index + below(rng, size - index));
    }
    let next = indices[..carried].iter().map(|&index| all[index].clone()).collect();
    let mut births = Vec::new();
    for _ in carried..size {
        // The population is sorted, so the best of a tournament has the smallest index.
        let mut parent = || {
            let drawn = (0..evolution.tournament).map(|_| below(rng, size));
            drawn.min().expect("a tournament has at least one individual")
        };
        let (first, second) = (parent(), parent());
        let second = if unit(rng) < evolution.crossover_rate { second } else { first };
        births.push(Birth { parents: [first, second], seed: rng.next_u64() });
    }
    (next, births)
}

impl Birth {
    /// Whether the child is certain to equal its first parent, so that a copy will do.
    /// True for most children once the population has converged.
    fn is_copy(&self, [one, other]: [&Arc<[Gene]>; 2], evolution: &Evolution) -> bool {
        // Window crossover moves blanks to the end even if both parents are equal.
        let is_equal = Arc::ptr_eq(one, other) && evolution.crossover != Crossover::Window;
        evolution.mutations == 0 && (is_equal || self.parents[0] == self.parents[1])
    }

    /// The genes of the child, in a grid of the given width and height.
    pub(super) fn genes<S: State>(
        &self,
        parents: [&[Gene]; 2],
        evolution: &Evolution,
        grid: (u32, u32),
    ) -> Vec<Gene> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut genes = if self.parents[0] == self.parents[1] {
            parents[0].to_vec()
        } else {
            evolution.crossover.cross(parents, grid, &mut rng)
        };
        for _ in 0..evolution.mutations {
            mutate(&mut genes, grid, |placed| S::gene(placed, grid.0), &mut rng);
        }
        genes
    }
}
