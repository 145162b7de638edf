//! The fast code's plain methods against the definition, and the definition's own balance.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod common;

use beadwork_thermal::plain::Scheme;
use beadwork_thermal::{Method, Slot};
use common::{Print, Random, difference, field, plain_field, random_slots, uneven};

/// Small prints of all kinds.
fn prints(seeds: u64) -> impl Iterator<Item = Print> {
    (0..seeds).map(|seed| {
        let mut random = Random::new(seed);
        let mut print = Print::random(&mut random, [9, 8, 6]);
        print.slots = uneven(&mut random, print.slots, 1.0, 1.5);
        print
    })
}

#[test]
fn no_heat_is_lost_or_made() {
    for print in prints(100) {
        for scheme in [Scheme::Euler, Scheme::Heun { steps: 2 }] {
            let mut plain = print.run_plain(scheme);
            // Measured: 4e-15.
            assert!(plain.imbalance() <= 1e-12, "{scheme:?}: {}", plain.imbalance());
            plain.run(&[Slot::pause(2.0)]);
            assert!(plain.imbalance() <= 1e-12, "{scheme:?}, later: {}", plain.imbalance());
        }
    }
}

#[test]
fn the_naive_method_is_the_definition() {
    for (seed, print) in prints(150).enumerate() {
        let naive = print.run(Method::Naive);
        let plain = print.run_plain(Scheme::Euler);
        let apart = difference(&field(&naive), &plain_field(&print.part, &plain));
        // Measured: 3e-4.
        assert!(apart.max < 1e-3, "print {seed}: {apart:?}");
        let drift = (naive.stored_j() - plain.stored_j()).abs() / plain.energy().moved_j;
        assert!(drift < 2e-6, "print {seed}: {drift}");
        assert!((naive.seconds() - plain.seconds()).abs() < 1e-9);
    }
}

#[test]
fn the_reference_is_heuns_method() {
    for (seed, print) in prints(120).enumerate() {
        let steps = 1 + seed as u32 % 4;
        let reference = print.run(Method::Reference { steps });
        let plain = print.run_plain(Scheme::Heun { steps });
        let apart = difference(&field(&reference), &plain_field(&print.part, &plain));
        // Measured: 3e-3, which is f32's rounding in so many steps.
        assert!(apart.max < 6e-3, "print {seed}, {steps} steps: {apart:?}");
    }
}

#[test]
fn larger_parts_too() {
    let mut random = Random::new(77);
    for width in [15, 31, 47] {
        // 16 numbers make a cache line, and two of a row are rim.
        let part = common::block(width, 5, 4);
        let mut print = Print::paper(&mut random, part);
        print.process.surface_resistance = width == 31;
        print.slots = random_slots(&mut random, &print.part, &print.process);
        let apart = difference(
            &field(&print.run(Method::Naive)),
            &plain_field(&print.part, &print.run_plain(Scheme::Euler)),
        );
        assert!(apart.max < 2e-3, "{width}: {apart:?}");
    }
}

/// Four steps a birth are enough to measure others by: eight change nothing that matters.
#[test]
fn the_reference_converges() {
    for seed in 0..8 {
        let mut random = Random::new(seed);
        let part = common::random_part(&mut random, [24, 20, 4]);
        let print = Print::paper(&mut random, part);
        let of = |steps| field(&print.run(Method::Reference { steps }));
        let [one, two, four, eight] = [1, 2, 4, 8].map(of);
        let apart = difference(&four, &eight);
        assert!(apart.max < 0.02 && apart.rms < 0.003, "{seed}: {apart:?}");
        let (first, second) = (difference(&one, &two), difference(&two, &four));
        assert!(first.max > 2.5 * second.max, "{seed}: {first:?} {second:?}");
    }
}

/// A birth much longer than the others, and a print so slow that one step a birth is not stable.
#[test]
fn the_reference_is_stable_at_any_speed() {
    let mut random = Random::new(9);
    let mut print = Print::paper(&mut random, common::block(8, 6, 3));
    for slot in print.slots.iter_mut().step_by(17) {
        slot.seconds = 3.0;
    }
    let apart = difference(
        &field(&print.run(Method::Reference { steps: 1 })),
        &plain_field(&print.part, &print.run_plain(Scheme::Heun { steps: 1 })),
    );
    assert!(apart.max < 5e-3, "{apart:?}");
    print.process.print_mm_s = 1.0;
    print.slots = random_slots(&mut random, &print.part, &print.process);
    let apart = difference(
        &field(&print.run(Method::Reference { steps: 1 })),
        &plain_field(&print.part, &print.run_plain(Scheme::Heun { steps: 32 })),
    );
    // Steps as long as stable ones may be are not exact, but they do not run away.
    assert!(apart.max < 2.0, "{apart:?}");
}
