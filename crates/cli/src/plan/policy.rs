//! Plans of a trained policy, in builds with the feature `learn`.

use std::path::Path;

use anyhow::Context;
use beadwork_base::Control;
use beadwork_heat::model::Solver;
use beadwork_heat::plan::HeatPlan;
use beadwork_learn::Device;
use beadwork_learn::ppo::{HeatPolicy, HeatPolicyError};
use beadwork_thermal::objective::Objective;

/// An opened policy.
pub(super) struct Policy(HeatPolicy);

impl Policy {
    /// Opens the policy in a folder.
    pub(super) fn open(folder: &Path) -> anyhow::Result<Self> {
        let policy = HeatPolicy::open(folder, Device::Cpu).with_context(|| {
            format!(
                "no policy in '{}': run in a checkout, which has models/ppo-small, or name a \
                 folder that 'train ppo random:policy' wrote by --policy",
                folder.display()
            )
        })?;
        Ok(Self(policy))
    }

    /// What it minimises.
    pub(super) fn objective(&self) -> Objective {
        self.0.task.objective
    }

    /// Plans a part that takes at most `max_seconds`.
    pub(super) fn plan(
        &self,
        unprinted: &Solver,
        max_seconds: f64,
        control: &Control<'_>,
    ) -> anyhow::Result<HeatPlan> {
        match self.0.plan(unprinted, max_seconds, control) {
            Err(error @ HeatPolicyError::TooSlow { .. }) => {
                Err(error).context("--max-time cannot be met; --planner ppo needs 1 or more")
            }
            plan => Ok(plan?),
        }
    }
}
