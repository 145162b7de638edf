//! Sweeps of different layouts and on different numbers of threads give the same bits.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::stages::{SweepParameters, TwoStageScheme};
use super::*;
use crate::coefficients::Coefficients;
use crate::material::ThermalMaterial;
use crate::patch::Patch;
use crate::process::ProcessParameters;
use crate::shape::Shape;
use crate::state::{State, StateMut};

/// A patch with random voxels at random temperatures, and perhaps the index of one that is held.
fn patch(
    size: [usize; 3],
    coefficients: &Coefficients,
    random: &mut Xoshiro256PlusPlus,
) -> (Patch, Option<usize>) {
    let mut state = State::unprinted(Shape::with_halo(size[0], size[1], size[2]), coefficients);
    let StateMut { patch, mut occupancy } = state.make_mut();
    let (mut changes, mut active) = (Vec::new(), Vec::new());
    // Only full boxes have uniform lines, so some of them are full.
    let filled = if random.random_bool(0.3) { 1.0 } else { random.random_range(0.5..1.0) };
    for z in 1..=size[2] {
        for y in 1..=size[1] {
            for x in (1..=size[0]).filter(|_| random.random_bool(filled)) {
                occupancy.birth([x, y, z], patch, coefficients, &mut changes);
                patch.apply(&changes, coefficients);
                changes.clear();
                active.push(patch.shape.index([x, y, z]));
            }
        }
    }
    active.iter().for_each(|&i| patch.theta[i] = random.random_range(0.0..200.0));
    let held = active.get(active.len() / 2).filter(|_| random.random_bool(0.5));
    (patch.clone(), held.copied())
}

fn bits(patch: &Patch) -> Vec<u32> {
    patch.theta.iter().map(|theta| theta.to_bits()).collect()
}

fn coefficient_sets() -> [Coefficients; 2] {
    [false, true].map(|surface_resistance| {
        let process = ProcessParameters { surface_resistance, ..ProcessParameters::default() };
        Coefficients::new(&ThermalMaterial::abs(), &process, 0.5e-3, 0.25e-3)
    })
}

const TAYLOR: Quadratic = Quadratic { a: 0.02, b: 0.0002 };
const TWO_STEPS: TwoSteps = TwoSteps { seconds: 0.02 };

fn flat_and_slab_sweeps_agree(scheme: impl TwoStageScheme, random: &mut Xoshiro256PlusPlus) {
    let (coefficient_sets, mut buffers) = (coefficient_sets(), SweepBuffers::default());
    for _ in 0..500 {
        let coefficients = &coefficient_sets[random.random_range(0..2)];
        let size = [40, 12, 9].map(|max| random.random_range(1..max));
        let (mut flat, held) = patch(size, coefficients, random);
        let (mut slabs, top) = (flat.clone(), size[2] + 1);
        for _ in 0..3 {
            let shape = slabs.shape;
            let parameters =
                |arrays| SweepParameters { coefficients, shape, arrays, scheme, held, top };
            parameters(&flat.arrays).sweep_flat(&mut flat.theta, &mut buffers);
            parameters(&slabs.arrays).sweep_slabs(&mut slabs.theta, &mut buffers);
        }
        assert_eq!(bits(&flat), bits(&slabs));
    }
}

#[test]
fn flat_sweeps_equal_slab_sweeps() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
    flat_and_slab_sweeps_agree(TAYLOR, &mut random);
    flat_and_slab_sweeps_agree(TWO_STEPS, &mut random);
}

#[test]
fn two_steps_equal_two_single_steps() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
    let (coefficient_sets, mut buffers) = (coefficient_sets(), SweepBuffers::default());
    for _ in 0..300 {
        let coefficients = &coefficient_sets[random.random_range(0..2)];
        let size = [70, 20, 12].map(|max| random.random_range(1..max));
        let (mut both, held) = patch(size, coefficients, &mut random);
        if let Some(held) = held {
            both.theta[held] = coefficients.birth_theta;
        }
        let (mut single, top) = (both.clone(), size[2] + 1);
        let TwoSteps { seconds } = TWO_STEPS;
        for _ in 0..2 {
            let mut to = single.theta.clone();
            let Patch { shape, arrays, theta: from, .. } = &single;
            dispatch(EulerSweep {
                coefficients,
                shape: *shape,
                arrays,
                from,
                to: &mut to,
                top,
                seconds,
            });
            if let Some(held) = held {
                to[held] = coefficients.birth_theta;
            }
            single.theta = to;
        }
        TwoStageSweep { coefficients, patch: &mut both, scheme: TWO_STEPS, held, top }
            .sweep(&mut buffers);
        assert_eq!(bits(&both), bits(&single));
    }
}

fn thread_counts_agree(scheme: impl TwoStageScheme, random: &mut Xoshiro256PlusPlus) {
    let [coefficients, _] = coefficient_sets();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for size in [[100, 40, 70], [60, 150, 40], [30, 9, 900]] {
        let (patch, held) = patch(size, &coefficients, random);
        let sweep = |mut patch: Patch, threads: usize| {
            let mut buffers = SweepBuffers { threads, ..SweepBuffers::default() };
            for _ in 0..3 {
                let (patch, top) = (&mut patch, size[2] + 1);
                TwoStageSweep { coefficients: &coefficients, patch, scheme, held, top }
                    .sweep(&mut buffers);
            }
            (bits(&patch), buffers.rings.len())
        };
        let (alone, one) = sweep(patch.clone(), 1);
        for threads in 2..=5 {
            let (shared, slabs) = pool.install(|| sweep(patch.clone(), threads));
            assert!(one == 1 && slabs > 1, "the part is large enough for two");
            assert_eq!(shared, alone);
        }
    }
}

#[test]
fn thread_count_does_not_change_a_bit() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
    thread_counts_agree(TAYLOR, &mut random);
    thread_counts_agree(TWO_STEPS, &mut random);
}
