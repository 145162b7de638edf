//! How differences between blocks even out.
//!
//! Blocks at the part's border may be filled in part: each has the heat capacity of its voxels, and
//! is linked to the next by as many faces as their voxels share (`tally.rs` counts them).

use crate::aligned::Aligned;
use crate::law::Law;
use crate::tally::{Block, Tally};

use super::Region;

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
    pub(super) links: [Aligned; 3],
    /// To plate and air, 1/s in voxels.
    pub(super) losses: Aligned,
    /// 1 over the number of voxels; 0 for blocks without any.
    pub(super) share: Aligned,
    /// A bound on the rates at which differences between blocks die out, 1/s.
    pub(super) fastest: f32,
}

impl Conduction {
    /// Of so many blocks without any voxels.
    pub(super) fn reset(&mut self, len: usize) {
        let Self { links: [x, y, z], losses, share, fastest } = self;
        for numbers in [x, y, z, losses, share] {
            numbers.reset(len);
        }
        *fastest = 0.0;
    }

    /// Takes the conductances of a region from what its blocks hold, and from their mean
    /// temperatures above the air.
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
                if *block == whole
                    && strides.iter().all(|&stride| tally.blocks[i + stride] == whole)
                {
                    (0..3).for_each(|axis| self.links[axis][i] = inner[axis]);
                    (self.share[i], self.losses[i]) = (inner_share, 0.0);
                    self.fastest = self.fastest.max(inner_fastest);
                    continue;
                }
                if block.voxels == 0 {
                    (0..3).for_each(|axis| self.links[axis][i] = 0.0);
                    (self.share[i], self.losses[i]) = (0.0, 0.0);
                    continue;
                }
                (0..3).for_each(|axis| self.links[axis][i] = link_at(i, axis));
                self.share[i] = 1.0 / f32::from(block.voxels);
                let plate = if law.plate && block.plate > 0 {
                    2.0 * law.vertical * f32::from(block.plate)
                        / reach(block, block.plate, 2, tally)
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
        let part = |i: &usize| tally.blocks[*i].voxels > 0 && tally.blocks[*i] != whole;
        for i in region.blocks(tally).filter(part) {
            let out: f32 =
                (0..3).map(|axis| self.links[axis][i] + self.links[axis][i - strides[axis]]).sum();
            self.fastest = self.fastest.max((2.0 * out + self.losses[i]) * self.share[i]);
        }
    }
}
