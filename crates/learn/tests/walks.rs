//! Proposals and walks.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

mod common;

use std::sync::atomic::AtomicBool;

use beadwork_base::Control;
use beadwork_grid::{Links, Start, verify};
use beadwork_learn::Device;
use beadwork_learn::fusion::layer::State;
use beadwork_learn::fusion::propose::{AllMoves, Asked, Proposer};
use beadwork_learn::fusion::walk::{Task, WalkSettings, walk};
use beadwork_learn::fusion::{FusionNet, VarStore};
use beadwork_search::Stop;

use self::common::{alone, layer, small};

#[test]
fn walks_make_better_paths_and_count_every_move() {
    let _alone = alone();
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
        [Box::new(Asked::new(&network, Device::Cpu)), Box::new(AllMoves { seed: 0 })];
    for proposer in &mut proposers {
        for returns in [true, false] {
            let settings = WalkSettings { budget: 150, returns, ..WalkSettings::default() };
            let walked = walk(&tasks, proposer.as_mut(), &settings);
            for (((region, _, layer), start), walked) in layers.iter().zip(&starts).zip(&walked) {
                assert_eq!(verify(region, walked.path.order()), Ok(1));
                assert_eq!(walked.crossings, layer.crossings().count(&walked.path));
                assert_eq!(walked.initial, layer.crossings().count(start));
                assert!(walked.crossings <= walked.initial && walked.moves.len() <= walked.made);
                assert!(walked.perturbed <= walked.made && walked.made <= 150);
                assert_eq!(walked.stop == Stop::TargetReached, walked.crossings <= 5);
                let mut path = start.clone();
                assert!(walked.moves.iter().all(|step| step.apply(&mut path)));
                assert_eq!(path.order(), walked.path.order());
            }
            let alone = walk(&tasks[3..4], proposer.as_mut(), &settings).pop().unwrap();
            assert_eq!(
                (&alone.moves, alone.made),
                (&walked[3].moves, walked[3].made),
                "no company is felt"
            );
        }
    }
    // So cold that nothing that adds crossings is ever accepted by chance: the least that any move
    // adds is.
    let cold =
        WalkSettings { budget: 150, patience: 0, temperature: 1e-9, ..WalkSettings::default() };
    assert!(walk(&tasks, &mut AllMoves { seed: 0 }, &cold).iter().all(|walked| walked.made > 0));
    let cancel = AtomicBool::new(true);
    let settings = WalkSettings { cancel: Some(&cancel), ..WalkSettings::default() };
    let walked = walk(&tasks, &mut AllMoves { seed: 0 }, &settings);
    assert!(walked.iter().all(|walked| walked.made == 0));
}

/// Layers asked about together get the proposals that each gets alone, whatever their sizes.
#[test]
fn proposals_do_not_depend_on_the_company() {
    let _alone = alone();
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
        .map(|((.., layer), links)| State { layer, links, crossings: 9, initial: 10, made: &[] })
        .collect();
    let mut asked = Asked { places: 3, ..Asked::new(&network, Device::Cpu) };
    let together = asked.propose(&states);
    for (state, proposed) in states.iter().zip(&together) {
        let alone = asked.propose(std::slice::from_ref(state)).pop().unwrap();
        assert_eq!(alone.len(), proposed.len());
        assert!(proposed.is_sorted_by(|a, b| a.score >= b.score));
        for (one, other) in alone.iter().zip(proposed) {
            assert_eq!((one.placed, one.change), (other.placed, other.change));
            assert!((one.score - other.score).abs() < 1e-4);
            assert_eq!(one.change, state.layer.change(one.placed));
            assert!(state.links.allows_variant(one.placed));
        }
        let places: std::collections::HashSet<_> =
            proposed.iter().map(|one| (one.placed.x, one.placed.y)).collect();
        assert!(places.len() <= 3);
    }
}
