//! Sampled runs against runs without samples.

use beadwork_base::{CancelToken, Interrupted};

use super::*;
use crate::simulation::Method;
use crate::testing::{half_printed, stairs, unprinted};
use crate::{ProcessParameters, ThermalMaterial};

/// Layer 0 in rows, with a long pause in the middle.
fn events(simulation: &Simulation) -> Vec<DepositionEvent> {
    let cells: Vec<_> = simulation.part().cells(0).collect();
    let mut events = simulation.layer_events(0, &cells);
    events.insert(events.len() / 2, DepositionEvent::pause(1.7));
    events.insert(3, DepositionEvent::pause(0.0));
    events
}

fn run(simulation: &mut Simulation, events: &[DepositionEvent]) {
    simulation.run(events, &Control::default()).unwrap();
}

fn run_sampled(
    simulation: &mut Simulation,
    events: &[DepositionEvent],
    interval_s: f64,
    sample: impl FnMut(&Simulation),
) {
    simulation.run_sampled(events, interval_s, sample, &Control::default()).unwrap();
}

#[test]
fn samples_change_nothing_of_the_naive_method() {
    // Without pauses, as the steps of a pause depend on its length.
    let process = ProcessParameters { travel_mm_s: None, ..ProcessParameters::default() };
    let mut whole =
        Simulation::new(stairs(13, 7, 3), &ThermalMaterial::abs(), &process, Method::Naive)
            .unwrap();
    let cells: Vec<_> = whole.part().cells(0).collect();
    let events = whole.layer_events(0, &cells);
    let mut sampled = whole.clone();
    run(&mut whole, &events);
    let mut samples = 0;
    run_sampled(&mut sampled, &events, 0.1, |_| samples += 1);
    assert!(samples > 5);
    assert_eq!(whole.statistics(), sampled.statistics());
    assert!(whole.cell_temperatures_c(0).eq(sampled.cell_temperatures_c(0)));
}

#[test]
fn samples_are_taken_in_time_and_change_little() {
    let mut whole = half_printed(&stairs(13, 7, 5));
    whole.pause(0.123, &Control::default()).unwrap();
    let rest = [0.4, 0.0, 7.3].map(DepositionEvent::pause);
    let (mut sampled, mut times) = (whole.clone(), Vec::new());
    run(&mut whole, &rest);
    run_sampled(&mut sampled, &rest, 0.25, |simulation| times.push(simulation.seconds()));
    // All events are pauses, so samples are taken at the exact times.
    let first = (times[0] / 0.25).round();
    for (number, &time) in times.iter().enumerate() {
        assert!((time - (first + number as f64) * 0.25).abs() < 1e-6, "{times:?}");
    }
    assert!((30..=31).contains(&times.len()), "{times:?}");
    assert!((whole.seconds() - sampled.seconds()).abs() < 1e-9);
    for layer in 0..5 {
        let both = whole.cell_temperatures_c(layer).zip(sampled.cell_temperatures_c(layer));
        for ((cell, a), (other, b)) in both {
            assert!(cell == other && (a - b).abs() < 0.5, "{layer}, {cell}: {a} {b}");
        }
    }
}

#[test]
fn depositions_are_whole_and_refused_events_change_nothing() {
    let mut simulation = unprinted(stairs(13, 7, 3));
    let events = events(&simulation);

    let birth_s = simulation.part().frame.cell_mm / simulation.process().print_mm_s;
    let mut last = 0.0;
    run_sampled(&mut simulation.clone(), &events, 0.25, |simulation| {
        let late = simulation.seconds().rem_euclid(0.25);
        assert!(late < birth_s || late > 0.25 - 1e-6, "{late}");
        assert!(simulation.seconds() > last);
        last = simulation.seconds();
    });
    let repeated = [events.clone(), events].concat();
    let before = simulation.clone();
    let sample = |_: &Simulation| panic!("nothing is run");
    let refused = simulation.run_sampled(&repeated, 0.25, sample, &Control::default());
    assert!(matches!(refused, Err(DepositError::Repeated { .. })));
    assert_eq!(simulation.statistics(), before.statistics());
}

#[test]
fn an_interrupted_run_takes_no_more_samples() {
    let mut simulation = unprinted(stairs(13, 7, 3));
    let events = events(&simulation);
    let cancel = CancelToken::new();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let mut times = Vec::new();
    let sample = |simulation: &Simulation| {
        times.push(simulation.seconds());
        if times.len() == 3 {
            cancel.cancel();
        }
    };
    let result = simulation.run_sampled(&events, 0.25, sample, &control);
    assert_eq!(result, Err(DepositError::Interrupted(Interrupted::Cancelled)));
    assert_eq!(times.len(), 3);
    assert_eq!(times.last(), Some(&simulation.seconds()));
    let deposited = simulation.statistics().unwrap().count;
    let mut expected = events.iter().filter_map(|event| event.voxel).take(deposited);
    assert!(expected.all(|voxel| simulation.temperature_c(voxel).is_some()));
}

#[test]
fn probes_record_temperatures() {
    let mut simulation = unprinted(stairs(13, 7, 3));
    let events = events(&simulation);
    let mut probes = Probes::new(vec![[0, 0, 0], [12, 6, 0], [0, 0, 2]]);
    run_sampled(&mut simulation, &events, 0.1, |simulation| probes.sample(simulation));
    let [first, last, never] = [0, 1, 2].map(|probe| probes.celsius(probe).collect::<Vec<_>>());
    assert_eq!(probes.seconds().len(), first.len());
    assert!(first.iter().all(Option::is_some));
    assert!(first[..10].windows(2).all(|pair| pair[1] < pair[0]), "{first:?}");
    let before = last.iter().take_while(|celsius| celsius.is_none()).count();
    assert!(before >= last.len() - 1);
    assert!(never.iter().all(Option::is_none));
}

#[test]
fn time_above_converges_with_shorter_intervals() {
    let above_c = 105.0;
    let of = |interval_s: f64| {
        let mut simulation = unprinted(stairs(13, 7, 3));
        let events = events(&simulation);
        let mut time = TimeAbove::new(&simulation, above_c);
        run_sampled(&mut simulation, &events, interval_s, |simulation| time.sample(simulation));
        (time, simulation)
    };
    let ((coarse, simulation), (fine, _)) = (of(0.1), of(0.01));
    let (mut max, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for (cell, _) in simulation.cell_temperatures_c(0) {
        let voxel = [cell % 13, cell / 13, 0];
        let (a, b) = (coarse.at(voxel).unwrap(), fine.at(voxel).unwrap());
        assert!((a - b).abs() < 0.13, "{voxel:?}: {a} {b}");
        (max, sum, count) = (max.max(b), sum + a - b, count + 1.0);
    }
    assert!(max > 0.2, "{max}");
    assert!((sum / count).abs() < 0.02, "{sum}");
    assert_eq!((fine.at([13, 0, 0]), fine.at([0, 0, 3])), (None, None));
    assert_eq!(fine.seconds().dim(), (3, 7, 13));
    let above = fine.seconds();
    assert!(above.outer_iter().skip(1).all(|layer| layer.iter().all(|&seconds| seconds == 0.0)));
}
