//! The state of the far field, and the operations on it.

use crate::aligned::AlignedBuffer;
use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::patch::Patch;

use super::block_stepper::{BlockStepper, BorderFlow};
use super::conductances::BlockConductances;
use super::flux_halo::BorderFluxes;
use super::interpolation::{self, Prolongation, RowBuffers};
use super::region::{BorderPair, Region};
use super::restriction::BlockSums;

/// Temperatures of the blocks of a part, and the change that its voxels do not contain yet.
///
/// Invariant, while the far field is active: the temperature of a voxel of the part is what its
/// patch stores, plus the interpolation of `theta` - `reference`.
/// The reference of a block is fixed when its voxels are first restricted, and does not change
/// afterwards.
/// When a window writes its voxels back, the pending change is subtracted from them, instead of
/// moving the reference.
/// So the pending change has no jumps at the borders of earlier regions, which interpolation would
/// blur.
#[derive(Debug, Default)]
pub(crate) struct FarField {
    /// Whether there is a pending change.
    active: bool,
    pub(super) conductances: BlockConductances,
    stepper: BlockStepper,
    sums: BlockSums,
    /// Mean temperature of each block, relative to the air, U, K.
    pub(super) theta: AlignedBuffer,
    /// Mean temperature of each block that its pending change is counted from, K.
    reference: AlignedBuffer,
    /// Constant part of the blocks' rates of change, s, K/s.
    sources: AlignedBuffer,
    /// Whether each block had voxels at its last restriction.
    known: Vec<bool>,
    /// Pending change, K; recomputed wherever it is needed.
    change: AlignedBuffer,
    buffers: RowBuffers,
}

impl FarField {
    /// Activates the far field and restricts all voxels of a part, unless it is active already.
    pub(crate) fn begin(
        &mut self,
        part: &Patch,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        if std::mem::replace(&mut self.active, true) {
            return;
        }
        let Self { conductances, sums, theta, reference, sources, known, change, .. } = self;
        let len = block_grid.shape.len();
        for numbers in [theta, reference, sources, change] {
            numbers.reset(len);
        }
        known.clear();
        known.resize(len, false);
        conductances.reset(len);
        sums.reset(len);
        self.restrict(part, Region::whole(block_grid, top), block_grid, coefficients, top);
    }

    /// Adds the pending change to all voxels of a part and deactivates the far field.
    /// Does nothing if it is not active.
    pub(crate) fn end(
        &mut self,
        part: &mut Patch,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        if std::mem::take(&mut self.active) {
            let whole = Region::whole(block_grid, top);
            self.add_change(1.0, part, whole, block_grid, coefficients);
        }
    }

    /// Recomputes the blocks of a region from its voxels, which are the inside of `patch`.
    /// They must be current: the pending change has been added to them.
    pub(crate) fn restrict(
        &mut self,
        patch: &Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) {
        self.sums.restrict(patch, region, block_grid, coefficients, top);
        let Self { conductances, sums, theta, reference, sources, known, .. } = self;
        for i in region.blocks(block_grid).filter(|&i| block_grid.blocks[i].voxels > 0) {
            theta[i] = sums.theta[i] / f32::from(block_grid.blocks[i].voxels);
            if !std::mem::replace(&mut known[i], true) {
                reference[i] = theta[i];
            }
        }
        conductances.update(region, block_grid, coefficients, theta);
        // Linearised around the present mean: s is chosen such that s - losses U equals the present
        // gains of the voxels.
        for i in region.blocks(block_grid) {
            sources[i] = conductances.inverse_voxels[i]
                * (sums.gains[i] + conductances.losses[i] * theta[i]);
        }
    }

    /// Adds a heat source of `rate` K voxels/s to a block for all later steps; adding the negative
    /// rate removes it.
    pub(crate) fn add_source(&mut self, block: usize, rate: f32) {
        self.sources[block] += rate * self.conductances.inverse_voxels[block];
    }

    /// Mean temperature of a block above the air, K; `None` if it had no voxels at the last
    /// restriction.
    pub(crate) fn mean_theta(&self, block: usize) -> Option<f32> {
        self.known[block].then(|| self.theta[block])
    }

    /// Steps all blocks through a time, and returns what flows across the given pairs of blocks
    /// meanwhile.
    pub(crate) fn step(
        &mut self,
        seconds: f64,
        border: &[BorderPair],
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
        top: usize,
    ) -> BorderFluxes {
        let Self { conductances, stepper, theta, sources, .. } = self;
        let flow = |pair: &BorderPair| {
            let link = conductances.links[pair.axis][pair.lower()];
            BorderFlow { from: pair.inside, to: pair.outside, link, sum: 0.0 }
        };
        let mut flows: Vec<BorderFlow> = border.iter().map(flow).collect();
        let layers = block_grid.layers_below(top);
        stepper.advance(conductances, theta, sources, seconds, block_grid, layers, &mut flows);
        let sums = flows.iter().map(|flow| flow.sum);
        BorderFluxes::new(border.iter().zip(sums), seconds, block_grid, coefficients)
    }

    /// Adds the pending change, times a factor, to the voxels of a region, which are the inside of
    /// a patch.
    /// With factor 1 the voxels become current; with -1 current voxels become what the part stores.
    pub(crate) fn add_change(
        &mut self,
        factor: f32,
        patch: &mut Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
    ) {
        let Self { theta, reference, change, known, conductances, buffers, .. } = self;
        // Interpolation reads one block beyond the region, and `extend` three blocks further to
        // fill in those without voxels.
        for line in region.grown(4, block_grid).lines(block_grid) {
            let numbers =
                change[line.clone()].iter_mut().zip(&theta[line.clone()]).zip(&reference[line]);
            numbers.for_each(|((change, theta), reference)| *change = theta - reference);
        }
        interpolation::extend(change, known, region, block_grid, coefficients);
        let prolongation =
            Prolongation { blocks: change, inverse_voxels: &conductances.inverse_voxels, factor };
        prolongation.add(patch, region, block_grid, buffers);
    }
}
