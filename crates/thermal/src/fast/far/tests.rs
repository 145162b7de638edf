//! The far field as a whole: conservation of heat, interpolation, and smooth changes against steps
//! on voxels.

use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::testing::{heat, insulated, positions, printed, random_region};
use super::{FarField, FluxHalo, Region};
use crate::kernel::{Quadratic, SweepBuffers, TwoStageSweep};
use crate::patch::Patch;

#[test]
fn heat_across_the_border_of_a_region_is_what_its_window_loses() {
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
            let indices = positions([60, 14, 20]).filter_map(|position| patch.index(position));
            indices.map(|i| f64::from(patch.theta[i])).sum()
        };
        let blocks = |far: &FarField, region: Region| -> f64 {
            region
                .blocks(&block_grid)
                .map(|i| f64::from(far.theta[i]) * f64::from(block_grid.blocks[i].voxels))
                .sum()
        };
        let (before, blocks_before) = (inside(&window), blocks(&far, region));
        let border: Vec<_> = region.border(&block_grid).collect();
        let fluxes = far.step(2.0, &border, &block_grid, &coefficients, top);
        halo.set(&mut window, &fluxes);
        let window_top = (top - window.origin[2]).min(window.shape.rows - 1);
        let mut buffers = SweepBuffers::default();
        for _ in 0..40 {
            TwoStageSweep {
                coefficients: &coefficients,
                patch: &mut window,
                scheme: Quadratic { a: 0.05, b: 0.05 * 0.05 / 2.0 },
                held: None,
                top: window_top,
            }
            .sweep(&mut buffers);
        }
        let (fine, coarse) = (inside(&window) - before, blocks(&far, region) - blocks_before);
        assert!((fine - coarse).abs() < 2e-5 * before, "{fine} and {coarse} of {before}");
        // The blocks outside have the opposite, since all blocks together lose nothing.
        let total = blocks(&far, Region::whole(&block_grid, top));
        assert!((total / heat(&state) - 1.0).abs() < 1e-5);
        far.end(state.make_mut().patch, &block_grid, &coefficients, top);
        assert!((total / heat(&state) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn smooth_differences_decay_as_in_short_steps_on_voxels() {
    // The slowest mode of a bar along each axis in turn; its last blocks are partly filled.
    let size = [31, 27, 30];
    let coefficients = insulated();
    for axis in 0..3 {
        let length = size[axis] as f64;
        let mode = |position: [usize; 3]| {
            100.0 + 20.0 * (PI * (position[axis] as f64 - 0.5) / length).cos()
        };
        let mut long = printed(size, &coefficients, |position| Some(mode(position)));
        let mut short = long.clone();
        let (seconds, before) = (15.0, heat(&long));
        let (top, block_grid) = (long.top, long.occupancy.block_grid().clone());
        let mut far = FarField::default();
        far.begin(&long.patch, &block_grid, &coefficients, top);
        far.step(seconds, &[], &block_grid, &coefficients, top);
        far.end(long.make_mut().patch, &block_grid, &coefficients, top);
        let dt = 0.05;
        let mut buffers = SweepBuffers::default();
        for _ in 0..(seconds / dt).round() as usize {
            let patch = short.make_mut().patch;
            let scheme = Quadratic { a: dt as f32, b: (dt * dt / 2.0) as f32 };
            TwoStageSweep { coefficients: &coefficients, patch, scheme, held: None, top }
                .sweep(&mut buffers);
        }
        let error = long.patch.theta[..].iter().zip(&short.patch.theta[..]);
        let error = error.map(|(long, short)| (long - short).abs()).fold(0.0, f32::max);
        // Second order in the size of blocks; along z the bar is only seven blocks long.
        assert!(error < [0.05, 0.05, 0.5][axis], "axis {axis}: {error}");
        let lost = heat(&long) / before - 1.0;
        assert!(lost.abs() < 3e-6, "axis {axis}: {lost} of the heat is lost");
    }
}

#[test]
fn means_of_blocks_are_kept_and_linear_functions_are_exact() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
    let coefficients = insulated();
    for _ in 0..100 {
        let size = [0, 1, 2].map(|axis: usize| random.random_range(8..[50, 20, 24][axis]));
        let state = printed(size, &coefficients, |_| Some(0.0));
        let block_grid = state.occupancy.block_grid();
        let slope = [0; 3].map(|_: usize| random.random_range(-2.0..2.0));
        let linear = |at: [f64; 3]| (0..3).map(|axis| slope[axis] * at[axis]).sum::<f64>();
        let mut far = FarField::default();
        far.begin(&state.patch, block_grid, &coefficients, state.top);
        let factors = block_grid.coarsening;
        let blocks = [0, 1, 2].map(|axis: usize| size[axis].div_ceil(factors[axis]));
        let mut numbers = vec![0.0; block_grid.shape.len()];
        for block in positions(blocks) {
            let centre = [0, 1, 2]
                .map(|axis: usize| (block[axis] as f64 - 0.5) * factors[axis] as f64 + 0.5);
            numbers[block_grid.shape.index(block)] = linear(centre) as f32;
        }
        far.theta.iter_mut().zip(&numbers).for_each(|(theta, number)| *theta += number);
        let (region, mut patch) = random_region(&mut random, &state);
        far.add_change(2.0, &mut patch, region, block_grid, &coefficients);
        let mut sums = vec![0.0; block_grid.shape.len()];
        for position in positions(size) {
            let Some(index) = patch.index(position) else { continue };
            let theta = f64::from(patch.theta[index]);
            sums[block_grid.block_of(position)] += theta;
            // Inside, where all neighbouring blocks are full.
            let inside = (0..3).all(|axis| {
                let block = (position[axis] - 1) / factors[axis];
                block > 0 && (block + 2) * factors[axis] <= size[axis]
            });
            if inside {
                let expected = 2.0 * linear(position.map(|i| i as f64));
                assert!((theta - expected).abs() < 2e-3, "{position:?}: {expected}");
            }
        }
        for i in region.blocks(block_grid).filter(|&i| block_grid.blocks[i].voxels > 0) {
            let mean = sums[i] / f64::from(block_grid.blocks[i].voxels);
            let expected = 2.0 * f64::from(numbers[i]);
            assert!((mean - expected).abs() < 1e-3, "{mean} and {expected}");
        }
    }
}
