//! The far field: what changes slowly, followed on blocks of voxels.
//!
//! Far from the nozzle temperatures are smooth, and so is their change.
//! There, voxels keep the temperatures they had when they were last looked at, and the means of
//! **blocks** of about a cube's shape go on: dU/dt = J U + s, where J is the conduction between
//! blocks and their losses, and s what their surfaces lost at the last look otherwise.
//! Where voxels are wanted, they are what they were and the change of the blocks since then, in
//! linear interpolation.
//! So a step costs a few sweeps over the blocks, however long it is, and looks at no voxel.
//! Multigrid methods call this a correction on the coarse grid (Brandt 1977).
//!
//! In a **region** around recent births, steps are taken on voxels.
//! Births are sources of heat to the blocks.
//! What crosses the region's border by the blocks' means is what its voxels are given and what the
//! blocks outside take up: all heat is kept, wherever the border lies.

mod border;
mod conduction;
mod evolution;
mod interpolation;
mod look;
mod region;

use crate::aligned::Aligned;
use crate::law::Law;
use crate::patch::Patch;
use crate::tally::Tally;

use self::conduction::Conduction;
use self::evolution::{Crossing, Evolution};
use self::interpolation::{Lines, Spread};
use self::look::Sums;

pub(super) use self::border::{Flows, Rim};
pub(super) use self::region::{Border, Region};

/// What the blocks of a part know.
#[derive(Debug, Default)]
pub(super) struct FarField {
    /// Whether there is a change that voxels do not show yet.
    goes_on: bool,
    conduction: Conduction,
    evolution: Evolution,
    sums: Sums,
    /// Mean temperatures of the blocks above the air, U, K.
    theta: Aligned,
    /// What they are without the change that their voxels do not show yet, K.
    shown: Aligned,
    /// Rates of the blocks that their voxels know better, s, K/s.
    rates: Aligned,
    /// Whether a block has voxels that were looked at.
    known: Vec<bool>,
    /// Change of the blocks, K.
    change: Aligned,
    lines: Lines,
}

impl FarField {
    /// Looks at all voxels of a part, unless it goes on from an earlier step.
    pub(super) fn begin(&mut self, part: &Patch, tally: &Tally, law: &Law, top: usize) {
        if std::mem::replace(&mut self.goes_on, true) {
            return;
        }
        let Self { conduction, sums, theta, shown, rates, known, change, .. } = self;
        let len = tally.shape.len();
        for numbers in [theta, shown, rates, change] {
            numbers.reset(len);
        }
        known.clear();
        known.resize(len, false);
        conduction.reset(len);
        sums.reset(len);
        self.look(part, Region::whole(tally, top), tally, law, top);
    }

    /// Gives the voxels of a part what they do not show yet.
    pub(super) fn end(&mut self, part: &mut Patch, tally: &Tally, law: &Law, top: usize) {
        if std::mem::take(&mut self.goes_on) {
            self.add(1.0, part, Region::whole(tally, top), tally, law);
        }
    }

    /// Looks at the voxels of a region, which are the inside of a patch with nothing beyond its
    /// border.
    pub(super) fn look(
        &mut self,
        patch: &Patch,
        region: Region,
        tally: &Tally,
        law: &Law,
        top: usize,
    ) {
        self.sums.take(patch, region, tally, law, top);
        let Self { conduction, sums, theta, shown, rates, known, .. } = self;
        for i in region.blocks(tally).filter(|&i| tally.blocks[i].voxels > 0) {
            theta[i] = sums.theta[i] / f32::from(tally.blocks[i].voxels);
            if !std::mem::replace(&mut known[i], true) {
                shown[i] = theta[i];
            }
        }
        conduction.weigh(region, tally, law, theta);
        for i in region.blocks(tally) {
            rates[i] = conduction.share[i] * (sums.gains[i] + conduction.losses[i] * theta[i]);
        }
    }

    /// Heats a block in the steps to come, or as much less: so many K/s in voxels above its own
    /// temperature.
    pub(super) fn heat(&mut self, block: usize, rate: f32) {
        self.rates[block] += rate * self.conduction.share[block];
    }

    /// The mean temperature of a block above the air, K; `None` if it had no voxels when it was
    /// looked at.
    pub(super) fn theta(&self, block: usize) -> Option<f32> {
        self.known[block].then(|| self.theta[block])
    }

    /// Takes the blocks through a time, and gives what crosses the border of a region, if it is of
    /// interest.
    pub(super) fn step(
        &mut self,
        seconds: f64,
        border: &[Border],
        tally: &Tally,
        law: &Law,
        top: usize,
    ) -> Flows {
        let Self { conduction, evolution, theta, rates, .. } = self;
        let crossing = |border: &Border| {
            let link = conduction.links[border.axis][border.first()];
            Crossing { from: border.inside, to: border.outside, link, sum: 0.0 }
        };
        let mut crossings: Vec<Crossing> = border.iter().map(crossing).collect();
        evolution.advance(
            conduction,
            theta,
            rates,
            seconds,
            tally,
            tally.layers(top),
            &mut crossings,
        );
        let crossed = crossings.iter().map(|crossing| crossing.sum);
        Flows::new(border.iter().zip(crossed), seconds, tally, law)
    }

    /// Adds the change to the voxels of a region, which are the inside of a patch, so many times.
    pub(super) fn add(
        &mut self,
        times: f32,
        patch: &mut Patch,
        region: Region,
        tally: &Tally,
        law: &Law,
    ) {
        let Self { theta, shown, change, known, conduction, lines, .. } = self;
        for line in region.grown(4, tally).lines(tally) {
            let numbers =
                change[line.clone()].iter_mut().zip(&theta[line.clone()]).zip(&shown[line]);
            numbers.for_each(|((change, theta), shown)| *change = theta - shown);
        }
        interpolation::extend(change, known, region, tally, law);
        let spread = Spread { blocks: change, share: &conduction.share, times };
        spread.add(patch, region, tally, lines);
    }
}

#[cfg(test)]
mod tests;
