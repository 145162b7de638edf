//! The fast method against the reference method: its errors are at most those of the naive method,
//! or at most those measured here.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use beadwork_base::Control;
use beadwork_thermal::event::layer_events;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{DepositionEvent, ProcessParameters, Simulation, ThermalMaterial};
use common::{
    Difference, Print, Random, bits, block, difference, field, part_of, pause, random_part, run,
    uneven,
};

const STANDARD: Method = Method::Fast(Accuracy::Standard);
const HIGH: Method = Method::Fast(Accuracy::High);

/// Errors in K that are accepted even where those of the naive method are smaller.
/// Over 160 prints of this kind, RMS and maximum errors reached 0.10 and 1.5 with standard
/// accuracy, 0.06 and 0.43 with high accuracy, and 0.65 and 5.4 with the naive method.
const FLOORS: [(Method, Difference); 2] =
    [(STANDARD, Difference { rms: 0.11, max: 1.6 }), (HIGH, Difference { rms: 0.065, max: 0.5 })];

/// Small prints with the paper's settings, and a wider one for every fourth seed.
fn paper_print(seed: u64) -> (Random, Print) {
    let mut random = Random::new(2000 + seed);
    let part =
        random_part(&mut random, if seed.is_multiple_of(4) { [70, 40, 3] } else { [30, 24, 5] });
    let print = Print::paper(&mut random, part);
    (random, print)
}

fn assert_good(print: &Print, seed: u64, naive: bool) {
    let reference = field(&print.run(Method::Reference { steps: 4 }));
    let naive = if naive {
        difference(&field(&print.run(Method::Naive)), &reference)
    } else {
        Difference::default()
    };
    for (method, floor) in FLOORS {
        let apart = difference(&field(&print.run(method)), &reference);
        let good = apart.rms <= naive.rms.max(floor.rms) && apart.max <= naive.max.max(floor.max);
        assert!(good, "print {seed}, {method:?}: {apart:?}, naive {naive:?}");
    }
}

#[test]
fn patterns_interleaved_lines_and_random_orders() {
    (0..10).for_each(|seed| assert_good(&paper_print(seed).1, seed, true));
}

#[test]
fn pauses_and_events_of_other_durations() {
    for seed in 10..22 {
        let (mut random, mut print) = paper_print(seed);
        print.events = uneven(&mut random, print.events, 3.0, 1.5);
        assert_good(&print, seed, true);
    }
}

#[test]
fn very_long_events_and_pauses() {
    for seed in 20..28 {
        let (mut random, mut print) = paper_print(seed);
        print.events = uneven(&mut random, print.events, 0.5, 1.2);
        for event in print.events.iter_mut().step_by(301) {
            event.seconds = if event.voxel.is_some() { 2.0 } else { 60.0 };
        }
        // Such events are too long for the naive method.
        assert_good(&print, seed, false);
    }
}

#[test]
fn other_materials_and_processes() {
    for seed in 0..16 {
        let print = Print::random(&mut Random::new(3000 + seed), [30, 24, 5]);
        assert_good(&print, seed, true);
    }
}

/// Right after a deposition, a long step would leave sharp temperature differences.
#[test]
fn pauses_after_a_print() {
    for seed in 0..6 {
        let (_, print) = paper_print(seed);
        let printed =
            [Method::Reference { steps: 2 }, STANDARD, HIGH].map(|method| print.run(method));
        for seconds in [0.1, 0.7, 2.0, 3.0, 10.0, 30.0] {
            let fields = printed.each_ref().map(|simulation| {
                let mut simulation = simulation.clone();
                pause(&mut simulation, seconds);
                field(&simulation)
            });
            for (fast, [rms, max]) in [(&fields[1], [0.3, 1.3]), (&fields[2], [0.3, 0.8])] {
                let apart = difference(fast, &fields[0]);
                let good = apart.rms < rms && apart.max < max;
                assert!(good, "print {seed}, {seconds} s: {apart:?}");
            }
        }
    }
}

#[test]
fn parts_cool_to_the_ambient_temperature() {
    let (_, mut print) = paper_print(3);
    print.process.plate_c = None;
    for method in [STANDARD, HIGH, Method::Reference { steps: 1 }, Method::Naive] {
        let mut simulation = print.run(method);
        let mut before = f64::INFINITY;
        for _ in 0..12 {
            pause(&mut simulation, 100.0);
            let stored = simulation.stored_heat_j();
            assert!(stored < before && stored >= 0.0, "{method:?}");
            before = stored;
        }
        let apart = field(&simulation).iter().map(|c| (c - 25.0).abs()).fold(0.0, f64::max);
        assert!(apart < 0.02, "{method:?}: {apart}");
    }
}

/// Voxels without a support may be deposited far above all others.
#[test]
fn depositions_high_above_everything() {
    let part = part_of(common::frame(40, 40), 30, |[x, y, z]| z >= 20 || [x, y, z] == [0, 0, 0]);
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    for method in [STANDARD, HIGH] {
        let mut simulation = Simulation::new(part.clone(), &material, &process, method).unwrap();
        let order: Vec<_> = part.cells(20).collect();
        simulation.deposit(20, &order, &Control::default()).unwrap();
        simulation.deposit(0, &[0], &Control::default()).unwrap();
        assert!(field(&simulation).iter().all(|c| c.is_nan() || (25.0..=230.01).contains(c)));
    }
}

