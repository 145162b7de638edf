//! The fast method conserves heat.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use beadwork_thermal::oracle::scalar::Scheme;
use beadwork_thermal::simulation::{Accuracy, Method};
use common::{Print, Random, block, pause, random_part, run, uneven};

const METHODS: [Method; 2] = [Method::Fast(Accuracy::Standard), Method::Fast(Accuracy::High)];

fn prints() -> impl Iterator<Item = Print> {
    (0..10).map(|seed| {
        let mut random = Random::new(4000 + seed);
        let part = random_part(&mut random, [40, 24, 4]);
        let mut print = Print::paper(&mut random, part);
        if seed % 2 == 1 {
            print.events = uneven(&mut random, print.events, 2.0, 1.5);
        }
        print
    })
}

/// The same print without loss to plate or air.
fn insulated(mut print: Print) -> Print {
    print.material.emissivity = 0.0;
    print.process.convection_w_m2k = 0.0;
    print.process.plate_c = None;
    print
}

#[test]
fn heat_is_that_of_the_reference_method() {
    for (seed, print) in prints().chain(prints().map(insulated)).enumerate() {
        let reference = print.run(Method::Reference { steps: 4 }).stored_heat_j();
        let moved = print.run_scalar(Scheme::Euler).energy().moved_j;
        for method in METHODS {
            let drift = (print.run(method).stored_heat_j() - reference).abs() / moved;
            assert!(drift < 1e-3, "print {seed}, {method:?}: {drift}");
        }
    }
}

#[test]
fn an_insulated_part_keeps_its_heat() {
    for (seed, print) in prints().map(insulated).enumerate() {
        for method in METHODS.into_iter().chain([Method::Naive, Method::Reference { steps: 1 }]) {
            let mut simulation = print.run(method);
            let before = simulation.stored_heat_j();
            for seconds in [0.01, 0.3, 3.0, 100.0] {
                pause(&mut simulation, seconds);
                let drift = (simulation.stored_heat_j() / before - 1.0).abs();
                assert!(drift < 1e-3, "print {seed}, {method:?}, {seconds} s: {drift}");
            }
        }
    }
}

/// Every voxel is at the extrusion temperature.
#[test]
fn stored_heat_is_capacity_times_temperature() {
    let print = insulated(Print::paper(&mut Random::new(1), block(5, 4, 3)));
    let mut simulation = print.empty(Method::Naive);
    assert!(simulation.stored_heat_j().abs() < 1e-15);
    let voxel_j = 945.0 * 1470.0 * 0.0625e-9 * 205.0;
    for (born, event) in (1u32..).zip(print.events.iter().filter(|event| event.voxel.is_some())) {
        run(&mut simulation, &[*event]);
        let expected = f64::from(born) * voxel_j;
        assert!((simulation.stored_heat_j() / expected - 1.0).abs() < 1e-6, "{born}");
    }
}
