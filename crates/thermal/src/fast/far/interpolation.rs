//! Prolongation: from one value per block to one value per voxel.
//!
//! The interpolation is trilinear between the centres of blocks.
//! Then all voxels of a block are shifted by the same amount, such that their mean is the block's
//! value: linear interpolation alone would create or lose heat in blocks whose voxels are not
//! distributed evenly.
//! Linear functions are reproduced exactly where all neighbouring blocks are full.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vector width of the sweep"
)]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::kernel::dispatch;
use crate::patch::Patch;

use super::region::Region;

/// Memory for the interpolation within one row of blocks.
#[derive(Debug, Default)]
pub(super) struct RowBuffers {
    /// Values interpolated in y and z, for each block of the row.
    blended: Vec<f32>,
    /// The values of `blended`, repeated for each voxel of a block along x.
    repeated: Vec<f32>,
    /// Interpolated values of each row of voxels in the row of blocks.
    rows: Vec<f32>,
    /// Sums of `rows` over y and z; later the correction of each block, repeated for each of its
    /// voxels along x.
    sums: Vec<f32>,
}

/// Values of all blocks, to be interpolated.
#[derive(Clone, Copy)]
pub(super) struct Prolongation<'a> {
    pub(super) blocks: &'a [f32],
    /// 1 over the number of voxels; 0 for blocks without any.
    pub(super) inverse_voxels: &'a [f32],
    /// Factor by which the values are multiplied.
    pub(super) factor: f32,
}

/// Weight of the neighbouring block for the voxel at position `within` in a block of `block_len`
/// voxels along an axis, and whether the neighbour is the next block rather than the previous one.
fn weight(within: usize, block_len: usize) -> (f32, bool) {
    // Distance of the voxel's centre from the block's, in blocks.
    let offset = (within as f32 + 0.5) / block_len as f32 - 0.5;
    (offset.abs(), offset > 0.0)
}

impl Prolongation<'_> {
    /// Adds the interpolated values to the temperatures of a region's voxels, which are the whole
    /// inside of a patch.
    pub(super) fn add(
        self,
        patch: &mut Patch,
        region: Region,
        block_grid: &BlockGrid,
        buffers: &mut RowBuffers,
    ) {
        dispatch(AddProlongation { prolongation: self, patch, region, block_grid, buffers });
    }
}

/// Arguments of [`Prolongation::add`].
///
/// The loops are plain ones over slices of one length, which the compiler vectorises for the
/// instruction set that is enabled in `with_simd`.
struct AddProlongation<'a> {
    prolongation: Prolongation<'a>,
    patch: &'a mut Patch,
    region: Region,
    block_grid: &'a BlockGrid,
    buffers: &'a mut RowBuffers,
}

impl WithSimd for AddProlongation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { prolongation, patch, region, block_grid, buffers } = self;
        let Prolongation { blocks: numbers, inverse_voxels, factor } = prolongation;
        let (coarse, [width, depth, height]) = (block_grid.shape, block_grid.coarsening);
        let row_len = patch.shape.row_len;
        // Blocks along the patch's row, and one more at each end to interpolate from.
        // Voxel `origin` is halo and the last voxel of block `origin / width`, since origins are
        // multiples of a cache line and voxel 1 is the first of block 1.
        let (first_x, blocks) = (patch.origin[0] / width, row_len / width + 1);
        let RowBuffers { blended, repeated, rows, sums } = buffers;
        blended.resize(blocks, 0.0);
        repeated.resize(blocks * width, 0.0);
        rows.resize(depth * height * row_len, 0.0);
        sums.resize(row_len, 0.0);
        let row_of = |y: usize, z: usize| &numbers[coarse.index([first_x, y, z])..][..blocks];
        let neighbour = |block: usize, next: bool| if next { block + 1 } else { block - 1 };
        for (y, z) in region.rows() {
            sums.fill(0.0);
            let own_planes = patch.block_range(1, y, depth);
            let own_rows = patch.block_range(2, z, height);
            let voxel_rows = || {
                let rows = own_rows.clone();
                own_planes.clone().flat_map(move |plane| rows.clone().map(move |row| (plane, row)))
            };
            for ((plane, row), line) in voxel_rows().zip(rows.chunks_exact_mut(row_len)) {
                let (y_weight, y_next) = weight(plane - own_planes.start, depth);
                let (z_weight, z_next) = weight(row - own_rows.start, height);
                let (ny, nz) = (neighbour(y, y_next), neighbour(z, z_next));
                let corners = [row_of(y, z), row_of(ny, z), row_of(y, nz), row_of(ny, nz)];
                let start = patch.shape.index([0, plane, row]);
                let diagonal = &patch.arrays.diagonal[start..][..row_len];
                blend(blended, corners, y_weight, z_weight);
                repeat(repeated, blended);
                interpolate_x(line, repeated, diagonal, sums);
            }
            // Correction of each block, per voxel: its value minus the mean of the interpolated
            // values.
            let start = coarse.index([first_x + 1, y, z]);
            let targets = numbers[start..].iter().zip(&inverse_voxels[start..]);
            let in_blocks = sums[1..row_len - 1].chunks_exact_mut(width);
            for (sums, (number, inverse_voxels)) in in_blocks.zip(targets) {
                sums.fill(number - sums.iter().sum::<f32>() * inverse_voxels);
            }
            for ((plane, row), line) in voxel_rows().zip(rows.chunks_exact(row_len)) {
                let start = patch.shape.index([0, plane, row]);
                let diagonal = &patch.arrays.diagonal[start..][..row_len];
                let theta = &mut patch.theta[start..][..row_len];
                add_corrected(theta, line, diagonal, sums, factor);
            }
        }
    }
}