#[test]
fn event_by_event_or_all_at_once() {
    for seed in 0..4 {
        let (_, print) = paper_print(4 * seed + 1);
        for (method, floor) in FLOORS {
            let whole = print.run(method);
            let mut stepped = print.empty(method);
            for events in print.events.chunks(1 + 6 * seed as usize) {
                run(&mut stepped, events);
            }
            let apart = difference(&field(&whole), &field(&stepped));
            assert!(
                apart.rms < floor.rms && apart.max < floor.max,
                "print {seed}, {method:?}: {apart:?}"
            );
            assert!((whole.seconds() - stepped.seconds()).abs() < 1e-6);
        }
    }
}

#[test]
fn clones_are_independent() {
    let (mut random, print) = paper_print(5);
    let half = print.events.len() / 2;
    let (first, second) = print.events.split_at(half);
    for method in [STANDARD, HIGH, Method::Naive, Method::Reference { steps: 1 }] {
        let mut parent = print.empty(method);
        run(&mut parent, first);
        let frozen = bits(&parent);
        let mut forks: Vec<Simulation> = (0..3).map(|_| parent.clone()).collect();
        run(&mut forks[0], second);
        pause(&mut forks[1], random.real(0.5, 5.0));
        assert_eq!(bits(&parent), frozen, "{method:?}");
        assert_eq!(bits(&forks[2]), frozen, "{method:?}");
        run(&mut forks[1], second);
        run(&mut forks[2], second);
        assert_eq!(bits(&forks[2]), bits(&forks[0]), "{method:?}");
        assert_ne!(bits(&forks[1]), bits(&forks[0]), "{method:?}");

        let mut fresh = print.empty(method);
        run(&mut fresh, first);
        run(&mut fresh, second);
        assert_eq!(bits(&fresh), bits(&forks[0]), "{method:?}");
        // The original gives the same bits, although its buffers hold data of its first run.
        run(&mut parent, second);
        assert_eq!(bits(&fresh), bits(&parent), "{method:?}");
    }
}

#[test]
fn layers_are_events() {
    let part = block(20, 12, 3);
    for method in [STANDARD, Method::Naive] {
        let mut random = Random::new(1);
        let print = Print::paper(&mut random, part.clone());
        let mut random = Random::new(1);
        let mut layers = print.empty(method);
        let mut events = print.empty(method);
        let mut last = None;
        for layer in 0..3 {
            let order = common::random_order(&mut random, &part, layer as usize);
            let seconds = layers.deposit(layer, &order, &Control::default()).unwrap();
            let list = layer_events(&order, layer, last, &part.frame, &print.process);
            let sum = list.iter().map(|event: &DepositionEvent| event.seconds).sum::<f64>();
            assert!((sum - seconds).abs() < 1e-9);
            run(&mut events, &list);
            last = order.last().copied();
        }
        assert_eq!(bits(&layers), bits(&events));
        assert_eq!(layers.cell_temperatures_c(1).count(), 240);
        assert_eq!(layers.cell_temperatures_c(3).count(), 0);
    }
}

/// Flat or tall voxels, strong wind, hot air: steps stay stable, and temperatures stay between
/// those of nozzle, plate and air.
#[test]
fn extreme_settings_stay_stable() {
    for seed in 0..16 {
        let mut random = Random::new(5000 + seed);
        let shape = random_part(&mut random, [20, 14, 4]);
        let mut frame = shape.frame;
        frame.layer_mm = random.real(0.1, 1.5);
        frame.cell_mm = random.real(0.2, 2.0);
        let part = part_of(frame, shape.depth, |[x, y, z]| {
            shape.material(x as u32, y as u32, z).is_some()
        });
        let mut print = Print::paper(&mut random, part);
        print.process.convection_w_m2k = [0.0, 100.0, 1e4, 1e5][random.below(4)];
        print.process.ambient_c = random.real(-40.0, 300.0);
        print.process.plate_c = (!random.one_in(3)).then(|| random.real(-20.0, 200.0));
        print.process.surface_resistance = random.one_in(2);
        let ProcessParameters { extrusion_c, ambient_c, plate_c, .. } = print.process;
        let around = [extrusion_c, ambient_c, plate_c.unwrap_or(ambient_c)];
        let low = around.into_iter().fold(f64::INFINITY, f64::min);
        let high = around.into_iter().fold(f64::NEG_INFINITY, f64::max);
        for (method, slack) in
            [(Method::Reference { steps: 2 }, 0.01), (STANDARD, 3.0), (HIGH, 3.0)]
        {
            let mut simulation = print.run(method);
            for seconds in [0.0, 0.5, 20.0] {
                pause(&mut simulation, seconds);
                for celsius in field(&simulation) {
                    let inside = (low - slack..=high + slack).contains(&celsius);
                    assert!(
                        inside,
                        "print {seed}, {method:?}, {seconds} s: {celsius}, {:?}",
                        print.process
                    );
                }
            }
        }
    }
}
