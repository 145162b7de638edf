//! Patches that are stepped within a step of what is around them.

use beadwork_base::Interrupted;

use crate::coefficients::Coefficients;
use crate::interval::Interval;
use crate::occupancy::Change;
use crate::patch::Patch;
use crate::run_control::RunControl;

use super::far::{BorderFluxes, FluxHalo};

/// A patch in the middle of a step of what is around it.
pub(super) struct NestedPatch<'a> {
    pub(super) patch: &'a mut Patch,
    /// Changes that the patch has taken up.
    pub(super) known: usize,
    outer: HaloSource<'a>,
    /// Length of that step, s, and how much of it is over.
    step_s: f64,
    done_s: f64,
    /// How far the halo has moved, as a part of the step.
    halo: f64,
    /// Control of the call, if the patch is the whole part.
    run: Option<&'a RunControl<'a>>,
}

/// What the halo of a patch follows in a step of what is around it.
#[derive(Clone, Copy)]
pub(super) enum HaloSource<'a> {
    /// The halo of the whole part stays as it is.
    None,
    /// The temperatures of the patch around, which is at the end of its step.
    Patch(&'a Patch),
    /// What flows across in equal parts of the step.
    Far { halo: &'a FluxHalo, flows: &'a [BorderFluxes] },
}

impl<'a> NestedPatch<'a> {
    /// At the start of a step of so many seconds.
    pub(super) fn new(
        patch: &'a mut Patch,
        known: usize,
        outer: HaloSource<'a>,
        step_s: f64,
    ) -> Self {
        Self { patch, known, outer, step_s, done_s: 0.0, halo: 0.0, run: None }
    }

    /// The whole part.
    pub(super) fn whole(patch: &'a mut Patch, run: &'a RunControl<'a>) -> Self {
        Self { run: Some(run), ..Self::new(patch, 0, HaloSource::None, 0.0) }
    }

    /// Returns an error if the call should end before a step of `stages` stages; rows of the part
    /// from `top` on are empty.
    ///
    /// Never for a window: while it is stepped, the rest of the part is ahead of it.
    pub(super) fn poll(&self, stages: usize, top: usize) -> Result<(), Interrupted> {
        let updates = stages * self.patch.shape.row * self.patch.shape.planes * top;
        self.run.map_or(Ok(()), |run| run.poll(updates))
    }

    /// Notes that the whole part has been stepped through some intervals.
    pub(super) fn pass(&self, intervals: &[Interval]) {
        let Some(run) = self.run else { return };
        for interval in intervals {
            run.pass(interval.seconds);
            run.complete(interval);
        }
    }

    /// Brings the halo to where it is in the middle of the next so many seconds, of which then is
    /// the end; rows of the part from `top` on are empty.
    pub(super) fn advance_halo(&mut self, seconds: f64, top: usize) {
        let to = (self.done_s + seconds / 2.0) / self.step_s;
        self.done_s += seconds;
        match self.outer {
            HaloSource::None => {}
            HaloSource::Patch(outer) => {
                let part = (to - self.halo) / (1.0 - self.halo);
                self.patch.advance_halo(outer, part as f32, top);
            }
            HaloSource::Far { halo, flows } => {
                let part = (to * flows.len() as f64) as usize;
                halo.set(self.patch, &flows[part.min(flows.len() - 1)]);
            }
        }
        self.halo = to;
    }

    pub(super) fn apply(&mut self, changes: &[Change], coefficients: &Coefficients) {
        self.patch.apply(&changes[self.known..], coefficients);
        self.known = changes.len();
    }
}
