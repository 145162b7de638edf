//! Plans of a trained policy, for any part.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use beadwork_base::Control;
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::Solver;
use beadwork_heat::plan::{HeatPlan, PlannedLayer};
use beadwork_part::Order;
use beadwork_search::Stop;
use beadwork_thermal::objective::Objective;
use serde::{Deserialize, Serialize};
use tch::Device;
use thiserror::Error;

use super::super::environment::{Environment, Observation, Space};
use super::super::policy::{Kept, Policy, PolicyError};
use super::environment::HeatEnvironment;
use super::task::{HeatError, HeatSettings, HeatTask};

/// The task that a policy was trained for: the content of `task.toml` in its folder.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyTask {
    /// The orders that its actions stand for.
    pub orders: OrderSet,
    /// What it minimises.
    pub objective: Objective,
    /// Observed layers below the one that is printed next.
    pub depth: usize,
    /// Cells along each side of the observation.
    pub window: usize,
}

/// [`PolicyTask`] as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    orders: String,
    objective: String,
    depth: usize,
    window: usize,
}

impl PolicyTask {
    /// The file in a policy's folder, `task.toml`.
    pub fn file(folder: &Path) -> PathBuf {
        folder.join("task.toml")
    }

    /// The content of the file.
    pub fn to_toml(&self) -> String {
        let Self { orders, objective, depth, window } = *self;
        let (orders, objective) = (orders.to_string(), objective.to_string());
        let written = Written { orders, objective, depth, window };
        toml::to_string(&written).expect("a task is plain data")
    }

    /// Reads the content of the file; an error says what is wrong with it.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let written: Written = toml::from_str(text).map_err(|error| error.to_string())?;
        let Written { orders, objective, depth, window } = written;
        let task = Self {
            orders: orders.parse().map_err(|error| format!("{error}"))?,
            objective: objective.parse().map_err(|error| format!("{error}"))?,
            depth,
            window,
        };
        task.settings(None).check().map_err(|error| error.to_string())?;
        Ok(task)
    }

    /// Settings of the environment, with a limit on the printing time.
    pub fn settings(&self, max_time_ratio: Option<f64>) -> HeatSettings {
        let orders = self.orders.orders();
        // The conventional order is in each set.
        let baseline = orders.iter().position(|&order| order == Order::CONVENTIONAL).unwrap_or(0);
        HeatSettings {
            baseline,
            max_time_ratio,
            depth: self.depth,
            window: Some(self.window),
            ..HeatSettings::general()
        }
    }
}

/// A trained policy that chooses the order of each layer of any part.
#[derive(Debug)]
pub struct HeatPolicy {
    /// The policy.
    pub policy: Policy,
    /// What it was trained for.
    pub task: PolicyTask,
}

/// Why a policy cannot plan a part.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum HeatPolicyError {
    /// The policy cannot be opened.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The policy chooses among other orders or sees something else than its `task.toml` says.
    #[error("'{}': policy does not fit its task.toml", folder.display())]
    Space {
        /// Folder of the policy.
        folder: PathBuf,
    },
    /// The part cannot be printed.
    #[error(transparent)]
    Task(#[from] HeatError),
    /// The conventional order exceeds the limit on the printing time.
    #[error(
        "printing time limit of {limit:.1} s is too short: the conventional order, which completes \
         the plans of a policy, takes {conventional:.1} s"
    )]
    TooSlow {
        /// The limit, s.
        limit: f64,
        /// Printing time of the conventional order, s.
        conventional: f64,
    },
}

impl HeatPolicy {
    /// Opens a policy for any part in a folder: `config.toml`, `space.toml`, `task.toml` and the
    /// weights of the best evaluation, `greedy.safetensors`.
    pub fn open(folder: &Path, device: Device) -> Result<Self, HeatPolicyError> {
        let path = PolicyTask::file(folder);
        let text = fs::read_to_string(&path)
            .map_err(|cause| PolicyError::Unreadable { path: path.clone(), cause })?;
        let task = PolicyTask::from_toml(&text)
            .map_err(|message| PolicyError::Malformed { path, message })?;
        let policy = Policy::open(folder, Kept::Evaluation, device)?;
        let actions = task.orders.orders().len();
        let observation = task.settings(None).shapes([task.window; 2], actions);
        if policy.space != (Space { observation, actions }) {
            return Err(HeatPolicyError::Space { folder: folder.into() });
        }
        Ok(Self { policy, task })
    }

