//! Threads, interruption and progress of long calls.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{CancelToken, Control, Interrupted, Progress, Threads};
use beadwork_thermal::event::layer_events;
use beadwork_thermal::simulation::{Accuracy, DepositError, Method};
use beadwork_thermal::{DepositionEvent, Simulation};
use common::{Print, Random, bits, block, field, frame, part_of, run, uneven};

const STANDARD: Method = Method::Fast(Accuracy::Standard);
const HIGH: Method = Method::Fast(Accuracy::High);
const METHODS: [Method; 4] = [Method::Naive, Method::Reference { steps: 2 }, STANDARD, HIGH];

/// A print on a grid so wide that the fast method takes steps on blocks.
fn wide_print() -> Print {
    let part = part_of(frame(512, 512), 2, |[x, y, _]| x < 60 && y < 30);
    let mut random = Random::new(1);
    let mut print = Print::paper(&mut random, part);
    print.events = uneven(&mut random, print.events, 2.0, 1.2);
    print
}

fn small_print() -> Print {
    let mut random = Random::new(2);
    let mut print = Print::paper(&mut random, block(60, 30, 3));
    print.events = uneven(&mut random, print.events, 2.0, 1.2);
    print
}

/// Runs through events until the control has been polled some times.
fn run_until(simulation: &mut Simulation, events: &[DepositionEvent], polls: usize) -> bool {
    let polled = AtomicUsize::new(0);
    let time_is_up = || polled.fetch_add(1, Ordering::Relaxed) >= polls;
    let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
    match simulation.run(events, &control) {
        Ok(()) => false,
        Err(error) => {
            assert_eq!(error, DepositError::Interrupted(Interrupted::TimeUp));
            true
        }
    }
}

/// Events up to a time, the last of them cut.
fn cut(events: &[DepositionEvent], mut seconds: f64) -> Vec<DepositionEvent> {
    let mut cut = Vec::new();
    for event in events {
        if seconds <= 1e-9 {
            break;
        }
        cut.push(DepositionEvent { seconds: event.seconds.min(seconds), ..*event });
        seconds -= event.seconds;
    }
    cut
}

/// Interrupts a run, compares it with a run of the events up to the interruption, and deposits the
/// rest.
/// Returns false if the run ended before the interruption.
#[track_caller]
fn assert_valid(print: &Print, method: Method, polls: usize) -> bool {
    let mut interrupted = print.empty(method);
    if !run_until(&mut interrupted, &print.events, polls) {
        return false;
    }
    let seconds = interrupted.seconds();
    let total_s: f64 = print.events.iter().map(|event| event.seconds).sum();
    assert!((0.0..total_s).contains(&seconds), "{seconds}");

    // The voxels deposited so far are the first ones of the events, and none is due after the
    // present time.
    let deposited = |voxel| interrupted.temperature_c(voxel).is_some();
    let births: Vec<_> = print.events.iter().filter_map(|event| event.voxel).collect();
    let count = births.iter().take_while(|&&voxel| deposited(voxel)).count();
    assert!(!births[count..].iter().any(|&voxel| deposited(voxel)));
    let expected = cut(&print.events, seconds);
    let begun = expected.iter().filter(|event| event.voxel.is_some()).count();
    assert!(count == begun || count == begun + 1, "{count} voxels are deposited, not {begun}");

    let mut fresh = print.empty(method);
    run(&mut fresh, &expected);
    assert!((fresh.seconds() - seconds).abs() < 1e-6);
    let pairs = field(&interrupted).into_iter().zip(field(&fresh));
    let apart = pairs.filter(|(_, b)| !b.is_nan()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 2.5, "{method:?}, {polls} polls: {apart} K");

    // Whatever is left can be deposited.
    let rest: Vec<_> = births[count..]
        .iter()
        .map(|&voxel| DepositionEvent { voxel: Some(voxel), seconds: 0.01 })
        .collect();
    let part = &print.part;
    let last = births[..count].last().map(|&[x, y, _]| y * part.frame.width + x);
    let next = layer_events(&[0], 0, last, &part.frame, &print.process);
    assert_eq!(interrupted.layer_events(0, &[0]), next);
    run(&mut interrupted, &rest);
    assert!(field(&interrupted).iter().all(|celsius| (0.0..231.0).contains(celsius)));
    true
}

