//! Sums, conductances and interpolation against slow ones, and smooth differences against short
//! steps.

use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::super::chebyshev::Polynomial;
use super::*;
use crate::kernel::{Quadratic, SweepBuffers, TwoStageSweep};
use crate::material::ThermalMaterial;
use crate::patch::Shape;
use crate::process::ProcessParameters;
use crate::state::State;

fn places(size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [x, y, z] = size;
    (1..=z).flat_map(move |z| (1..=y).flat_map(move |y| (1..=x).map(move |x| [x, y, z])))
}

/// Voxels at temperatures above the air; `None` where there is none.
fn printed(
    size: [usize; 3],
    coefficients: &Coefficients,
    mut theta: impl FnMut([usize; 3]) -> Option<f64>,
) -> State {
    let mut state = State::empty(Shape::around(size[0], size[1], size[2]), coefficients);
    let mut changes = Vec::new();
    let state_mut = state.make_mut();
    let mut voxels = state_mut.voxels;
    for at in places(size) {
        if let Some(theta) = theta(at) {
            voxels.birth(at, state_mut.patch, coefficients, &mut changes);
            state_mut.patch.apply(&changes, coefficients);
            changes.clear();
            let index = state_mut.patch.shape.index(at);
            state_mut.patch.theta[index] = theta as f32;
        }
    }
    state
}

/// Nothing is lost.
fn insulated() -> Coefficients {
    let material = ThermalMaterial { emissivity: 0.0, ..ThermalMaterial::abs() };
    let process =
        ProcessParameters { plate_c: None, convection_w_m2k: 0.0, ..ProcessParameters::default() };
    Coefficients::new(&material, &process, 0.5e-3, 0.25e-3)
}

fn heat(state: &State) -> f64 {
    state.patch.theta[..].iter().map(|&theta| f64::from(theta)).sum()
}

/// A random part with everything that heat can do.
fn random_state(random: &mut Xoshiro256PlusPlus) -> (State, Coefficients) {
    let process = ProcessParameters {
        plate_c: random.random_bool(0.7).then_some(80.0),
        surface_resistance: random.random_bool(0.5),
        ..ProcessParameters::default()
    };
    let coefficients = Coefficients::new(&ThermalMaterial::abs(), &process, 0.5e-3, 0.25e-3);
    let size = [0, 1, 2].map(|axis: usize| random.random_range(2..[50, 12, 14][axis]));
    let filled = random.random_range(0.5..1.0);
    let state = printed(size, &coefficients, |_| {
        random.random_bool(filled).then(|| random.random_range(10.0..200.0))
    });
    (state, coefficients)
}

/// A random region, and the window into it.
fn random_region(random: &mut Xoshiro256PlusPlus, state: &State) -> (Region, Patch) {
    let block_grid = state.occupancy.block_grid();
    let whole = Region::whole(block_grid, state.top);
    let mut region = whole;
    for axis in 1..3 {
        region.low[axis] = random.random_range(whole.low[axis]..whole.high[axis]);
        region.high[axis] = random.random_range(region.low[axis] + 1..=whole.high[axis]);
    }
    let mut patch = Patch::default();
    patch.copy_window(region.window(block_grid, state.patch.shape), &state.patch);
    (region, patch)
}

