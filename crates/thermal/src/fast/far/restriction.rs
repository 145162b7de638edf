//! Restriction: from voxels to blocks.
//!
//! Sums up, for each block, the temperatures of its voxels and the heat that their surfaces
//! exchange with plate and air.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vector width of the sweep"
)]

use pulp::{Simd, WithSimd};

use crate::aligned::LINE_LEN;
use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::kernel::dispatch;
use crate::patch::Patch;

use super::region::Region;

/// Sums over the voxels of each block.
#[derive(Debug, Default)]
pub(super) struct BlockSums {
    /// Temperatures above the air, K voxels.
    pub(super) theta: Vec<f32>,
    /// Heat gained from plate and air, K voxels/s; negative where more is lost.
    pub(super) gains: Vec<f32>,
    /// Buffers for one row of blocks: sums of temperatures, and of gains, over y and z, for each x.
    columns: [Vec<f32>; 2],
}

impl BlockSums {
    /// Resets the sums to those of blocks without voxels.
    pub(super) fn reset(&mut self, len: usize) {
        for numbers in [&mut self.theta, &mut self.gains] {
            numbers.clear();
            numbers.resize(len, 0.0);
        }
    }

    /// Recomputes the sums of a region, whose voxels are the inside of a patch; rows of the part
    /// from `top` on are empty.
    pub(super) fn restrict(
        &mut self,
        patch: &Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        dispatch(Restrict { sums: self, patch, region, block_grid, coefficients, top });
    }
}

/// Arguments of [`BlockSums::restrict`].
///
/// The loops are plain ones over slices of one length, which the compiler vectorises for the
/// instruction set that is enabled in `with_simd`.
/// Whole rows of voxels are added up first, element by element, which vectorises.
/// Only at the end are neighbouring elements, the voxels of a block along x, added to each other,
/// which does not.
struct Restrict<'a> {
    sums: &'a mut BlockSums,
    patch: &'a Patch,
    region: Region,
    block_grid: &'a BlockGrid,
    coefficients: &'a Coefficients,
    top: usize,
}

impl WithSimd for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sums, patch, region, block_grid, coefficients, top } = self;
        let BlockSums { theta: theta_sums, gains: gain_sums, columns } = sums;
        let [theta_columns, gain_columns] = columns;
        let (shape, [width, depth, height]) = (patch.shape, block_grid.coarsening);
        let row_len = shape.row_len;
        theta_columns.resize(row_len, 0.0);
        gain_columns.resize(row_len, 0.0);
        for (y, z) in region.rows() {
            theta_columns.fill(0.0);
            gain_columns.fill(0.0);
            let (planes, rows) = (patch.block_range(1, y, depth), patch.block_range(2, z, height));
            for plane in planes {
                for row in rows.clone().take_while(|row| row + patch.origin[2] < top) {
                    let start = shape.index([0, plane, row]);
                    let theta = &patch.theta[start..][..row_len];
                    add(theta_columns, theta);
                    add_surface_loss(gain_columns, theta, patch, start, coefficients);
                    if coefficients.plate_conducts && row + patch.origin[2] == 1 {
                        let diagonal = &patch.arrays.diagonal[start..][..row_len];
                        add_plate(gain_columns, theta, diagonal, coefficients);
                    }
                }
            }
            let first = block_grid.shape.index([region.low[0], y, z]);
            let count = ((row_len - 2) / width).min(region.high[0] - region.low[0]);
            let blocks = first..first + count;
            let sums = theta_sums[blocks.clone()].iter_mut().zip(&mut gain_sums[blocks]);
            let columns =
                theta_columns[1..].chunks_exact(width).zip(gain_columns[1..].chunks_exact(width));
            for ((theta_sum, gain_sum), (theta, gains)) in sums.zip(columns) {
                (*theta_sum, *gain_sum) = (theta.iter().sum(), gains.iter().sum());
            }
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32], numbers: &[f32]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
}

/// Subtracts the heat that the voxels of a row lose to the air.
/// Skips cache lines that cannot have a surface.
#[inline(always)]
fn add_surface_loss(
    gains: &mut [f32],
    theta: &[f32],
    patch: &Patch,
    start: usize,
    coefficients: &Coefficients,
) {
    let (arrays, row_len) = (&patch.arrays, theta.len());
    for (i, line) in arrays.lines[start / LINE_LEN..][..row_len / LINE_LEN].iter().enumerate() {
        if line.may_be_exposed() {
            let range = i * LINE_LEN..(i + 1) * LINE_LEN;
            let exposed_area = &arrays.exposed_area[start..][range.clone()];
            // Without surface resistance this array is empty, and the numbers are not used.
            let top_bottom_area = arrays.top_bottom_area.get(start..).unwrap_or(&[]);
            let top_bottom_area = top_bottom_area.get(range.clone()).unwrap_or(exposed_area);
            let (gains, theta) = (&mut gains[range.clone()], &theta[range]);
            add_line_loss(gains, theta, exposed_area, top_bottom_area, coefficients);
        }
    }
}