#[test]
fn interrupted_runs_are_valid() {
    let print = small_print();
    for method in METHODS {
        assert!([1, 2, 7, 30].into_iter().all(|polls| assert_valid(&print, method, polls)));
        assert!(!assert_valid(&print, method, usize::MAX));
    }
}

#[test]
fn interrupted_runs_with_steps_on_blocks_are_valid() {
    let print = wide_print();
    for method in [STANDARD, HIGH] {
        assert!([1, 2, 3, 6].into_iter().all(|polls| assert_valid(&print, method, polls)));
    }
}

#[test]
fn long_pauses_can_be_interrupted() {
    for method in METHODS {
        let mut simulation = small_print().run(method);
        let before_s = simulation.seconds();
        let polled = AtomicUsize::new(0);
        let time_is_up = || polled.fetch_add(1, Ordering::Relaxed) > 5;
        let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
        assert_eq!(simulation.pause(1e6, &control), Err(Interrupted::TimeUp));
        let passed_s = simulation.seconds() - before_s;
        assert!(passed_s > 0.0 && passed_s < 1000.0, "{method:?}: {passed_s} s");
    }
}

#[test]
fn a_cancelled_call_changes_nothing() {
    let print = small_print();
    let (first, second) = print.events.split_at(print.events.len() / 2);
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let interrupted = Err(DepositError::Interrupted(Interrupted::Cancelled));
    for method in METHODS {
        let mut simulation = print.empty(method);
        run(&mut simulation, first);
        let before = (bits(&simulation), simulation.seconds());
        assert_eq!(simulation.run(second, &control), interrupted);
        assert_eq!(simulation.run_sampled(second, 0.1, |_| panic!(), &control), interrupted);
        assert_eq!(simulation.deposit(1, &[0], &control).map(|_| ()), interrupted);
        assert_eq!(simulation.pause(1.0, &control), Err(Interrupted::Cancelled));
        assert_eq!((bits(&simulation), simulation.seconds()), before);
    }
}

#[test]
fn progress_counts_events() {
    // A few steps of blocks, at most, are between two reports.
    for (print, max_gap) in [(small_print(), 600), (wide_print(), 1200)] {
        for method in [STANDARD, HIGH] {
            let reports = Mutex::new(Vec::new());
            let report = |progress: Progress| reports.lock().unwrap().push(progress);
            let control = Control { progress: Some(&report), ..Control::default() };
            print.empty(method).run(&print.events, &control).unwrap();
            let reports = reports.into_inner().unwrap();
            let total = print.events.len();
            assert!(reports.iter().all(|progress| progress.total == total));
            assert_eq!(reports.last().unwrap().done, total);
            let mut before = 0;
            for Progress { done, .. } in reports {
                assert!(done > before && done - before <= max_gap, "{before}, {done} of {total}");
                before = done;
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let mut random = Random::new(3);
    let print = Print::paper(&mut random, block(120, 100, 3));
    let events = &print.events[..print.events.len().min(13_000)];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for method in [Method::Reference { steps: 1 }, STANDARD] {
        let on = |threads| {
            let mut simulation = print.empty(method);
            simulation.run(events, &Control::on(threads)).unwrap();
            (bits(&simulation), simulation.seconds().to_bits())
        };
        let alone = on(Threads::One);
        assert!(on(Threads::Pool(&pool)) == alone, "{method:?}");
        assert!(pool.install(|| on(Threads::Current)) == alone, "{method:?}");
    }
}