#[test]
fn blocks_hear_what_voxels_lose() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    for _ in 0..300 {
        let (state, coefficients) = random_state(&mut random);
        let block_grid = state.occupancy.block_grid();
        let (region, patch) = random_region(&mut random, &state);
        let mut sums = BlockSums::default();
        sums.reset(block_grid.shape.len());
        sums.take(&patch, region, block_grid, &coefficients, state.top);
        let size = [state.patch.shape.row, state.patch.shape.planes, state.patch.shape.rows]
            .map(|n| n - 2);
        let mut slow = vec![[0.0_f64; 2]; block_grid.shape.len()];
        for at in places(size) {
            let index = state.patch.shape.index(at);
            if !state.occupancy.is_active(index) {
                continue;
            }
            let theta = f64::from(state.patch.theta[index]);
            let voxel = coefficients.by_faces[usize::from(state.occupancy.faces()[index])];
            let lost = f64::from(coefficients.surface_loss(
                theta as f32,
                voxel.exposed_area,
                voxel.top_bottom_area,
            ));
            let plate = if coefficients.plate_conducts && at[2] == 1 {
                f64::from(coefficients.vertical)
                    * (f64::from(coefficients.plate_ghost) - 2.0 * theta)
            } else {
                0.0
            };
            let block = &mut slow[block_grid.block(at)];
            *block = [block[0] + theta, block[1] + plate - lost];
        }
        for i in region.blocks(block_grid) {
            let [theta, gain] = slow[i];
            assert!(
                (f64::from(sums.theta[i]) - theta).abs() < 1e-2,
                "{} and {theta}",
                sums.theta[i]
            );
            assert!((f64::from(sums.gains[i]) - gain).abs() < 1e-5 * gain.abs().max(100.0));
        }
    }
}

/// Radiation and convection of one voxel, as the sweeps have it: rates with and without them.
#[test]
fn the_air_takes_what_the_sweeps_take() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    for resistance in [false, true] {
        let process = ProcessParameters {
            plate_c: None,
            surface_resistance: resistance,
            ..ProcessParameters::default()
        };
        let coefficients = Coefficients::new(&ThermalMaterial::abs(), &process, 0.5e-3, 0.25e-3);
        for _ in 0..100 {
            let warm = random.random_range(1.0..200.0);
            let mut state = printed([1, 1, 1], &coefficients, |_| Some(warm));
            let index = state.patch.shape.index([1, 1, 1]);
            let voxel = coefficients.by_faces[usize::from(state.occupancy.faces()[index])];
            let top = state.top;
            let patch = state.make_mut().patch;
            let mut memory = SweepBuffers::default();
            let seconds = 1e-2;
            let stages = Quadratic { a: seconds, b: 0.0 };
            TwoStageSweep { coefficients: &coefficients, patch, stages, held: None, top }
                .sweep(&mut memory);
            let lost =
                coefficients.surface_loss(warm as f32, voxel.exposed_area, voxel.top_bottom_area);
            let swept = (warm as f32 - patch.theta[index]) / seconds;
            assert!((swept / lost - 1.0).abs() < 2e-2, "{swept} and {lost}");
        }
    }
}

#[test]
fn conductances_do_not_depend_on_the_region_they_are_taken_in() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    for i in 0..200 {
        let (state, coefficients) = if i % 4 == 0 {
            let coefficients = insulated();
            (printed([30, 12, 16], &coefficients, |_| Some(50.0)), coefficients)
        } else {
            random_state(&mut random)
        };
        let block_grid = state.occupancy.block_grid();
        let theta = vec![40.0; block_grid.shape.len()];
        let [mut whole, mut parts] = [(); 2].map(|()| BlockConductances::default());
        whole.reset(block_grid.shape.len());
        parts.reset(block_grid.shape.len());
        whole.weigh(Region::whole(block_grid, state.top), block_grid, &coefficients, &theta);
        let (region, _) = random_region(&mut random, &state);
        parts.weigh(region, block_grid, &coefficients, &theta);
        let strides = block_grid.strides();
        for i in region.blocks(block_grid) {
            assert_eq!((whole.share[i], whole.losses[i]), (parts.share[i], parts.losses[i]));
            for (axis, stride) in strides.into_iter().enumerate() {
                let links = |conduction: &BlockConductances| {
                    [i, i - stride].map(|i| conduction.links[axis][i].to_bits())
                };
                assert_eq!(links(&whole), links(&parts));
            }
        }
    }
}

