//! Stand-in for plans of a trained policy, in builds without the feature `learn`.

use std::path::Path;

use anyhow::bail;
use beadwork_base::Control;
use beadwork_heat::model::Solver;
use beadwork_heat::plan::HeatPlan;
use beadwork_thermal::objective::Objective;

/// A policy: builds without the feature `learn` cannot have one.
pub(super) enum Policy {}

impl Policy {
    /// Always fails, with an error that explains how to get a build with networks.
    pub(super) fn open(_: &Path) -> anyhow::Result<Self> {
        bail!(
            "this build cannot run networks: use 'cargo xtask plan ... --planner ppo', which \
             builds one that can, or another planner"
        )
    }

    /// Never called: a [`Policy`] cannot exist.
    pub(super) fn objective(&self) -> Objective {
        match *self {}
    }

    /// Never called: a [`Policy`] cannot exist.
    pub(super) fn plan(&self, _: &Solver, _: f64, _: &Control<'_>) -> anyhow::Result<HeatPlan> {
        match *self {}
    }
}