    /// Plans a part: the policy chooses the order of each layer.
    ///
    /// `unprinted` is a print of which nothing is deposited yet; costs in the plan are its costs,
    /// but the policy minimises what it was trained for.
    /// Deposits each layer once.
    ///
    /// The plan takes at most `max_seconds`: a candidate is chosen only if the conventional order
    /// of the layers above keeps to the limit then.
    /// At the end of each layer, the limit holds in proportion to the conventional order's time,
    /// unless only the conventional order is left.
    ///
    /// After an interruption, the conventional order is printed in all other layers.
    /// Progress counts layers.
    ///
    /// # Errors
    /// [`HeatPolicyError::TooSlow`] if the conventional order takes more than `max_seconds`.
    pub fn plan(
        &self,
        unprinted: &Solver,
        max_seconds: f64,
        control: &Control<'_>,
    ) -> Result<HeatPlan, HeatPolicyError> {
        let orders = self.task.orders.orders();
        let settings = self.task.settings(None);
        // Nothing that is observed depends on the baseline's costs, so it is not simulated.
        let unknown = vec![0.0; unprinted.part().depth];
        let mut task = HeatTask::named_with(unprinted.clone(), &orders, &settings, Some(&unknown))?;
        let conventional = task.baseline_seconds();
        if conventional > max_seconds {
            return Err(HeatPolicyError::TooSlow { limit: max_seconds, conventional });
        }
        if max_seconds.is_finite() && conventional > 0.0 {
            task.settings.max_time_ratio = Some(max_seconds / conventional);
        }
        let (task, baseline) = (Arc::new(task), settings.baseline);
        let choose = |environment: &HeatEnvironment, observation: &Observation| {
            let fits = environment.completable(max_seconds).into_iter();
            let permitted: Vec<bool> =
                observation.permitted.iter().zip(fits).map(|(&now, fits)| now && fits).collect();
            if permitted.contains(&true) {
                let tensors = observation.tensors.clone();
                self.policy.act(&Observation { tensors, permitted })
            } else {
                baseline
            }
        };
        let plan = follow(&task, &orders, choose, control);
        if plan.seconds() <= max_seconds {
            return Ok(plan);
        }
        // Times were summed in another order, and rounded differently.
        let stop = plan.stop;
        let plan = follow(&task, &orders, |_, _| baseline, &Control::default());
        Ok(HeatPlan { stop, ..plan })
    }
}

/// Prints a part in the orders that `choose` returns.
fn follow(
    task: &Arc<HeatTask>,
    orders: &[Order],
    choose: impl Fn(&HeatEnvironment, &Observation) -> usize,
    control: &Control<'_>,
) -> HeatPlan {
    let baseline = task.settings.baseline;
    let mut environment = HeatEnvironment::new(task.clone());
    let mut observation = environment.reset(0);
    let mut layers = Vec::with_capacity(task.layers.len());
    let mut stop = Stop::Done;
    for layer in &task.layers {
        if let Some(reason) = control.interrupted() {
            stop = reason.into();
        }
        if layer.orders[baseline].is_empty() {
            layers.push(PlannedLayer::empty());
            observation = environment.step(baseline).observation;
            continue;
        }
        let action =
            if stop.is_interrupted() { baseline } else { choose(&environment, &observation) };
        let before = environment.seconds();
        let step = environment.step(action);
        layers.push(PlannedLayer {
            path: layer.orders[action].clone(),
            order: Some(orders[action]),
            seconds: environment.seconds() - before,
            cost: layer.baseline_cost - step.reward / task.reward_scale,
        });
        observation = step.observation;
        control.report(layers.len(), task.layers.len());
    }
    HeatPlan { layers, stop, deposited_layers: task.layers.len() }
}
