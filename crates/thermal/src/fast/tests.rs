//! Composite steps of blocks and voxels, which the stepper takes for large parts only, on small
//! parts.

use beadwork_base::Control;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::Accuracy;
use super::stepper::FastStepper;
use crate::coefficients::Coefficients;
use crate::explicit::{ExplicitStepper, Scheme};
use crate::interval::Interval;
use crate::material::ThermalMaterial;
use crate::process::ProcessParameters;
use crate::run_control::RunControl;
use crate::shape::Shape;
use crate::state::State;

const BIRTH_S: f64 = 1.0 / 60.0;

fn birth(position: [usize; 3], seconds: f64) -> Interval {
    Interval { held: Some(position), born: true, seconds, completes: None }
}

fn pause(seconds: f64) -> Interval {
    Interval { held: None, born: false, seconds, completes: None }
}

/// The births of a zigzag through each layer of a part.
fn zigzag(size: [usize; 3], filled: impl Fn([usize; 3]) -> bool) -> Vec<Vec<Interval>> {
    let layer = |z: usize| {
        let line = |y: usize| {
            let x = move |i: usize| if y.is_multiple_of(2) { i } else { size[0] + 1 - i };
            (1..=size[0]).map(move |i| [x(i), y, z])
        };
        (1..=size[1])
            .flat_map(line)
            .filter(|&position| filled(position))
            .map(|position| birth(position, BIRTH_S))
            .collect()
    };
    (1..=size[2]).map(layer).collect()
}

/// A stepper that takes steps on blocks for parts of any size.
fn with_blocks(accuracy: Accuracy, coefficients: &Coefficients) -> FastStepper {
    let mut stepper = FastStepper::new(accuracy, coefficients);
    stepper.min_block_voxels = 0;
    stepper
}

/// Prints a part with steps on blocks from the first layer on, and with Heun's method, and returns
/// the root mean square and the maximum of their differences at the ends of all layers, K.
fn errors(
    size: [usize; 3],
    process: &ProcessParameters,
    layers: &[Vec<Interval>],
    accuracy: Accuracy,
) -> [f64; 2] {
    let coefficients = Coefficients::new(&ThermalMaterial::abs(), process, 0.5e-3, 0.25e-3);
    let empty = State::unprinted(Shape::with_halo(size[0], size[1], size[2]), &coefficients);
    let (mut long, mut short) = (empty.clone(), empty);
    let mut fast = with_blocks(accuracy, &coefficients);
    let mut heun = ExplicitStepper::new(Scheme::Heun { steps: 2 }, BIRTH_S);
    let (mut squares, mut count, mut max) = (0.0, 0_u32, 0.0_f64);
    let control = Control::default();
    let run = RunControl::new(&control, 0);
    for intervals in layers {
        fast.run(long.make_mut(), &coefficients, intervals, 1, &run).unwrap();
        heun.run(short.make_mut(), &coefficients, intervals, 1, &run).unwrap();
        for (index, theta) in long.patch.theta.iter().enumerate() {
            if long.occupancy.is_active(index) {
                let error = f64::from((theta - short.patch.theta[index]).abs());
                (squares, count, max) = (squares + error * error, count + 1, max.max(error));
            }
        }
    }
    [(squares / f64::from(count)).sqrt(), max]
}

#[test]
fn regions_are_as_accurate_as_windows_of_small_parts() {
    let size = [46, 42, 24];
    let corner = |[x, y, z]: [usize; 3]| x + y + 2 * z > 40;
    let cases: [&dyn Fn([usize; 3]) -> bool; 2] = [&|_| true, &corner];
    for (i, filled) in cases.into_iter().enumerate() {
        let layers = zigzag(size, filled);
        for (accuracy, limits) in [(Accuracy::Standard, [0.06, 2.5]), (Accuracy::High, [0.03, 0.8])]
        {
            let errors = errors(size, &ProcessParameters::default(), &layers, accuracy);
            assert!(
                errors.iter().zip(limits).all(|(error, limit)| *error < limit),
                "{i}, {accuracy:?}: {errors:?}"
            );
        }
    }
}

#[test]
fn pauses_and_jumps_stay_accurate_with_regions() {
    let size = [46, 40, 12];
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut layers = zigzag(size, |_| true);
    for (z, layer) in layers.iter_mut().enumerate() {
        match z % 4 {
            // Blocks of a few lines, in any order.
            1 => {
                let mut parts: Vec<Vec<Interval>> =
                    layer.chunks(200).map(<[Interval]>::to_vec).collect();
                parts.shuffle(&mut random);
                *layer = parts.concat();
            }
            2 => {
                for i in (0..layer.len()).step_by(450) {
                    layer.insert(i, pause(random.random_range(0.1..30.0)));
                }
            }
            3 => layer.push(pause(200.0)),
            _ => {}
        }
    }
    for (accuracy, limits) in [(Accuracy::Standard, [0.1, 2.5]), (Accuracy::High, [0.06, 1.0])] {
        let errors = errors(size, &ProcessParameters::default(), &layers, accuracy);
        assert!(
            errors.iter().zip(limits).all(|(error, limit)| *error < limit),
            "{accuracy:?}: {errors:?}"
        );
    }
}

#[test]
fn insulated_part_keeps_its_heat() {
    let size = [50, 40, 20];
    let material = ThermalMaterial { emissivity: 0.0, ..ThermalMaterial::abs() };
    let process =
        ProcessParameters { plate_c: None, convection_w_m2k: 0.0, ..ProcessParameters::default() };
    let coefficients = Coefficients::new(&material, &process, 0.5e-3, 0.25e-3);
    let mut heats = Vec::new();
    let empty = State::unprinted(Shape::with_halo(size[0], size[1], size[2]), &coefficients);
    let (mut long, mut short) = (empty.clone(), empty);
    let mut fast = with_blocks(Accuracy::Standard, &coefficients);
    let mut heun = ExplicitStepper::new(Scheme::Heun { steps: 2 }, BIRTH_S);
    let control = Control::default();
    let run = RunControl::new(&control, 0);
    for intervals in zigzag(size, |_| true) {
        fast.run(long.make_mut(), &coefficients, &intervals, 1, &run).unwrap();
        heun.run(short.make_mut(), &coefficients, &intervals, 1, &run).unwrap();
        heats = [&long, &short]
            .map(|state| state.patch.theta.iter().map(|&theta| f64::from(theta)).sum::<f64>())
            .to_vec();
    }
    // Holding a voxel at its temperature adds heat, and each scheme adds a slightly different
    // amount.
    assert!((heats[0] / heats[1] - 1.0).abs() < 5e-4, "{heats:?}");
}