#[inline(always)]
fn add_line_loss(
    gains: &mut [f32],
    theta: &[f32],
    exposed_area: &[f32],
    top_bottom_area: &[f32],
    coefficients: &Coefficients,
) {
    let n = gains.len();
    let (theta, exposed_area) = (&theta[..n], &exposed_area[..n]);
    let top_bottom_area = &top_bottom_area[..n];
    for i in 0..n {
        gains[i] -= coefficients.surface_loss(theta[i], exposed_area[i], top_bottom_area[i]);
    }
}

/// Adds the heat that the voxels of a row in layer 0 gain from the build plate.
#[inline(always)]
fn add_plate(gains: &mut [f32], theta: &[f32], diagonal: &[f32], coefficients: &Coefficients) {
    let n = gains.len();
    let (theta, diagonal) = (&theta[..n], &diagonal[..n]);
    for i in 0..n {
        gains[i] += if diagonal[i] < 0.0 {
            coefficients.vertical * (coefficients.plate_ghost - 2.0 * theta[i])
        } else {
            0.0
        };
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::testing::{positions, printed, random_region, random_state};
    use super::*;
    use crate::kernel::{Quadratic, SweepBuffers, TwoStageSweep};
    use crate::material::ThermalMaterial;
    use crate::process::ProcessParameters;

    #[test]
    fn sums_equal_those_voxel_by_voxel() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..300 {
            let (state, coefficients) = random_state(&mut random);
            let block_grid = state.occupancy.block_grid();
            let (region, patch) = random_region(&mut random, &state);
            let mut sums = BlockSums::default();
            sums.reset(block_grid.shape.len());
            sums.restrict(&patch, region, block_grid, &coefficients, state.top);
            let mut expected = vec![[0.0_f64; 2]; block_grid.shape.len()];
            for position in positions(state.patch.shape.sizes().map(|n| n - 2)) {
                let index = state.patch.shape.index(position);
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
                let plate = if coefficients.plate_conducts && position[2] == 1 {
                    f64::from(coefficients.vertical)
                        * (f64::from(coefficients.plate_ghost) - 2.0 * theta)
                } else {
                    0.0
                };
                let block = &mut expected[block_grid.block_of(position)];
                *block = [block[0] + theta, block[1] + plate - lost];
            }
            for i in region.blocks(block_grid) {
                let [theta, gain] = expected[i];
                let (theta_sum, gain_sum) = (f64::from(sums.theta[i]), f64::from(sums.gains[i]));
                assert!((theta_sum - theta).abs() < 1e-2, "{theta_sum} and {theta}");
                assert!((gain_sum - gain).abs() < 1e-5 * gain.abs().max(100.0));
            }
        }
    }

    #[test]
    fn surface_loss_equals_that_of_the_sweeps() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
        for resistance in [false, true] {
            let process = ProcessParameters {
                plate_c: None,
                surface_resistance: resistance,
                ..ProcessParameters::default()
            };
            let coefficients =
                Coefficients::new(&ThermalMaterial::abs(), &process, 0.5e-3, 0.25e-3);
            for _ in 0..100 {
                // A single voxel, so that it changes by its losses only.
                let warm = random.random_range(1.0..200.0);
                let mut state = printed([1, 1, 1], &coefficients, |_| Some(warm));
                let index = state.patch.shape.index([1, 1, 1]);
                let voxel = coefficients.by_faces[usize::from(state.occupancy.faces()[index])];
                let top = state.top;
                let patch = state.make_mut().patch;
                let mut buffers = SweepBuffers::default();
                let seconds = 1e-2;
                let scheme = Quadratic { a: seconds, b: 0.0 };
                TwoStageSweep { coefficients: &coefficients, patch, scheme, held: None, top }
                    .sweep(&mut buffers);
                let lost = coefficients.surface_loss(
                    warm as f32,
                    voxel.exposed_area,
                    voxel.top_bottom_area,
                );
                let swept = (warm as f32 - patch.theta[index]) / seconds;
                assert!((swept / lost - 1.0).abs() < 2e-2, "{swept} and {lost}");
            }
        }
    }
}
