//! The fast stepper neither makes nor loses heat to speak of.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use beadwork_thermal::plain::Scheme;
use beadwork_thermal::{Accuracy, Method};
use common::{Print, Random, block, random_part, uneven};

const METHODS: [Method; 2] = [Method::Fast(Accuracy::Standard), Method::Fast(Accuracy::High)];

fn prints() -> impl Iterator<Item = Print> {
    (0..10).map(|seed| {
        let mut random = Random::new(4000 + seed);
        let part = random_part(&mut random, [40, 24, 4]);
        let mut print = Print::paper(&mut random, part);
        if seed % 2 == 1 {
            print.slots = uneven(&mut random, print.slots, 2.0, 1.5);
        }
        print
    })
}

/// No loss to anything.
fn insulated(mut print: Print) -> Print {
    print.material.emissivity = 0.0;
    print.process.convection_w_m2k = 0.0;
    print.process.plate_c = None;
    print
}

#[test]
fn heat_is_that_of_the_reference() {
    for (seed, print) in prints().chain(prints().map(insulated)).enumerate() {
        let reference = print.run(Method::Reference { steps: 4 }).stored_j();
        let moved = print.run_plain(Scheme::Euler).energy().moved_j;
        for method in METHODS {
            let drift = (print.run(method).stored_j() - reference).abs() / moved;
            assert!(drift < 1e-3, "print {seed}, {method:?}: {drift}");
        }
    }
}

#[test]
fn an_insulated_part_keeps_its_heat() {
    for (seed, print) in prints().map(insulated).enumerate() {
        for method in METHODS.into_iter().chain([Method::Naive, Method::Reference { steps: 1 }]) {
            let mut simulation = print.run(method);
            let before = simulation.stored_j();
            for seconds in [0.01, 0.3, 3.0, 100.0] {
                simulation.pause(seconds);
                let drift = (simulation.stored_j() / before - 1.0).abs();
                assert!(drift < 1e-3, "print {seed}, {method:?}, {seconds} s: {drift}");
            }
        }
    }
}

/// Of a part at one temperature, by hand.
#[test]
fn stored_heat_is_capacity_times_warmth() {
    let print = insulated(Print::paper(&mut Random::new(1), block(5, 4, 3)));
    let mut simulation = print.empty(Method::Naive);
    assert!(simulation.stored_j().abs() < 1e-15);
    let voxel_j = 945.0 * 1470.0 * 0.0625e-9 * 205.0;
    for (born, slot) in (1u32..).zip(print.slots.iter().filter(|slot| slot.voxel.is_some())) {
        simulation.run(&[*slot]).unwrap();
        let expected = f64::from(born) * voxel_j;
        assert!((simulation.stored_j() / expected - 1.0).abs() < 1e-6, "{born}");
    }
}
