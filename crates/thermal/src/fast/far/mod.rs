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

mod block_stepper;
mod conductances;
mod flux_halo;
mod interpolation;
mod region;
mod restriction;

use crate::aligned::AlignedBuffer;
use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::patch::Patch;

use self::block_stepper::{BlockStepper, BorderFlow};
use self::conductances::BlockConductances;
use self::interpolation::{Lines, Prolongation};
use self::restriction::BlockSums;

pub(super) use self::flux_halo::{BorderFluxes, FluxHalo};
pub(super) use self::region::{BorderPair, Region};

/// What the blocks of a part know.
#[derive(Debug, Default)]
pub(super) struct FarField {
    /// Whether there is a change that voxels do not show yet.
    goes_on: bool,
    conduction: BlockConductances,
    evolution: BlockStepper,
    sums: BlockSums,
    /// Mean temperatures of the blocks above the air, U, K.
    theta: AlignedBuffer,
    /// What they are without the change that their voxels do not show yet, K.
    shown: AlignedBuffer,
    /// Rates of the blocks that their voxels know better, s, K/s.
    rates: AlignedBuffer,
    /// Whether a block has voxels that were looked at.
    known: Vec<bool>,
    /// Change of the blocks, K.
    change: AlignedBuffer,
    lines: Lines,
}

impl FarField {
    /// Looks at all voxels of a part, unless it goes on from an earlier step.
    pub(super) fn begin(
        &mut self,
        part: &Patch,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        if std::mem::replace(&mut self.goes_on, true) {
            return;
        }
        let Self { conduction, sums, theta, shown, rates, known, change, .. } = self;
        let len = block_grid.shape.len();
        for numbers in [theta, shown, rates, change] {
            numbers.reset(len);
        }
        known.clear();
        known.resize(len, false);
        conduction.reset(len);
        sums.reset(len);
        self.restrict(part, Region::whole(block_grid, top), block_grid, coefficients, top);
    }

    /// Gives the voxels of a part what they do not show yet.
    pub(super) fn end(
        &mut self,
        part: &mut Patch,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        if std::mem::take(&mut self.goes_on) {
            self.add(1.0, part, Region::whole(block_grid, top), block_grid, coefficients);
        }
    }

    /// Looks at the voxels of a region, which are the inside of a patch with nothing beyond its
    /// border.
    pub(super) fn restrict(
        &mut self,
        patch: &Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        self.sums.take(patch, region, block_grid, coefficients, top);
        let Self { conduction, sums, theta, shown, rates, known, .. } = self;
        for i in region.blocks(block_grid).filter(|&i| block_grid.blocks[i].voxels > 0) {
            theta[i] = sums.theta[i] / f32::from(block_grid.blocks[i].voxels);
            if !std::mem::replace(&mut known[i], true) {
                shown[i] = theta[i];
            }
        }
        conduction.weigh(region, block_grid, coefficients, theta);
        for i in region.blocks(block_grid) {
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
        border: &[BorderPair],
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) -> BorderFluxes {
        let Self { conduction, evolution, theta, rates, .. } = self;
        let crossing = |border: &BorderPair| {
            let link = conduction.links[border.axis][border.first()];
            BorderFlow { from: border.inside, to: border.outside, link, sum: 0.0 }
        };
        let mut crossings: Vec<BorderFlow> = border.iter().map(crossing).collect();
        evolution.advance(
            conduction,
            theta,
            rates,
            seconds,
            block_grid,
            block_grid.layers(top),
            &mut crossings,
        );
        let crossed = crossings.iter().map(|crossing| crossing.sum);
        BorderFluxes::new(border.iter().zip(crossed), seconds, block_grid, coefficients)
    }

    /// Adds the change to the voxels of a region, which are the inside of a patch, so many times.
    pub(super) fn add(
        &mut self,
        times: f32,
        patch: &mut Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
    ) {
        let Self { theta, shown, change, known, conduction, lines, .. } = self;
        for line in region.grown(4, block_grid).lines(block_grid) {
            let numbers =
                change[line.clone()].iter_mut().zip(&theta[line.clone()]).zip(&shown[line]);
            numbers.for_each(|((change, theta), shown)| *change = theta - shown);
        }
        interpolation::extend(change, known, region, block_grid, coefficients);
        let spread = Prolongation { blocks: change, share: &conduction.share, times };
        spread.add(patch, region, block_grid, lines);
    }
}

#[cfg(test)]
mod tests;
