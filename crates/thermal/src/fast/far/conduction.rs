//! How differences between blocks even out.
//!
//! Blocks at the part's border may be filled in part: each has the heat capacity of its voxels, and is linked to the next
//! by as many faces as their voxels share (`tally.rs` counts them).

use crate::kernel::dispatch;
use crate::law::Law;
use crate::tally::{Block, Tally};

use super::super::chebyshev::Polynomial;
use super::Region;

/// What has crossed from a block to another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Conductance, 1/s in voxels.
    pub(super) link: f32,
    /// K in voxels.
    pub(super) sum: f32,
}

/// How far a block's voxels reach from a face that it shares with so many of them: in voxels.
fn reach(block: &Block, faces: u16, axis: usize, tally: &Tally) -> f32 {
    (f32::from(block.voxels) / f32::from(faces)).clamp(1.0, tally.fold[axis] as f32)
}

/// The conductance between a block and the next along an axis, 1/s in voxels.
fn link(block: &Block, next: &Block, axis: usize, tally: &Tally, law: &Law) -> f32 {
    let faces = block.links[axis];
    if faces == 0 {
        return 0.0;
    }
    let distance = 0.5 * (reach(block, faces, axis, tally) + reach(next, faces, axis, tally));
    f32::from(faces) * law.conductance(axis) / distance
}

/// Conductances of blocks.
#[derive(Debug, Default)]
pub(super) struct Conduction {
    /// To the next blocks along x, y and z, 1/s in voxels.
    links: [Vec<f32>; 3],
    /// To plate and air.
    losses: Vec<f32>,
    /// 1 over the number of voxels; 0 for blocks without any.
    share: Vec<f32>,
    /// A bound on the rates at which differences between blocks die out, 1/s.
    fastest: f32,
    /// Rates of change of the blocks.
    slope: Vec<f32>,
}

impl Conduction {
    /// Of so many blocks without any voxels.
    pub(super) fn reset(&mut self, len: usize) {
        let Self { links: [x, y, z], losses, share, fastest, slope } = self;
        for numbers in [x, y, z, losses, share, slope] {
            numbers.clear();
            numbers.resize(len, 0.0);
        }
        *fastest = 0.0;
    }

    /// Takes the conductances of a region from what its blocks hold, and from their mean temperatures above the air.
    pub(super) fn weigh(&mut self, region: Region, tally: &Tally, law: &Law, theta: &[f32]) {
        let strides = tally.strides();
        let link_at = |i: usize, axis: usize| {
            link(&tally.blocks[i], &tally.blocks[i + strides[axis]], axis, tally, law)
        };
        let whole = tally.whole();
        // Most blocks are whole, and so are those around them.
        let inner = [0, 1, 2].map(|axis: usize| link(&whole, &whole, axis, tally, law));
        let inner_share = 1.0 / f32::from(whole.voxels);
        let inner_fastest = 4.0 * inner.iter().sum::<f32>() * inner_share;
        for line in region.lines(tally) {
            for i in line {
                let block = &tally.blocks[i];
                if *block == whole && strides.iter().all(|&stride| tally.blocks[i + stride] == whole) {
                    (0..3).for_each(|axis| self.links[axis][i] = inner[axis]);
                    (self.share[i], self.losses[i]) = (inner_share, 0.0);
                    self.fastest = self.fastest.max(inner_fastest);
                    continue;
                }
                (0..3).for_each(|axis| self.links[axis][i] = link_at(i, axis));
                self.share[i] = if block.voxels > 0 { 1.0 / f32::from(block.voxels) } else { 0.0 };
                let plate = if law.plate && block.plate > 0 {
                    2.0 * law.vertical * f32::from(block.plate) / reach(block, block.plate, 2, tally)
                } else {
                    0.0
                };
                self.losses[i] =
                    plate + law.air_loss(theta[i], f32::from(block.sides), f32::from(block.caps));
            }
        }
        for (axis, _, sheet) in region.sides(tally).filter(|&(_, side, _)| side == 0) {
            for i in sheet.blocks(tally).map(|i| i - strides[axis]) {
                self.links[axis][i] = link_at(i, axis);
            }
        }
        for i in region.blocks(tally).filter(|&i| tally.blocks[i] != whole) {
            let out: f32 = (0..3).map(|axis| self.links[axis][i] + self.links[axis][i - strides[axis]]).sum();
            self.fastest = self.fastest.max((2.0 * out + self.losses[i]) * self.share[i]);
        }
    }