/// Interpolates bilinearly, in y and z, between the blocks of four rows.
#[inline(always)]
fn blend(
    blended: &mut [f32],
    [own, in_y, in_z, diagonal]: [&[f32]; 4],
    y_weight: f32,
    z_weight: f32,
) {
    let n = blended.len();
    let (own, in_y, in_z, diagonal) = (&own[..n], &in_y[..n], &in_z[..n], &diagonal[..n]);
    for i in 0..n {
        let near = own[i] + y_weight * (in_y[i] - own[i]);
        let far = in_z[i] + y_weight * (diagonal[i] - in_z[i]);
        blended[i] = near + z_weight * (far - near);
    }
}

/// Writes the value of each block twice, once for each of its two voxels along x.
#[inline(always)]
fn repeat(repeated: &mut [f32], blocks: &[f32]) {
    for (voxels, &block) in repeated.chunks_exact_mut(2).zip(blocks) {
        voxels.fill(block);
    }
}

/// Interpolates along x, and adds the result to the sums; inactive voxels get 0.
///
/// `repeated` holds each block's value twice, once for each of its voxels; element `i + 1` belongs
/// to voxel `i` of the row.
/// One of the two elements next to it belongs to the same block.
/// So the weights 1/4, 1/2, 1/4 amount to 3/4 of the voxel's own block and 1/4 of the nearest other
/// block: linear interpolation for a coarsening factor of two, without separate cases for the left
/// and the right voxel.
#[inline(always)]
fn interpolate_x(line: &mut [f32], repeated: &[f32], diagonal: &[f32], sums: &mut [f32]) {
    let n = line.len();
    let (before, here, after) = (&repeated[..n], &repeated[1..][..n], &repeated[2..][..n]);
    let (diagonal, sums) = (&diagonal[..n], &mut sums[..n]);
    for i in 0..n {
        let number = 0.5 * here[i] + 0.25 * (before[i] + after[i]);
        line[i] = if diagonal[i] < 0.0 { number } else { 0.0 };
        sums[i] += line[i];
    }
}

/// Adds a row's values and the corrections of its blocks, times a factor, to the active voxels.
#[inline(always)]
fn add_corrected(
    theta: &mut [f32],
    line: &[f32],
    diagonal: &[f32],
    corrections: &[f32],
    factor: f32,
) {
    let n = theta.len();
    let (line, diagonal, corrections) = (&line[..n], &diagonal[..n], &corrections[..n]);
    for i in 0..n {
        theta[i] += factor * (line[i] + if diagonal[i] < 0.0 { corrections[i] } else { 0.0 });
    }
}

