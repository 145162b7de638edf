//! From blocks to their voxels: linear between the blocks' middles, and in the mean of each block
//! the block's own.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the processor's lanes"
)]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::kernel::dispatch;
use crate::patch::Patch;

use super::Region;

/// Memory for the interpolation of one row of blocks.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// Numbers between blocks in y and z, block by block.
    mixed: Vec<f32>,
    /// The same, voxel by voxel.
    spread: Vec<f32>,
    /// The numbers of each row of voxels.
    rows: Vec<f32>,
    /// Their sums, and in the end what blocks still lack.
    sums: Vec<f32>,
}

/// A number for each block, to be spread over voxels.
#[derive(Clone, Copy)]
pub(super) struct Prolongation<'a> {
    pub(super) blocks: &'a [f32],
    /// 1 over the number of voxels; 0 for blocks without any.
    pub(super) share: &'a [f32],
    /// What the numbers are to be multiplied by.
    pub(super) times: f32,
}

/// The part of a number that comes from the next block, for one voxel of so many in a block, and
/// whether that is the block after it.
fn weight(within: usize, coarsening: usize) -> (f32, bool) {
    let off = (within as f32 + 0.5) / coarsening as f32 - 0.5;
    (off.abs(), off > 0.0)
}

impl Prolongation<'_> {
    /// Adds the numbers of a region to the temperatures of its voxels, which are the whole inside
    /// of a patch.
    pub(super) fn add(
        self,
        patch: &mut Patch,
        region: Region,
        block_grid: &BlockGrid,
        lines: &mut Lines,
    ) {
        dispatch(Add { spread: self, patch, region, block_grid, lines });
    }
}

/// What [`Prolongation::add`] does.
struct Add<'a> {
    spread: Prolongation<'a>,
    patch: &'a mut Patch,
    region: Region,
    block_grid: &'a BlockGrid,
    lines: &'a mut Lines,
}

impl WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            spread: Prolongation { blocks: numbers, share, times },
            patch,
            region,
            block_grid,
            lines,
        } = self;
        let (coarse, [coarsening, deep, high]) = (block_grid.shape, block_grid.coarsening);
        let row = patch.shape.row;
        // Blocks of a patch's row, with one more at each end.
        let (first_x, blocks) = (patch.origin[0] / coarsening, row / coarsening + 1);
        let Lines { mixed, spread, rows, sums } = lines;
        mixed.resize(blocks, 0.0);
        spread.resize(blocks * coarsening, 0.0);
        rows.resize(deep * high * row, 0.0);
        sums.resize(row, 0.0);
        let at = |y: usize, z: usize| &numbers[coarse.index([first_x, y, z])..][..blocks];
        let next = |block: usize, after: bool| if after { block + 1 } else { block - 1 };
        for (y, z) in region.rows() {
            sums.fill(0.0);
            let (own_planes, own_rows) = (patch.voxels(1, y, deep), patch.voxels(2, z, high));
            let starts = || {
                let rows = own_rows.clone();
                own_planes.clone().flat_map(move |plane| rows.clone().map(move |row| (plane, row)))
            };
            for ((plane, voxels), line) in starts().zip(rows.chunks_exact_mut(row)) {
                let ((by_y, after_y), (by_z, after_z)) =
                    (weight(plane - own_planes.start, deep), weight(voxels - own_rows.start, high));
                let (ny, nz) = (next(y, after_y), next(z, after_z));
                let corners = [at(y, z), at(ny, z), at(y, nz), at(ny, nz)];
                let diagonal =
                    &patch.arrays.diagonal[patch.shape.index([0, plane, voxels])..][..row];
                mix(mixed, corners, by_y, by_z);
                repeat(spread, mixed);
                smooth(line, spread, diagonal, sums);
            }
            let start = coarse.index([first_x + 1, y, z]);
            let lacking = numbers[start..].iter().zip(&share[start..]);
            for (sums, (number, share)) in
                sums[1..row - 1].chunks_exact_mut(coarsening).zip(lacking)
            {
                sums.fill(number - sums.iter().sum::<f32>() * share);
            }
            for ((plane, voxels), line) in starts().zip(rows.chunks_exact(row)) {
                let start = patch.shape.index([0, plane, voxels]);
                let diagonal = &patch.arrays.diagonal[start..][..row];
                let theta = &mut patch.theta[start..][..row];
                add(theta, line, diagonal, sums, times);
            }
        }
    }
}