    /// 1 over a block's number of voxels; 0 if it has none.
    pub(super) fn share(&self, block: usize) -> f32 {
        self.share[block]
    }

    /// The same of all blocks.
    pub(super) fn shares(&self) -> &[f32] {
        &self.share
    }

    /// What a block loses for each kelvin more, 1/s in voxels.
    pub(super) fn loss(&self, block: usize) -> f32 {
        self.losses[block]
    }

    /// The conductance between a block and the next along an axis, 1/s in voxels.
    pub(super) fn link(&self, block: usize, axis: usize) -> f32 {
        self.links[axis][block]
    }

    /// Takes temperatures through a time, in which all blocks also change by rates of their own, K/s, and adds what crosses
    /// between some of them.
    pub(super) fn evolve(
        &mut self,
        w: &mut [f32],
        rates: &[f32],
        seconds: f64,
        tally: &Tally,
        layers: usize,
        crossings: &mut [Crossing],
    ) {
        let polynomial = Polynomial::reaching(seconds * f64::from(self.fastest));
        let mut slope = std::mem::take(&mut self.slope);
        for factor in &polynomial.factors {
            let (a, b) = ((factor.a * seconds) as f32, (factor.b * seconds * seconds) as f32);
            let planes = (1..tally.shape.planes - 1).map(|y| {
                let start = tally.shape.index([0, y, 1]);
                start..start + layers * tally.shape.row
            });
            for range in planes.clone() {
                let (start, rates) = (range.start, &rates[range]);
                dispatch(|| {
                    self.flow(w, rates, start, tally, [0.0, 1.0, 1.0], &mut slope);
                });
            }
            for Crossing { from, to, link, sum } in &mut *crossings {
                *sum += *link * (a * (w[*from] - w[*to]) + b * (slope[*from] - slope[*to]));
            }
            for range in planes {
                let (start, rates) = (range.start, &slope[range]);
                dispatch(|| self.flow(&slope, rates, start, tally, [1.0, b, a], w));
            }
        }
        self.slope = slope;
    }

    /// For a range of blocks: so many times what it is, what flows in where `w` are temperatures, and what is added.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "to be compiled for the lanes of the processor")]
    fn flow(&self, w: &[f32], added: &[f32], start: usize, tally: &Tally, times: [f32; 3], out: &mut [f32]) {
        let (row, plane, n) = (tally.shape.row, tally.shape.plane(), added.len());
        let [x, y, z] = &self.links;
        let here = &w[start..][..n];
        let (left, right) = (&w[start - 1..][..n], &w[start + 1..][..n]);
        let (back, front) = (&w[start - plane..][..n], &w[start + plane..][..n]);
        let (below, above) = (&w[start - row..][..n], &w[start + row..][..n]);
        let (to_left, to_right) = (&x[start - 1..][..n], &x[start..][..n]);
        let (to_back, to_front) = (&y[start - plane..][..n], &y[start..][..n]);
        let (to_below, to_above) = (&z[start - row..][..n], &z[start..][..n]);
        let (losses, share, out) =
            (&self.losses[start..][..n], &self.share[start..][..n], &mut out[start..][..n]);
        for i in 0..n {
            let own = here[i];
            let in_x = to_left[i] * (left[i] - own) + to_right[i] * (right[i] - own);
            let in_y = to_back[i] * (back[i] - own) + to_front[i] * (front[i] - own);
            let in_z = to_below[i] * (below[i] - own) + to_above[i] * (above[i] - own);
            let flow = (in_x + in_y + in_z - losses[i] * own) * share[i];
            out[i] = times[0] * out[i] + times[1] * flow + times[2] * added[i];
        }
    }
}
