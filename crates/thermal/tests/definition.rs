//! The explicit methods against the definition, and the definition's energy balance.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use beadwork_thermal::DepositionEvent;
use beadwork_thermal::oracle::scalar::Scheme;
use beadwork_thermal::simulation::Method;
use common::{Print, Random, difference, field, random_events, scalar_field, uneven};

/// Small prints of all kinds.
fn prints(seeds: u64) -> impl Iterator<Item = Print> {
    (0..seeds).map(|seed| {
        let mut random = Random::new(seed);
        let mut print = Print::random(&mut random, [9, 8, 6]);
        print.events = uneven(&mut random, print.events, 1.0, 1.5);
        print
    })
}

#[test]
fn no_heat_is_lost_or_made() {
    for print in prints(100) {
        for scheme in [Scheme::Euler, Scheme::Heun { steps: 2 }] {
            let mut solver = print.run_scalar(scheme);
            // Measured: 4e-15.
            assert!(solver.imbalance() <= 1e-12, "{scheme:?}: {}", solver.imbalance());
            solver.run(&[DepositionEvent::pause(2.0)]);
            assert!(solver.imbalance() <= 1e-12, "{scheme:?}, later: {}", solver.imbalance());
        }
    }
}

#[test]
fn the_naive_method_is_the_definition() {
    for (seed, print) in prints(150).enumerate() {
        let naive = print.run(Method::Naive);
        let solver = print.run_scalar(Scheme::Euler);
        let apart = difference(&field(&naive), &scalar_field(&print.part, &solver));
        // Measured: 3e-4.
        assert!(apart.max < 1e-3, "print {seed}: {apart:?}");
        let drift =
            (naive.stored_heat_j() - solver.stored_heat_j()).abs() / solver.energy().moved_j;
        assert!(drift < 2e-6, "print {seed}: {drift}");
        assert!((naive.seconds() - solver.seconds()).abs() < 1e-9);
    }
}

#[test]
fn the_reference_is_heuns_method() {
    for (seed, print) in prints(120).enumerate() {
        let steps = 1 + seed as u32 % 4;
        let reference = print.run(Method::Reference { steps });
        let solver = print.run_scalar(Scheme::Heun { steps });
        let apart = difference(&field(&reference), &scalar_field(&print.part, &solver));
        // Measured: 3e-3, which is the rounding of f32 over all steps.
        assert!(apart.max < 6e-3, "print {seed}, {steps} steps: {apart:?}");
    }
}

#[test]
fn larger_parts_too() {
    let mut random = Random::new(77);
    for width in [15, 31, 47] {
        // 16 numbers make a cache line, and two of a row are halo.
        let part = common::block(width, 5, 4);
        let mut print = Print::paper(&mut random, part);
        print.process.surface_resistance = width == 31;
        print.events = random_events(&mut random, &print.part, &print.process);
        let apart = difference(
            &field(&print.run(Method::Naive)),
            &scalar_field(&print.part, &print.run_scalar(Scheme::Euler)),
        );
        assert!(apart.max < 2e-3, "{width}: {apart:?}");
    }
}

/// Four steps per voxel are enough to measure the errors of other methods: eight change nothing
/// that matters.
#[test]
fn the_reference_converges() {
    for seed in 0..8 {
        let mut random = Random::new(seed);
        let part = common::random_part(&mut random, [24, 20, 4]);
        let print = Print::paper(&mut random, part);
        let with_steps = |steps| field(&print.run(Method::Reference { steps }));
        let [one, two, four, eight] = [1, 2, 4, 8].map(with_steps);
        let apart = difference(&four, &eight);
        assert!(apart.max < 0.02 && apart.rms < 0.003, "{seed}: {apart:?}");
        let (first, second) = (difference(&one, &two), difference(&two, &four));
        assert!(first.max > 2.5 * second.max, "{seed}: {first:?} {second:?}");
    }
}

/// Some events much longer than the others, and a print so slow that one step per voxel is not
/// stable.
#[test]
fn the_reference_is_stable_at_any_speed() {
    let mut random = Random::new(9);
    let mut print = Print::paper(&mut random, common::block(8, 6, 3));
    for event in print.events.iter_mut().step_by(17) {
        event.seconds = 3.0;
    }
    let apart = difference(
        &field(&print.run(Method::Reference { steps: 1 })),
        &scalar_field(&print.part, &print.run_scalar(Scheme::Heun { steps: 1 })),
    );
    assert!(apart.max < 5e-3, "{apart:?}");
    print.process.print_mm_s = 1.0;
    print.events = random_events(&mut random, &print.part, &print.process);
    let apart = difference(
        &field(&print.run(Method::Reference { steps: 1 })),
        &scalar_field(&print.part, &print.run_scalar(Scheme::Heun { steps: 32 })),
    );
    // The longest stable steps are not exact, but they do not diverge.
    assert!(apart.max < 2.0, "{apart:?}");
}
