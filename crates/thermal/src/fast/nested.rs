//! Patches that are stepped within a longer step of the patch around them.

use beadwork_base::Interrupted;

use crate::coefficients::Coefficients;
use crate::interval::Interval;
use crate::occupancy::VoxelChange;
use crate::patch::Patch;
use crate::run_control::RunControl;

use super::far::{BorderFluxes, FluxHalo};

/// A patch somewhere within a step of what is around it.
///
/// Its halo is the boundary condition of its shorter steps.
/// Where the surroundings are a patch that has taken the long step already, the halo is
/// interpolated linearly between both ends of that step (coarse-fine interface of local time
/// stepping), and for each shorter step it stands at the step's midpoint.
/// That is second order in time, like the steps themselves.
pub(super) struct NestedPatch<'a> {
    pub(super) patch: &'a mut Patch,
    /// Number of the run's changes that are applied to the patch.
    pub(super) applied: usize,
    source: HaloSource<'a>,
    /// Length of the step of the surroundings, s, ...
    outer_s: f64,
    /// ... and how much of it the patch has been stepped through.
    done_s: f64,
    /// Position in that step at which the halo stands, from 0 to 1.
    halo_at: f64,
    /// Control of the call, if the patch is the whole part.
    run: Option<&'a RunControl<'a>>,
}

/// Where the halo of a patch comes from.
#[derive(Clone, Copy)]
pub(super) enum HaloSource<'a> {
    /// The halo is constant: that of the whole part.
    Constant,
    /// The temperatures of the patch around, which is at the end of its step.
    Patch(&'a Patch),
    /// Fluxes across a closed border: one for each of several equal parts of the step.
    Fluxes { halo: &'a FluxHalo, parts: &'a [BorderFluxes] },
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
    /// Never returns one for a window: while a window is stepped, the rest of the part is ahead of
    /// it, so the part is not in a state that could be kept.
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

    /// Moves the halo to the midpoint of the next step, which takes `seconds`; the next call is for
    /// the step after that.
    /// Rows of the part from `top` on are empty.
    pub(super) fn advance_halo(&mut self, seconds: f64, top: usize) {
        let to = (self.done_s + seconds / 2.0) / self.outer_s;
        self.done_s += seconds;
        match self.source {
            HaloSource::Constant => {}
            HaloSource::Patch(outer) => {
                // The halo holds h = old + p (new - old) at position p, and is to hold the same at
                // position q.
                // That is h + (q - p) / (1 - p) (new - h), so the old values are not needed.
                let fraction = (to - self.halo_at) / (1.0 - self.halo_at);
                self.patch.advance_halo(outer, fraction as f32, top);
            }
            HaloSource::Fluxes { halo, parts } => {
                let part = (to * parts.len() as f64) as usize;
                halo.set(self.patch, &parts[part.min(parts.len() - 1)]);
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