#[test]
fn each_block_gets_its_mean_and_planes_stay_planes() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
    let coefficients = insulated();
    for _ in 0..100 {
        let size = [0, 1, 2].map(|axis: usize| random.random_range(8..[50, 20, 24][axis]));
        let state = printed(size, &coefficients, |_| Some(0.0));
        let block_grid = state.occupancy.block_grid();
        let slope = [0; 3].map(|_: usize| random.random_range(-2.0..2.0));
        let plane = |at: [f64; 3]| (0..3).map(|axis| slope[axis] * at[axis]).sum::<f64>();
        let mut far = FarField::default();
        far.begin(&state.patch, block_grid, &coefficients, state.top);
        let blocks = |axis: usize| (size[axis]).div_ceil(block_grid.coarsening[axis]);
        let mut numbers = vec![0.0; block_grid.shape.len()];
        for block in places([blocks(0), blocks(1), blocks(2)]) {
            let middle =
                |axis: usize| (block[axis] as f64 - 0.5) * block_grid.coarsening[axis] as f64 + 0.5;
            numbers[block_grid.shape.index(block)] =
                plane([middle(0), middle(1), middle(2)]) as f32;
        }
        far.theta.iter_mut().zip(&numbers).for_each(|(theta, number)| *theta += number);
        let (region, mut patch) = random_region(&mut random, &state);
        far.add(2.0, &mut patch, region, block_grid, &coefficients);
        let mut sums = vec![0.0; block_grid.shape.len()];
        for at in places(size) {
            let Some(index) = patch.index(at) else { continue };
            sums[block_grid.block(at)] += f64::from(patch.theta[index]);
            // Inside, where all blocks beside are full.
            let inside = (0..3).all(|axis| {
                let block = (at[axis] - 1) / block_grid.coarsening[axis];
                block > 0 && (block + 2) * block_grid.coarsening[axis] <= size[axis]
            });
            if inside {
                let wanted = 2.0 * plane(at.map(|i| i as f64));
                assert!((f64::from(patch.theta[index]) - wanted).abs() < 2e-3, "{at:?}: {wanted}");
            }
        }
        for i in region.blocks(block_grid).filter(|&i| block_grid.blocks[i].voxels > 0) {
            let mean = sums[i] / f64::from(block_grid.blocks[i].voxels);
            assert!((mean - 2.0 * f64::from(numbers[i])).abs() < 1e-3, "{mean} and {}", numbers[i]);
        }
    }
}