/// Interpolates between four lines of blocks, in two directions.
#[inline(always)]
fn mix(mixed: &mut [f32], [own, beside, over, across]: [&[f32]; 4], by_y: f32, by_z: f32) {
    let n = mixed.len();
    let (own, beside, over, across) = (&own[..n], &beside[..n], &over[..n], &across[..n]);
    for i in 0..n {
        let near = own[i] + by_y * (beside[i] - own[i]);
        let far = over[i] + by_y * (across[i] - over[i]);
        mixed[i] = near + by_z * (far - near);
    }
}

/// Gives both voxels of each block its number.
#[inline(always)]
fn repeat(spread: &mut [f32], blocks: &[f32]) {
    for (voxels, &block) in spread.chunks_exact_mut(2).zip(blocks) {
        voxels.fill(block);
    }
}

/// Interpolates along a line, in which each block's number stands twice: the voxel at `i` stands at
/// `i + 1` there.
/// Gives 0 where none is active, and adds all to the sums.
#[inline(always)]
fn smooth(line: &mut [f32], spread: &[f32], diagonal: &[f32], sums: &mut [f32]) {
    let n = line.len();
    let (before, here, after) = (&spread[..n], &spread[1..][..n], &spread[2..][..n]);
    let (diagonal, sums) = (&diagonal[..n], &mut sums[..n]);
    for i in 0..n {
        let number = 0.5 * here[i] + 0.25 * (before[i] + after[i]);
        line[i] = if diagonal[i] < 0.0 { number } else { 0.0 };
        sums[i] += line[i];
    }
}

/// Adds so many times a line's numbers, and what its blocks still lack.
#[inline(always)]
fn add(theta: &mut [f32], line: &[f32], diagonal: &[f32], lacking: &[f32], times: f32) {
    let n = theta.len();
    let (line, diagonal, lacking) = (&line[..n], &diagonal[..n], &lacking[..n]);
    for i in 0..n {
        theta[i] += times * (line[i] + if diagonal[i] < 0.0 { lacking[i] } else { 0.0 });
    }
}

/// Gives blocks without voxels, in a region and around it, the mean number of their neighbours, so
/// that there is something to interpolate towards beside every block; across the plate, which keeps
/// its temperature, that is the opposite.
pub(super) fn extend(
    blocks: &mut [f32],
    known: &mut [bool],
    region: Region,
    block_grid: &BlockGrid,
    coefficients: &Coefficients,
) {
    let (shape, strides) = (block_grid.shape, block_grid.strides());
    let ends = [shape.row, shape.planes, shape.rows];
    // Each pass below reaches one block farther.
    let around = Region {
        low: region.low.map(|low| low.saturating_sub(3)),
        high: [0, 1, 2].map(|axis: usize| (region.high[axis] + 3).min(ends[axis])),
    };
    let (mut all, mut edge) = (Vec::new(), Vec::new());
    // Three times: across faces, edges and corners.
    for _ in 0..3 {
        let begin = all.len();
        for line in around.lines(block_grid) {
            beside_known(&mut edge, known, line.clone(), strides);
            for (i, _) in line.zip(&edge).filter(|&(_, edge)| *edge) {
                let beside =
                    strides.into_iter().flat_map(|stride| [i.wrapping_sub(stride), i + stride]);
                let near = beside.filter(|&j| known.get(j) == Some(&true));
                let (sum, count) =
                    near.fold((0.0, 0.0), |(sum, count), j| (sum + blocks[j], count + 1.0));
                if count > 0.0 {
                    all.push((i, sum / count));
                }
            }
        }
        for &(i, number) in &all[begin..] {
            blocks[i] = number;
            known[i] = true;
        }
    }
    for (i, _) in all {
        known[i] = false;
    }
    if coefficients.plate_conducts && around.low[2] == 0 {
        for y in around.low[1]..around.high[1] {
            for x in around.low[0]..around.high[0] {
                blocks[shape.index([x, y, 0])] = -blocks[shape.index([x, y, 1])];
            }
        }
    }
}

/// Which blocks of a line are not known, but may have a known one beside them: all lines are asked,
/// and few blocks are.
fn beside_known(edge: &mut Vec<bool>, known: &[bool], line: Range<usize>, strides: [usize; 3]) {
    edge.clear();
    let here = &known[line.clone()];
    let most = strides.into_iter().max().unwrap_or(0);
    if line.start < most || line.end + most > known.len() {
        edge.extend(here.iter().map(|known| !known));
        return;
    }
    let n = here.len();
    let [x, y, z] = strides.map(|s| [&known[line.start - s..][..n], &known[line.start + s..][..n]]);
    let beside = |i: usize| x[0][i] | x[1][i] | y[0][i] | y[1][i] | z[0][i] | z[1][i];
    edge.extend((0..n).map(|i| !here[i] & beside(i)));
}
