//! What blocks are told by their voxels: their means, and what surfaces exchange with plate and
//! air.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the processor's lanes"
)]

use pulp::{Simd, WithSimd};

use crate::aligned::LINE;
use crate::kernel::dispatch;
use crate::law::Law;
use crate::patch::Patch;
use crate::tally::Tally;

use super::Region;

/// Sums over the voxels of each block.
#[derive(Debug, Default)]
pub(super) struct Sums {
    /// Temperatures above the air, K.
    pub(super) theta: Vec<f32>,
    /// What plate and air add to them, K/s.
    pub(super) gains: Vec<f32>,
    /// Sums over the rows of a row of blocks, voxel by voxel: of temperatures and gains.
    lines: [Vec<f32>; 2],
}

impl Sums {
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
        tally: &Tally,
        law: &Law,
        top: usize,
    ) {
        dispatch(Take { sums: self, patch, region, tally, law, top });
    }
}

/// What [`Sums::take`] does.
struct Take<'a> {
    sums: &'a mut Sums,
    patch: &'a Patch,
    region: Region,
    tally: &'a Tally,
    law: &'a Law,
    top: usize,
}

impl WithSimd for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sums: Sums { theta, gains, lines }, patch, region, tally, law, top } = self;
        let [warm, gained] = lines;
        let (fine, fold) = (patch.shape, tally.fold);
        let row = fine.row;
        warm.resize(row, 0.0);
        gained.resize(row, 0.0);
        for (y, z) in region.rows() {
            warm.fill(0.0);
            gained.fill(0.0);
            let (planes, rows) = (patch.voxels(1, y, fold[1]), patch.voxels(2, z, fold[2]));
            for plane in planes {
                for z in rows.clone().take_while(|z| z + patch.origin[2] < top) {
                    let start = fine.index([0, plane, z]);
                    let theta = &patch.theta[start..][..row];
                    add(warm, theta);
                    for (i, line) in
                        patch.activity.lines[start / LINE..][..row / LINE].iter().enumerate()
                    {
                        if line.is_open() {
                            let caps = patch.activity.caps.get(start..).unwrap_or(&[]);
                            let range = i * LINE..(i + 1) * LINE;
                            let (theta, gained) =
                                (&theta[range.clone()], &mut gained[range.clone()]);
                            let exposure = &patch.activity.exposure[start..][range.clone()];
                            let caps = caps.get(range).unwrap_or(exposure);
                            lose(gained, theta, exposure, caps, law);
                        }
                    }
                    if law.plate && z + patch.origin[2] == 1 {
                        let damping = &patch.activity.damping[start..][..row];
                        touch(gained, theta, damping, law);
                    }
                }
            }
            let block = tally.shape.index([region.low[0], y, z]);
            let blocks = block..block + ((row - 2) / fold[0]).min(region.high[0] - region.low[0]);
            let sums = theta[blocks.clone()].iter_mut().zip(&mut gains[blocks]);
            let voxels = warm[1..].chunks_exact(fold[0]).zip(gained[1..].chunks_exact(fold[0]));
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
fn lose(gained: &mut [f32], theta: &[f32], exposure: &[f32], caps: &[f32], law: &Law) {
    let n = gained.len();
    let (theta, exposure, caps) = (&theta[..n], &exposure[..n], &caps[..n]);
    for i in 0..n {
        gained[i] -= law.lost(theta[i], exposure[i], caps[i]);
    }
}

/// Adds what the plate gives to the lowest voxels.
#[inline(always)]
fn touch(gained: &mut [f32], theta: &[f32], damping: &[f32], law: &Law) {
    let n = gained.len();
    let (theta, damping) = (&theta[..n], &damping[..n]);
    for i in 0..n {
        gained[i] +=
            if damping[i] < 0.0 { law.vertical * (law.ghost - 2.0 * theta[i]) } else { 0.0 };
    }
}
