//! Patches that are stepped within a step of what is around them.

use crate::law::Law;
use crate::occupancy::Change;
use crate::patch::Patch;

use super::far::{Flows, Rim};

/// A patch in the middle of a step of what is around it.
pub(super) struct Nested<'a> {
    pub(super) patch: &'a mut Patch,
    /// Changes that the patch has taken up.
    pub(super) known: usize,
    outer: Outer<'a>,
    /// Length of that step, s, and how much of it is over.
    step_s: f64,
    done_s: f64,
    /// How far the rim has moved, as a part of the step.
    rim: f64,
}

/// What the rim of a patch follows in a step of what is around it.
#[derive(Clone, Copy)]
pub(super) enum Outer<'a> {
    /// The rim of the whole part stays as it is.
    None,
    /// The temperatures of the patch around, which is at the end of its step.
    Patch(&'a Patch),
    /// What flows across in equal parts of the step.
    Far { rim: &'a Rim, flows: &'a [Flows] },
}

impl<'a> Nested<'a> {
    /// At the start of a step of so many seconds.
    pub(super) fn new(patch: &'a mut Patch, known: usize, outer: Outer<'a>, step_s: f64) -> Self {
        Self { patch, known, outer, step_s, done_s: 0.0, rim: 0.0 }
    }

    /// The whole part.
    pub(super) fn whole(patch: &'a mut Patch) -> Self {
        Self::new(patch, 0, Outer::None, 0.0)
    }

    /// Brings the rim to where it is in the middle of the next so many seconds, of which then is
    /// the end; rows of the part from `top` on are empty.
    pub(super) fn move_rim(&mut self, seconds: f64, top: usize) {
        let to = (self.done_s + seconds / 2.0) / self.step_s;
        self.done_s += seconds;
        match self.outer {
            Outer::None => {}
            Outer::Patch(outer) => {
                let part = (to - self.rim) / (1.0 - self.rim);
                self.patch.move_rim(outer, part as f32, top);
            }
            Outer::Far { rim, flows } => {
                let part = (to * flows.len() as f64) as usize;
                rim.set(self.patch, &flows[part.min(flows.len() - 1)]);
            }
        }
        self.rim = to;
    }

    pub(super) fn take_up(&mut self, changes: &[Change], law: &Law) {
        self.patch.take_up(&changes[self.known..], law);
        self.known = changes.len();
    }
}
