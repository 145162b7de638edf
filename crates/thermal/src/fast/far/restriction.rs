//! What blocks are told by their voxels: their means, and what surfaces exchange with plate and
//! air.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the processor's lanes"
)]

use pulp::{Simd, WithSimd};

use crate::aligned::LINE_LEN;
use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::kernel::dispatch;
use crate::patch::Patch;

use super::Region;

/// Sums over the voxels of each block.
#[derive(Debug, Default)]
pub(super) struct BlockSums {
    /// Temperatures above the air, K.
    pub(super) theta: Vec<f32>,
    /// What plate and air add to them, K/s.
    pub(super) gains: Vec<f32>,
    /// Sums over the rows of a row of blocks, voxel by voxel: of temperatures and gains.
    lines: [Vec<f32>; 2],
}

impl BlockSums {
    /// Of so many blocks without voxels.
    pub(super) fn reset(&mut self, len: usize) {
        for numbers in [&mut self.theta, &mut self.gains] {
            numbers.clear();
            numbers.resize(len, 0.0);
        }
    }

    /// Takes the sums of a region, whose voxels are the inside of a patch; rows of the part from
    /// `top` on are empty.
    pub(super) fn take(
        &mut self,
        patch: &Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        dispatch(Take { sums: self, patch, region, block_grid, coefficients, top });
    }
}

/// What [`BlockSums::take`] does.
struct Take<'a> {
    sums: &'a mut BlockSums,
    patch: &'a Patch,
    region: Region,
    block_grid: &'a BlockGrid,
    coefficients: &'a Coefficients,
    top: usize,
}

impl WithSimd for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            sums: BlockSums { theta, gains, lines },
            patch,
            region,
            block_grid,
            coefficients,
            top,
        } = self;
        let [warm, gained] = lines;
        let (fine, coarsening) = (patch.shape, block_grid.coarsening);
        let row = fine.row;
        warm.resize(row, 0.0);
        gained.resize(row, 0.0);
        for (y, z) in region.rows() {
            warm.fill(0.0);
            gained.fill(0.0);
            let (planes, rows) =
                (patch.voxels(1, y, coarsening[1]), patch.voxels(2, z, coarsening[2]));
            for plane in planes {
                for z in rows.clone().take_while(|z| z + patch.origin[2] < top) {
                    let start = fine.index([0, plane, z]);
                    let theta = &patch.theta[start..][..row];
                    add(warm, theta);
                    for (i, line) in
                        patch.arrays.lines[start / LINE_LEN..][..row / LINE_LEN].iter().enumerate()
                    {
                        if line.is_open() {
                            let top_bottom_area =
                                patch.arrays.top_bottom_area.get(start..).unwrap_or(&[]);
                            let range = i * LINE_LEN..(i + 1) * LINE_LEN;
                            let (theta, gained) =
                                (&theta[range.clone()], &mut gained[range.clone()]);
                            let exposed_area = &patch.arrays.exposed_area[start..][range.clone()];
                            let top_bottom_area =
                                top_bottom_area.get(range).unwrap_or(exposed_area);
                            lose(gained, theta, exposed_area, top_bottom_area, coefficients);
                        }
                    }
                    if coefficients.plate_conducts && z + patch.origin[2] == 1 {
                        let diagonal = &patch.arrays.diagonal[start..][..row];
                        touch(gained, theta, diagonal, coefficients);
                    }
                }
            }
            let block = block_grid.shape.index([region.low[0], y, z]);
            let blocks =
                block..block + ((row - 2) / coarsening[0]).min(region.high[0] - region.low[0]);
            let sums = theta[blocks.clone()].iter_mut().zip(&mut gains[blocks]);
            let voxels =
                warm[1..].chunks_exact(coarsening[0]).zip(gained[1..].chunks_exact(coarsening[0]));
            for ((theta, gain), (warm, gained)) in sums.zip(voxels) {
                (*theta, *gain) = (warm.iter().sum(), gained.iter().sum());
            }
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32], numbers: &[f32]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
}

/// Takes off what goes to the air.
#[inline(always)]
fn lose(
    gained: &mut [f32],
    theta: &[f32],
    exposed_area: &[f32],
    top_bottom_area: &[f32],
    coefficients: &Coefficients,
) {
    let n = gained.len();
    let (theta, exposed_area, top_bottom_area) =
        (&theta[..n], &exposed_area[..n], &top_bottom_area[..n]);
    for i in 0..n {
        gained[i] -= coefficients.surface_loss(theta[i], exposed_area[i], top_bottom_area[i]);
    }
}

/// Adds what the plate gives to the lowest voxels.
#[inline(always)]
fn touch(gained: &mut [f32], theta: &[f32], diagonal: &[f32], coefficients: &Coefficients) {
    let n = gained.len();
    let (theta, diagonal) = (&theta[..n], &diagonal[..n]);
    for i in 0..n {
        gained[i] += if diagonal[i] < 0.0 {
            coefficients.vertical * (coefficients.plate_ghost - 2.0 * theta[i])
        } else {
            0.0
        };
    }
}