/// Extrapolates to blocks without voxels, in a region and around it, so that interpolation finds a
/// value next to every block.
///
/// Each of three passes gives unknown blocks the mean of their known neighbours: the first reaches
/// neighbours across faces, the second those across edges, the third those across corners.
/// Below the build plate, which keeps its temperature, the value is the negative of that above:
/// then the interpolated change is 0 at the plate's surface.
/// On return, `known` is as before.
pub(super) fn extend(
    blocks: &mut [f32],
    known: &mut [bool],
    region: Region,
    block_grid: &BlockGrid,
    coefficients: &Coefficients,
) {
    let (shape, strides) = (block_grid.shape, block_grid.strides());
    let ends = shape.sizes();
    // Each pass reaches one block farther.
    let around = Region {
        low: region.low.map(|low| low.saturating_sub(3)),
        high: [0, 1, 2].map(|axis: usize| (region.high[axis] + 3).min(ends[axis])),
    };
    let (mut all, mut candidates) = (Vec::new(), Vec::new());
    for _ in 0..3 {
        let begin = all.len();
        for line in around.lines(block_grid) {
            find_candidates(&mut candidates, known, line.clone(), strides);
            for (i, _) in line.zip(&candidates).filter(|&(_, candidate)| *candidate) {
                let neighbours =
                    strides.into_iter().flat_map(|stride| [i.wrapping_sub(stride), i + stride]);
                let near = neighbours.filter(|&j| known.get(j) == Some(&true));
                let (sum, count) =
                    near.fold((0.0, 0.0), |(sum, count), j| (sum + blocks[j], count + 1.0));
                if count > 0.0 {
                    all.push((i, sum / count));
                }
            }
        }
        // Written only after the pass, so that a pass does not read its own results.
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

/// Marks the blocks of a line that are not known but may have a known neighbour.
///
/// All lines around a region are searched and few blocks are found, so this is a loop without
/// branches that the compiler vectorises.
fn find_candidates(
    candidates: &mut Vec<bool>,
    known: &[bool],
    line: Range<usize>,
    strides: [usize; 3],
) {
    candidates.clear();
    let here = &known[line.clone()];
    let max_stride = strides.into_iter().max().unwrap_or(0);
    if line.start < max_stride || line.end + max_stride > known.len() {
        // At the border of the block grid some neighbours do not exist; the caller checks each.
        candidates.extend(here.iter().map(|known| !known));
        return;
    }
    let n = here.len();
    let [x, y, z] = strides.map(|s| [&known[line.start - s..][..n], &known[line.start + s..][..n]]);
    let has_known = |i: usize| x[0][i] | x[1][i] | y[0][i] | y[1][i] | z[0][i] | z[1][i];
    candidates.extend((0..n).map(|i| !here[i] & has_known(i)));
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::testing::{random_region, random_state};
    use super::*;

    #[test]
    fn blocks_without_voxels_get_the_means_of_their_neighbours() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        for _ in 0..1000 {
            let (state, coefficients) = random_state(&mut random);
            let block_grid = state.occupancy.block_grid();
            let shape = block_grid.shape;
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
            extend(&mut extended, &mut after, region, block_grid, &coefficients);
            assert_eq!(after, known);
            // Extrapolation by a search of all blocks in every pass.
            let (mut slow, mut known) = (numbers, known);
            let around = |position: &[usize; 3]| {
                (0..3).all(|axis| {
                    let range = region.low[axis].saturating_sub(3)..region.high[axis] + 3;
                    range.contains(&position[axis])
                })
            };
            let all = (0..shape.rows).flat_map(|z| {
                (0..shape.planes).flat_map(move |y| (0..shape.row_len).map(move |x| [x, y, z]))
            });
            let all: Vec<_> = all.filter(around).map(|position| shape.index(position)).collect();
            for _ in 0..3 {
                let (before, known_before) = (slow.clone(), known.clone());
                for &i in all.iter().filter(|&&i| !known_before[i]) {
                    let neighbours = block_grid
                        .strides()
                        .into_iter()
                        .flat_map(|stride| [i.wrapping_sub(stride), i + stride]);
                    let near: Vec<_> = neighbours
                        .filter(|&i| known_before.get(i) == Some(&true))
                        .map(|i| before[i])
                        .collect();
                    if !near.is_empty() {
                        (slow[i], known[i]) = (near.iter().sum::<f32>() / near.len() as f32, true);
                    }
                }
            }
            let below_plate = |i: usize| {
                coefficients.plate_conducts && (i / shape.row_len).is_multiple_of(shape.rows)
            };
            for i in all {
                let slow = if below_plate(i) { -slow[i + shape.row_len] } else { slow[i] };
                assert!((extended[i] - slow).abs() < 1e-6, "{} and {slow}", extended[i]);
            }
        }
    }
}
