//! Watched runs against runs that nobody watches.

use super::*;
use crate::testing::{half_printed, stairs, unprinted};
use crate::{Material, Method, Process};

/// Layer 0 in rows, with a long pause in its middle.
fn slots(simulation: &Simulation) -> Vec<Slot> {
    let cells: Vec<_> = simulation.part().cells(0).collect();
    let mut slots = simulation.slots(0, &cells);
    slots.insert(slots.len() / 2, Slot::pause(1.7));
    slots.insert(3, Slot::pause(0.0));
    slots
}

#[test]
fn looking_changes_nothing_of_the_plain_scheme() {
    // Without pauses, whose length the plain scheme's steps follow.
    let process = Process { travel_mm_s: None, ..Process::default() };
    let mut run =
        Simulation::new(stairs(13, 7, 3), &Material::abs(), &process, Method::Naive).unwrap();
    let cells: Vec<_> = run.part().cells(0).collect();
    let slots = run.slots(0, &cells);
    let mut watched = run.clone();
    run.run(&slots).unwrap();
    let mut looks = 0;
    watched.run_watched(&slots, 0.1, |_| looks += 1).unwrap();
    assert!(looks > 5);
    assert_eq!(run.spread(), watched.spread());
    assert!(run.layer_c(0).eq(watched.layer_c(0)));
}

#[test]
fn looks_come_in_time_and_change_little() {
    let mut run = half_printed(&stairs(13, 7, 5));
    run.pause(0.123);
    let rest = [Slot::pause(0.4), Slot::pause(0.0), Slot::pause(7.3)];
    let (mut watched, mut times) = (run.clone(), Vec::new());
    run.run(&rest).unwrap();
    watched.run_watched(&rest, 0.25, |simulation| times.push(simulation.seconds())).unwrap();
    // All of it is pauses: looks are exact.
    let first = (times[0] / 0.25).round();
    for (number, &time) in times.iter().enumerate() {
        assert!((time - (first + number as f64) * 0.25).abs() < 1e-6, "{times:?}");
    }
    assert!((30..=31).contains(&times.len()), "{times:?}");
    assert!((run.seconds() - watched.seconds()).abs() < 1e-9);
    for layer in 0..5 {
        for ((cell, a), (other, b)) in run.layer_c(layer).zip(watched.layer_c(layer)) {
            assert!(cell == other && (a - b).abs() < 0.5, "{layer}, {cell}: {a} {b}");
        }
    }
}

#[test]
fn births_are_whole_and_refused_slots_change_nothing() {
    let mut simulation = unprinted(stairs(13, 7, 3));
    let slots = slots(&simulation);

    let birth_s = simulation.part().frame.cell_mm / simulation.process().print_mm_s;
    let mut last = 0.0;
    let mut watched = simulation.clone();
    watched
        .run_watched(&slots, 0.25, |simulation| {
            let late = simulation.seconds().rem_euclid(0.25);
            assert!(late < birth_s || late > 0.25 - 1e-6, "{late}");
            assert!(simulation.seconds() > last);
            last = simulation.seconds();
        })
        .unwrap();
    let repeated = [slots.clone(), slots].concat();
    let before = simulation.clone();
    let refused = simulation.run_watched(&repeated, 0.25, |_| panic!("nothing is run"));
    assert!(matches!(refused, Err(DepositError::Repeated { .. })));
    assert_eq!(simulation.spread(), before.spread());
}

#[test]
fn probes_tell_what_was_there() {
    let mut simulation = unprinted(stairs(13, 7, 3));
    let slots = slots(&simulation);
    let mut probes = Probes::new(vec![[0, 0, 0], [12, 6, 0], [0, 0, 2]]);
    simulation.run_watched(&slots, 0.1, |simulation| probes.look(simulation)).unwrap();
    let [first, last, never] = [0, 1, 2].map(|probe| probes.celsius(probe).collect::<Vec<_>>());
    assert_eq!(probes.seconds().len(), first.len());
    assert!(first.iter().all(Option::is_some));
    assert!(first[..10].windows(2).all(|pair| pair[1] < pair[0]), "{first:?}");
    let born = last.iter().take_while(|celsius| celsius.is_none()).count();
    assert!(born >= last.len() - 1);
    assert!(never.iter().all(Option::is_none));
}

#[test]
fn time_above_nears_that_of_short_intervals() {
    let above_c = 105.0;
    let of = |every_s: f64| {
        let mut simulation = unprinted(stairs(13, 7, 3));
        let slots = slots(&simulation);
        let mut time = TimeAbove::new(&simulation, above_c);
        simulation.run_watched(&slots, every_s, |simulation| time.look(simulation)).unwrap();
        (time, simulation)
    };
    let ((coarse, simulation), (fine, _)) = (of(0.1), of(0.01));
    let (mut most, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for (cell, _) in simulation.layer_c(0) {
        let voxel = [cell % 13, cell / 13, 0];
        let (a, b) = (coarse.at(voxel).unwrap(), fine.at(voxel).unwrap());
        assert!((a - b).abs() < 0.13, "{voxel:?}: {a} {b}");
        (most, sum, count) = (most.max(b), sum + a - b, count + 1.0);
    }
    assert!(most > 0.2, "{most}");
    assert!((sum / count).abs() < 0.02, "{sum}");
    assert_eq!((fine.at([13, 0, 0]), fine.at([0, 0, 3])), (None, None));
    assert!(fine.seconds()[13 * 7..].iter().all(|&seconds| seconds == 0.0));
}
