//! Patches that are stepped within a longer step of the patch around them.

use beadwork_base::Interrupted;

use crate::coefficients::Coefficients;
use crate::interval::Interval;
use crate::occupancy::VoxelChange;
use crate::patch::Patch;
use crate::run_control::RunControl;

use super::far::{BorderFluxes, FluxHalo};

/// A patch that has been stepped through a fraction of a longer step of its surroundings.
///
/// Its halo is the boundary condition of its shorter steps.
/// Where the surroundings are a patch that has taken the long step already, the halo is
/// interpolated linearly in time between both ends of that step (coarse-fine interface of local
/// time stepping).
/// Each shorter step uses the halo at its midpoint, which is second order in time, like the steps
/// themselves.
pub(super) struct NestedPatch<'a> {
    pub(super) patch: &'a mut Patch,
    /// Number of the run's changes that are applied to the patch.
    pub(super) applied: usize,
    source: HaloSource<'a>,
    /// Length of the step of the surroundings, s.
    outer_s: f64,
    /// Time within that step up to which the patch has been stepped, s.
    done_s: f64,
    /// Time to which the halo is interpolated, as a fraction of that step.
    halo_at: f64,
    /// Control of the call, if the patch is the whole part.
    run: Option<&'a RunControl<'a>>,
}

/// Where the halo of a patch comes from.
#[derive(Clone, Copy)]
pub(super) enum HaloSource<'a> {
    /// The halo is constant: that of the whole part.
    Constant,
    /// The temperatures of the surrounding patch, which is at the end of its step.
    Patch(&'a Patch),
    /// Fluxes across a closed border, one set for each of several equal substeps.
    Fluxes { halo: &'a FluxHalo, substeps: &'a [BorderFluxes] },
}

impl<'a> NestedPatch<'a> {
    /// A patch at the start of a step of `outer_s` seconds.
    pub(super) fn new(
        patch: &'a mut Patch,
        applied: usize,
        source: HaloSource<'a>,
        outer_s: f64,
    ) -> Self {
        Self { patch, applied, source, outer_s, done_s: 0.0, halo_at: 0.0, run: None }
    }

    /// The whole part, with nothing around it.
    pub(super) fn whole(patch: &'a mut Patch, run: &'a RunControl<'a>) -> Self {
        Self { run: Some(run), ..Self::new(patch, 0, HaloSource::Constant, 0.0) }
    }

    /// Returns an error if the call should end before a step of `stages` stages; rows of the part
    /// from `top` on are empty.
    ///
    /// Never returns an error for a window: while a window is stepped, the rest of the part is
    /// ahead of it in time, which is not a valid state to stop in.
    pub(super) fn poll(&self, stages: usize, top: usize) -> Result<(), Interrupted> {
        let updates = stages * self.patch.shape.row_len * self.patch.shape.planes * top;
        self.run.map_or(Ok(()), |run| run.poll(updates))
    }

    /// Records that the whole part has been stepped through some intervals; does nothing for a
    /// window.
    pub(super) fn pass(&self, intervals: &[Interval]) {
        let Some(run) = self.run else { return };
        for interval in intervals {
            run.pass(interval.seconds);
            run.complete(interval);
        }
    }

    /// Moves the halo to the midpoint of the next step, which takes `seconds`.
    /// Must be called once for each step, in order.
    /// Rows of the part from `top` on are empty.
    pub(super) fn advance_halo(&mut self, seconds: f64, top: usize) {
        let to = (self.done_s + seconds / 2.0) / self.outer_s;
        self.done_s += seconds;
        match self.source {
            HaloSource::Constant => {}
            HaloSource::Patch(outer) => {
                // At time p, the halo holds h = old + p (new - old).
                // At time q it must hold old + q (new - old), which equals h + (new - h) (q - p) /
                // (1 - p): the old values are not needed.
                let fraction = (to - self.halo_at) / (1.0 - self.halo_at);
                self.patch.advance_halo(outer, fraction as f32, top);
            }
            HaloSource::Fluxes { halo, substeps } => {
                let substep = (to * substeps.len() as f64) as usize;
                halo.set(self.patch, &substeps[substep.min(substeps.len() - 1)]);
            }
        }
        self.halo_at = to;
    }

    /// Applies those of the run's changes that the patch does not have yet.
    pub(super) fn apply(&mut self, changes: &[VoxelChange], coefficients: &Coefficients) {
        self.patch.apply(&changes[self.applied..], coefficients);
        self.applied = changes.len();
    }
}
