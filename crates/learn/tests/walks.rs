//! Proposals, and walks that follow them.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

mod common;

use std::collections::HashSet;

use beadwork_base::{CancelToken, Control, Progress};
use beadwork_grid::{Links, Start, verify};
use beadwork_learn::Device;
use beadwork_learn::fusion::layer::State;
use beadwork_learn::fusion::propose::{AllMoves, NetworkProposer, Proposer};
use beadwork_learn::fusion::walk::{self, Settings, Task};
use beadwork_learn::fusion::{FusionNet, VarStore};
use beadwork_search::Stop;

use self::common::{layer, lock_generator, small};

#[test]
fn walks_improve_paths_and_count_every_move() {
    let _generator = lock_generator();
    tch::manual_seed(1);
    let training = small();
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), training.network());
    let layers: Vec<_> = (0..6).map(|seed| layer(12 + seed as u32 % 3, 10, seed)).collect();
    let starts: Vec<_> = layers
        .iter()
        .map(|(region, ..)| Start::RowZigzag.path(region, &Control::default()).unwrap())
        .collect();
    let mut tasks = Vec::new();
    for ((_, _, layer), start) in layers.iter().zip(&starts) {
        tasks.push(Task { layer, start, target: 5, seed: 7 });
    }
    let mut proposers: [Box<dyn Proposer>; 2] =
        [Box::new(NetworkProposer::new(&network, Device::Cpu)), Box::new(AllMoves { seed: 0 })];
    for proposer in &mut proposers {
        for returns in [true, false] {
            let settings = Settings { budget: 150, returns, ..Settings::default() };
            let outcomes = walk::solve(&tasks, proposer.as_mut(), &settings, &Control::default());
            for (((region, _, layer), start), outcome) in layers.iter().zip(&starts).zip(&outcomes)
            {
                assert_eq!(verify(region, outcome.path.order()), Ok(1));
                assert_eq!(outcome.crossings, layer.crossings().count(&outcome.path));
                assert_eq!(outcome.initial, layer.crossings().count(start));
                assert!(outcome.crossings <= outcome.initial);
                assert!(outcome.moves.len() <= outcome.total_moves);
                assert!(outcome.random_moves <= outcome.total_moves && outcome.total_moves <= 150);
                assert_eq!(outcome.stop == Stop::TargetReached, outcome.crossings <= 5);
                let mut path = start.clone();
                assert!(outcome.moves.iter().all(|step| step.apply(&mut path)));
                assert_eq!(path.order(), outcome.path.order());
            }
            let control = Control::default();
            let alone = walk::solve(&tasks[3..4], proposer.as_mut(), &settings, &control);
            assert_eq!(
                (&alone[0].moves, alone[0].total_moves),
                (&outcomes[3].moves, outcomes[3].total_moves),
                "walks do not influence each other"
            );
        }
    }
    // At this temperature e^(-d / T) underflows to 0 for every d > 0; a move must be drawn
    // nevertheless.
    let cold = Settings { budget: 150, patience: 0, temperature: 1e-9, ..Settings::default() };
    let outcomes = walk::solve(&tasks, &mut AllMoves { seed: 0 }, &cold, &Control::default());
    assert!(outcomes.iter().all(|outcome| outcome.total_moves > 0));
}

#[test]
fn a_walk_is_interrupted_with_its_best_path() {
    let (region, _, layer) = layer(12, 10, 0);
    let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    let tasks = [Task { layer: &layer, start: &start, target: 0, seed: 7 }];
    let solve = |control: &Control<'_>| {
        walk::solve(&tasks, &mut AllMoves { seed: 0 }, &Settings::default(), control).pop().unwrap()
    };
    let cancel = CancelToken::new();
    let report = |Progress { done, total }: Progress| {
        assert_eq!(total, Settings::default().budget);
        if done >= 20 {
            cancel.cancel();
        }
    };
    let control = Control { cancel: Some(&cancel), progress: Some(&report), ..Control::default() };
    let outcome = solve(&control);
    assert_eq!(outcome.stop, Stop::Cancelled);
    assert!(outcome.total_moves >= 20 && outcome.crossings <= outcome.initial);
    assert_eq!(outcome.crossings, layer.crossings().count(&outcome.path));
    assert_eq!(solve(&control).total_moves, 0);
    let is_up = || true;
    let outcome = solve(&Control { time_is_up: Some(&is_up), ..Control::default() });
    assert_eq!((outcome.stop, outcome.total_moves), (Stop::TimeUp, 0));
}

/// Proposals for a state are the same in a batch and alone, whatever the sizes of the layers.
#[test]
fn proposals_do_not_depend_on_the_batch() {
    let _generator = lock_generator();
    tch::manual_seed(1);
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), small().network());
    let layers: Vec<_> = (0..5).map(|seed| layer(12 + 6 * (seed as u32 % 2), 10, seed)).collect();
    let links: Vec<_> = layers
        .iter()
        .map(|(region, ..)| {
            Links::new(&Start::RowZigzag.path(region, &Control::default()).unwrap())
        })
        .collect();
    let states: Vec<_> = layers
        .iter()
        .zip(&links)
        .map(|((.., layer), links)| State { layer, links, crossings: 9, initial: 10, moves: &[] })
        .collect();
    let mut proposer =
        NetworkProposer { positions: 3, ..NetworkProposer::new(&network, Device::Cpu) };
    let together = proposer.propose(&states);
    for (state, proposed) in states.iter().zip(&together) {
        let alone = proposer.propose(std::slice::from_ref(state)).pop().unwrap();
        assert_eq!(alone.len(), proposed.len());
        assert!(proposed.is_sorted_by(|a, b| a.score >= b.score));
        for (one, other) in alone.iter().zip(proposed) {
            assert_eq!((one.placed, one.change), (other.placed, other.change));
            assert!((one.score - other.score).abs() < 1e-4);
            assert_eq!(one.change, state.layer.change(one.placed));
            assert!(state.links.allows_variant(one.placed));
        }
        let positions: HashSet<_> =
            proposed.iter().map(|one| (one.placed.x, one.placed.y)).collect();
        assert!(positions.len() <= 3);
    }
}