#[test]
fn what_crosses_the_border_of_a_region_is_what_its_window_loses() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let coefficients = insulated();
    for _ in 0..100 {
        let mut state = printed([60, 14, 20], &coefficients, |_| {
            random.random_bool(0.97).then(|| 100.0 + random.random_range(0.0..20.0))
        });
        let (region, _) = random_region(&mut random, &state);
        let (top, block_grid) = (state.top, state.occupancy.block_grid().clone());
        let mut far = FarField::default();
        far.begin(&state.patch, &block_grid, &coefficients, top);
        let mut window = Patch::default();
        window.copy_window(region.window(&block_grid, state.patch.shape), &state.patch);
        let halo = FluxHalo::close(&mut window, &state.patch, region, &block_grid, &coefficients);
        let inside = |patch: &Patch| -> f64 {
            let places = places([60, 14, 20]);
            places.filter_map(|at| patch.index(at)).map(|i| f64::from(patch.theta[i])).sum()
        };
        let blocks = |far: &FarField| -> f64 {
            region
                .blocks(&block_grid)
                .map(|i| f64::from(far.theta[i]) * f64::from(block_grid.blocks[i].voxels))
                .sum()
        };
        let (before, blocks_before) = (inside(&window), blocks(&far));
        let border: Vec<_> = region.border(&block_grid).collect();
        let flows = far.step(2.0, &border, &block_grid, &coefficients, top);
        halo.set(&mut window, &flows);
        let own_top = (top - window.origin[2]).min(window.shape.rows - 1);
        let mut memory = SweepBuffers::default();
        for _ in 0..40 {
            let stages = Quadratic { a: 0.05, b: 0.05 * 0.05 / 2.0 };
            let patch = &mut window;
            TwoStageSweep { coefficients: &coefficients, patch, stages, held: None, top: own_top }
                .sweep(&mut memory);
        }
        let (gained, coarse) = (inside(&window) - before, blocks(&far) - blocks_before);
        assert!((gained - coarse).abs() < 2e-5 * before, "{gained} and {coarse} of {before}");
        // And outside, blocks have the opposite.
        let all = Region::whole(&block_grid, top);
        let total: f64 = all
            .blocks(&block_grid)
            .map(|i| f64::from(far.theta[i]) * f64::from(block_grid.blocks[i].voxels))
            .sum();
        assert!((total / heat(&state) - 1.0).abs() < 1e-5);
        far.end(state.make_mut().patch, &block_grid, &coefficients, top);
        assert!((total / heat(&state) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_smooth_difference_evens_out_as_it_does_in_short_steps() {
    // The slowest mode of a bar along each axis in turn, blocks at whose ends are filled in part.
    let size = [31, 27, 30];
    let coefficients = insulated();
    for axis in 0..3 {
        let length = size[axis] as f64;
        let mode = |at: [usize; 3]| 100.0 + 20.0 * (PI * (at[axis] as f64 - 0.5) / length).cos();
        let mut long = printed(size, &coefficients, |at| Some(mode(at)));
        let mut short = long.clone();
        let (seconds, before) = (15.0, heat(&long));
        let (top, block_grid) = (long.top, long.occupancy.block_grid().clone());
        let mut far = FarField::default();
        far.begin(&long.patch, &block_grid, &coefficients, top);
        far.step(seconds, &[], &block_grid, &coefficients, top);
        far.end(long.make_mut().patch, &block_grid, &coefficients, top);
        let dt = 0.05;
        let mut memory = SweepBuffers::default();
        for _ in 0..(seconds / dt).round() as usize {
            let patch = short.make_mut().patch;
            let stages = Quadratic { a: dt as f32, b: (dt * dt / 2.0) as f32 };
            TwoStageSweep { coefficients: &coefficients, patch, stages, held: None, top }
                .sweep(&mut memory);
        }
        let error = long.patch.theta[..].iter().zip(&short.patch.theta[..]);
        let error = error.map(|(long, short)| (long - short).abs()).fold(0.0, f32::max);
        // Second order in the blocks' size: of the mode along z, whose bar is seven blocks long,
        // this is the most.
        assert!(error < [0.05, 0.05, 0.5][axis], "axis {axis}: {error}");
        let lost = heat(&long) / before - 1.0;
        assert!(lost.abs() < 3e-6, "axis {axis}: {lost} of the heat is lost");
    }
}

/// Stage after stage, each of all blocks.
fn evolve_slowly(
    conduction: &BlockConductances,
    w: &mut [f32],
    rates: &[f32],
    seconds: f64,
    block_grid: &BlockGrid,
    layers: usize,
    crossings: &mut [BorderFlow],
) {
    let [sx, sy, sz] = block_grid.strides();
    let [x, y, z] = &conduction.links;
    let flow = |w: &[f32], i: usize| {
        let to = |link: f32, next: usize| link * (w[next] - w[i]);
        let in_x = to(x[i - sx], i - sx) + to(x[i], i + sx);
        let in_y = to(y[i - sy], i - sy) + to(y[i], i + sy);
        let in_z = to(z[i - sz], i - sz) + to(z[i], i + sz);
        (in_x + in_y + in_z - conduction.losses[i] * w[i]) * conduction.share[i]
    };
    let all: Vec<_> = places([block_grid.shape.row - 2, block_grid.shape.planes - 2, layers])
        .map(|at| block_grid.shape.index(at))
        .collect();
    for factor in &Polynomial::reaching(seconds * f64::from(conduction.max_rate)).factors {
        let [a, b] = [factor.a * seconds, factor.b * seconds * seconds].map(|number| number as f32);
        let mut slope = vec![0.0; w.len()];
        all.iter().for_each(|&i| slope[i] = flow(w, i) + rates[i]);
        for BorderFlow { from, to, link, sum } in &mut *crossings {
            *sum += *link * (a * (w[*from] - w[*to]) + b * (slope[*from] - slope[*to]));
        }
        all.iter().for_each(|&i| w[i] = w[i] + b * flow(&slope, i) + a * slope[i]);
    }
}

#[test]
fn stages_that_share_the_planes_do_what_they_do_one_after_the_other() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
    // Kept from case to case, as from step to step.
    let mut evolution = BlockStepper::default();
    for _ in 0..1000 {
        let (state, coefficients) = random_state(&mut random);
        let (block_grid, top) = (state.occupancy.block_grid(), state.top);
        let (len, layers) = (block_grid.shape.len(), block_grid.layers(top));
        let mut known: Vec<f32> = vec![0.0; len];
        let mut rates = known.clone();
        for i in Region::whole(block_grid, top)
            .blocks(block_grid)
            .filter(|&i| block_grid.blocks[i].voxels > 0)
        {
            (known[i], rates[i]) =
                (random.random_range(0.0..200.0), random.random_range(-5.0..5.0));
        }
        let mut conduction = BlockConductances::default();
        conduction.reset(len);
        conduction.weigh(Region::whole(block_grid, top), block_grid, &coefficients, &known);
        let (region, _) = random_region(&mut random, &state);
        let crossing = |BorderPair { axis, inside, outside }: BorderPair| {
            let link = conduction.links[axis][inside.min(outside)];
            BorderFlow { from: inside, to: outside, link, sum: 0.0 }
        };
        let crossings: Vec<_> = region.border(block_grid).map(crossing).collect();
        let seconds = 10.0_f64.powf(random.random_range(-2.0..1.5));
        let mut ways = [known.clone(), known].map(|theta| (theta, crossings.clone()));
        let [(theta, crossings), (slow_theta, slow_crossings)] = &mut ways;
        evolution.advance(&conduction, theta, &rates, seconds, block_grid, layers, crossings);
        evolve_slowly(&conduction, slow_theta, &rates, seconds, block_grid, layers, slow_crossings);
        assert_eq!(theta, slow_theta);
        let sums = |crossings: &[BorderFlow]| {
            crossings.iter().map(|crossing| crossing.sum).collect::<Vec<_>>()
        };
        assert_eq!(sums(crossings), sums(slow_crossings));
    }
}

#[test]
fn blocks_without_voxels_get_the_means_of_those_beside_them() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    for _ in 0..1000 {
        let (state, coefficients) = random_state(&mut random);
        let (block_grid, shape) =
            (state.occupancy.block_grid(), state.occupancy.block_grid().shape);
        let filled = random.random_range(0.0..1.0);
        let known: Vec<bool> = block_grid
            .blocks
            .iter()
            .map(|block| block.voxels > 0 && random.random_bool(filled))
            .collect();
        let numbers: Vec<f32> = known
            .iter()
            .map(|&known| f32::from(u8::from(known)) * random.random::<f32>())
            .collect();
        let (region, _) = random_region(&mut random, &state);
        let (mut extended, mut after) = (numbers.clone(), known.clone());
        interpolation::extend(&mut extended, &mut after, region, block_grid, &coefficients);
        assert_eq!(after, known);
        let (mut slow, mut known) = (numbers, known);
        let around = |at: [usize; 3]| {
            (0..3).all(|i| (region.low[i].saturating_sub(3)..region.high[i] + 3).contains(&at[i]))
        };
        let all = (0..shape.rows).flat_map(|z| {
            (0..shape.planes).flat_map(move |y| (0..shape.row).map(move |x| [x, y, z]))
        });
        let all: Vec<_> = all.filter(|&at| around(at)).map(|at| shape.index(at)).collect();
        for _ in 0..3 {
            let (before, known_before) = (slow.clone(), known.clone());
            for &i in all.iter().filter(|&&i| !known_before[i]) {
                let beside = block_grid
                    .strides()
                    .into_iter()
                    .flat_map(|stride| [i.wrapping_sub(stride), i + stride]);
                let near: Vec<_> = beside
                    .filter(|&i| known_before.get(i) == Some(&true))
                    .map(|i| before[i])
                    .collect();
                if !near.is_empty() {
                    (slow[i], known[i]) = (near.iter().sum::<f32>() / near.len() as f32, true);
                }
            }
        }
        let plate =
            |i: &usize| coefficients.plate_conducts && (i / shape.row).is_multiple_of(shape.rows);
        for i in all {
            let slow = if plate(&i) { -slow[i + shape.row] } else { slow[i] };
            assert!((extended[i] - slow).abs() < 1e-6, "{} and {slow}", extended[i]);
        }
    }
}
