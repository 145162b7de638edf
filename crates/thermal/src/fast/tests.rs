//! Steps on blocks and voxels together, which only large parts take, on small ones.

use beadwork_base::Control;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::explicit::{ExplicitStepper, Scheme};
use crate::material::ThermalMaterial;
use crate::patch::Shape;
use crate::process::ProcessParameters;
use crate::state::State;

const BIRTH_S: f64 = 1.0 / 60.0;

fn birth(at: [usize; 3], seconds: f64) -> Interval {
    Interval { held: Some(at), born: true, seconds, completes: None }
}

fn pause(seconds: f64) -> Interval {
    Interval { held: None, born: false, seconds, completes: None }
}

/// A zigzag through layers from which a corner may be missing, layer by layer.
fn zigzag(size: [usize; 3], filled: impl Fn([usize; 3]) -> bool) -> Vec<Vec<Interval>> {
    let layer = |z: usize| {
        let line = |y: usize| {
            let x = move |i: usize| if y.is_multiple_of(2) { i } else { size[0] + 1 - i };
            (1..=size[0]).map(move |i| [x(i), y, z])
        };
        (1..=size[1]).flat_map(line).filter(|&at| filled(at)).map(|at| birth(at, BIRTH_S)).collect()
    };
    (1..=size[2]).map(layer).collect()
}

/// Prints with steps on blocks from the first layer on, and with Heun's method; gives the
/// differences of both at the layers' ends: root of the mean square and largest.
fn errors(
    size: [usize; 3],
    process: &ProcessParameters,
    layers: &[Vec<Interval>],
    accuracy: Accuracy,
) -> [f64; 2] {
    let coefficients = Coefficients::new(&ThermalMaterial::abs(), process, 0.5e-3, 0.25e-3);
    let empty = State::empty(Shape::around(size[0], size[1], size[2]), &coefficients);
    let (mut long, mut short) = (empty.clone(), empty);
    let control = Control::default();
    let run = RunControl::new(&control, 0);
    let mut fast = FastStepper { many_voxels: 0, ..FastStepper::new(accuracy, &coefficients) };
    let mut heun = ExplicitStepper::new(Scheme::Heun { steps: 2 }, BIRTH_S);
    let (mut squares, mut count, mut most) = (0.0, 0_u32, 0.0_f64);
    for intervals in layers {
        fast.run(long.make_mut(), &coefficients, intervals, 1, &run).unwrap();
        heun.run(short.make_mut(), &coefficients, intervals, 1, &run).unwrap();
        for (index, theta) in long.patch.theta.iter().enumerate() {
            if long.occupancy.is_active(index) {
                let error = f64::from((theta - short.patch.theta[index]).abs());
                (squares, count, most) = (squares + error * error, count + 1, most.max(error));
            }
        }
    }
    [(squares / f64::from(count)).sqrt(), most]
}

#[test]
fn regions_are_as_exact_as_small_parts() {
    let size = [46, 42, 24];
    let corner = |[x, y, z]: [usize; 3]| x + y + 2 * z > 40;
    let cases: [&dyn Fn([usize; 3]) -> bool; 2] = [&|_| true, &corner];
    for (i, filled) in cases.into_iter().enumerate() {
        let layers = zigzag(size, filled);
        for (accuracy, most) in [(Accuracy::Standard, [0.06, 2.5]), (Accuracy::High, [0.03, 0.8])] {
            let reached = errors(size, &ProcessParameters::default(), &layers, accuracy);
            assert!(
                reached.iter().zip(most).all(|(error, most)| *error < most),
                "{i}, {accuracy:?}: {reached:?}"
            );
        }
    }
}

#[test]
fn pauses_and_jumps_of_large_parts() {
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
    for (accuracy, most) in [(Accuracy::Standard, [0.1, 2.5]), (Accuracy::High, [0.06, 1.0])] {
        let reached = errors(size, &ProcessParameters::default(), &layers, accuracy);
        assert!(
            reached.iter().zip(most).all(|(error, most)| *error < most),
            "{accuracy:?}: {reached:?}"
        );
    }
}

#[test]
fn nothing_is_lost_where_nothing_can_be() {
    let size = [50, 40, 20];
    let material = ThermalMaterial { emissivity: 0.0, ..ThermalMaterial::abs() };
    let process =
        ProcessParameters { plate_c: None, convection_w_m2k: 0.0, ..ProcessParameters::default() };
    let coefficients = Coefficients::new(&material, &process, 0.5e-3, 0.25e-3);
    let mut heats = Vec::new();
    let empty = State::empty(Shape::around(size[0], size[1], size[2]), &coefficients);
    let (mut long, mut short) = (empty.clone(), empty);
    let control = Control::default();
    let run = RunControl::new(&control, 0);
    let mut fast =
        FastStepper { many_voxels: 0, ..FastStepper::new(Accuracy::Standard, &coefficients) };
    let mut heun = ExplicitStepper::new(Scheme::Heun { steps: 2 }, BIRTH_S);
    for intervals in zigzag(size, |_| true) {
        fast.run(long.make_mut(), &coefficients, &intervals, 1, &run).unwrap();
        heun.run(short.make_mut(), &coefficients, &intervals, 1, &run).unwrap();
        heats = [&long, &short]
            .map(|state| state.patch.theta.iter().map(|&theta| f64::from(theta)).sum::<f64>())
            .to_vec();
    }
    // Heat in a held voxel is made, not kept: each scheme makes its own.
    assert!((heats[0] / heats[1] - 1.0).abs() < 5e-4, "{heats:?}");
}
