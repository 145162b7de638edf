//! The environment whose every episode prints another random part.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use beadwork_dataset::random_part::{self, RandomPartError, random_part};
use beadwork_heat::model::{LayerCost, ModelError, Solver};
use beadwork_part::Order;
use beadwork_part::slice::Voxels;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use super::super::environment::{Environment, Observation, Space, Step};
use super::super::range::require;
use super::environment::HeatEnvironment;
use super::task::{HeatError, HeatSettings, HeatTask};

/// Random parts, and how they are printed.
///
/// Environments share it by an [`Arc`].
/// Construct it by [`RandomHeatTask::new`].
#[derive(Clone, Debug)]
pub struct RandomHeatTask {
    /// What the parts are like.
    pub parts: random_part::Settings,
    /// Number of different parts, at least 1: those of the seeds below it.
    /// The baseline of each is simulated once.
    pub count: u64,
    /// The candidates for the order of each layer.
    pub orders: Vec<Order>,
    /// What a layer costs.
    pub cost: LayerCost,
    /// Settings of each part's task; [`HeatSettings::window`] must be set, so that observations of
    /// all parts are alike.
    /// [`HeatSettings::max_time_ratio`] is the maximum: half of the episodes have no limit, and the
    /// others a random one from 1 to this ratio; without it, no episode has a limit.
    pub settings: HeatSettings,
    /// Material that is printed.
    pub material: ThermalMaterial,
    /// Parameters of the print.
    pub process: ProcessParameters,
    /// Solver of the heat equation.
    pub method: Method,
}

/// Why random parts cannot be printed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RandomHeatError {
    /// Parts cannot be generated.
    #[error(transparent)]
    Part(#[from] RandomPartError),
    /// A part cannot be simulated.
    #[error(transparent)]
    Setup(#[from] ModelError),
    /// A part's task cannot be made.
    #[error(transparent)]
    Task(#[from] HeatError),
    /// Observations would differ in size.
    #[error("random parts differ in size: set a window, which gives observations one size")]
    NoWindow,
}

impl RandomHeatTask {
    /// 2048 parts of [`random_part::Preset::Policy`] in ABS, simulated at draft accuracy.
    pub fn new(orders: Vec<Order>, cost: LayerCost, settings: HeatSettings) -> Self {
        Self {
            parts: random_part::Settings::preset(random_part::Preset::Policy),
            count: 2048,
            orders,
            cost,
            settings,
            material: ThermalMaterial::abs(),
            process: ProcessParameters::default(),
            // Ranks orders as high accuracy does.
            method: Method::Fast(Accuracy::Draft),
        }
    }

    /// The part of a seed.
    pub fn part(&self, seed: u64) -> Result<Voxels, RandomPartError> {
        random_part(&self.parts, seed)
    }

    /// The task of printing the part of a seed, without a limit on the printing time.
    pub fn task(&self, seed: u64) -> Result<HeatTask, RandomHeatError> {
        self.task_with(seed, None, None)
    }

    /// The task of printing the part of a seed; the costs of the baseline may be known.
    fn task_with(
        &self,
        seed: u64,
        max_time_ratio: Option<f64>,
        baseline_costs: Option<&[f64]>,
    ) -> Result<HeatTask, RandomHeatError> {
        if self.settings.window.is_none() {
            return Err(RandomHeatError::NoWindow);
        }
        let part = Arc::new(self.part(seed)?);
        let Self { orders, cost, settings, material, process, method, .. } = self;
        let unprinted = Solver::new(part, material, process, *method, cost.clone())?;
        let settings = HeatSettings { max_time_ratio, ..*settings };
        Ok(HeatTask::named_with(unprinted, orders, &settings, baseline_costs)?)
    }
}

/// The limit of an episode: none in half of them, else a random one up to `ratio`.
fn limit(ratio: f64, seed: u64) -> Option<f64> {
    let number = ChaCha8Rng::seed_from_u64(seed).next_u64();
    let share = (number >> 12) as f64 / (1_u64 << 52) as f64;
    (number & 1 == 1).then_some(1.0 + (ratio - 1.0) * share)
}

/// The printing of random parts: the episode's seed chooses the part.
///
/// Observations, rewards and masks are those of a [`HeatEnvironment`] of the part.
#[derive(Clone, Debug)]
pub struct RandomHeatEnvironment {
    task: Arc<RandomHeatTask>,
    /// Costs of the baseline of the parts that were printed, shared with all clones.
    baselines: Arc<Mutex<HashMap<u64, Arc<[f64]>>>>,
    current: HeatEnvironment,
}

impl RandomHeatEnvironment {
    /// An environment that prints the part of seed 0.
    ///
    /// Clones are independent, but share what they know of the parts.
    pub fn new(task: Arc<RandomHeatTask>) -> Result<Self, RandomHeatError> {
        require(task.count > 0, "count", &task.count, "at least 1").map_err(HeatError::from)?;
        let current = HeatEnvironment::new(Arc::new(task.task(0)?));
        Ok(Self { task, baselines: Arc::default(), current })
    }

    /// The printing of the current part.
    pub fn current(&self) -> &HeatEnvironment {
        &self.current
    }
}

impl Environment for RandomHeatEnvironment {
    fn identity(&self) -> String {
        let RandomHeatTask { parts, count, orders, cost, settings, material, process, method } =
            &*self.task;
        let orders: Vec<String> = orders.iter().map(Order::to_string).collect();
        format!(
            "task = \"random heat\"\nparts = '{parts:?}'\ncount = {count}\norders = '{}'\n\
             cost = '{cost:?}'\nsettings = '{settings:?}'\nmaterial = '{material:?}'\n\
             process = '{process:?}'\nmethod = '{method:?}'",
            orders.join(" "),
        )
    }

    fn space(&self) -> Space {
        self.current.space()
    }

    /// # Panics
    /// If no part can be generated from the seed, which does not happen with settings that usually
    /// give one.
    fn reset(&mut self, seed: u64) -> Observation {
        let part = seed % self.task.count;
        let limit = self.task.settings.max_time_ratio.and_then(|ratio| limit(ratio, seed));
        let known = {
            let baselines = self.baselines.lock().unwrap_or_else(PoisonError::into_inner);
            baselines.get(&part).cloned()
        };
        let task = self.task.task_with(part, limit, known.as_deref());
        let task = task.expect("the settings gave a part before");
        if known.is_none() {
            let costs = task.layers.iter().map(|layer| layer.baseline_cost).collect();
            let mut baselines = self.baselines.lock().unwrap_or_else(PoisonError::into_inner);
            baselines.insert(part, costs);
        }
        self.current = HeatEnvironment::new(Arc::new(task));
        self.current.reset(seed)
    }

    fn step(&mut self, action: usize) -> Step {
        self.current.step(action)
    }

    fn score(&self, rewards: f64) -> f64 {
        self.current.score(rewards)
    }
}
