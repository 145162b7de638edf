//! Simulated prints of one part: with each pattern, and greedily.

use std::sync::Arc;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::progress::ProgressBar;
use beadwork_console::{control, progress};
use beadwork_grid::Cell;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::trials::try_orders;
use beadwork_part::Pattern;
use beadwork_part::slice::Voxels;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::section::Plane;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::warpage::WarpageEstimator;
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde::Serialize;

use crate::heat_parts::{HeatPart, all_orders};

/// One print of one part.
#[derive(Clone, Serialize)]
pub(super) struct SimulatedPrint {
    /// The pattern of all layers, or `greedy`.
    pub(super) pattern: String,
    /// Minus the sum over the layers of the standard deviation of temperatures, K.
    pub(super) reward: f64,
    /// Simulated printing time.
    pub(super) print_seconds: f64,
    /// Thermal deviation: maximum difference between a voxel and the mean, K, on the vertical
    /// section through the centre, [`REST_S`] after the nozzle has left the finished part.
    pub(super) deviation_k: f64,
}

/// All prints of one part.
#[derive(Serialize)]
pub(super) struct PartRow {
    pub(super) part: &'static str,
    pub(super) voxels: usize,
    pub(super) layers: usize,
    /// One print for each of the 38 patterns, sorted by their numbers.
    pub(super) patterns: Vec<SimulatedPrint>,
    pub(super) greedy: SimulatedPrint,
    /// The greedy choice for each layer.
    greedy_patterns: Vec<&'static str>,
    /// Estimated lift of the corners of the conventional, the best and the greedy print, mm.
    pub(super) lifts_mm: [f64; 3],
    /// Wall-clock time of all simulations.
    pub(super) seconds: f64,
}

impl PartRow {
    /// The print in the conventional pattern.
    pub(super) fn conventional(&self) -> &SimulatedPrint {
        &self.patterns[Pattern::CONVENTIONAL.number()]
    }

    /// The print with the largest reward among those of one pattern in all layers.
    pub(super) fn best(&self) -> &SimulatedPrint {
        &self.patterns[best_pattern(&self.patterns)]
    }
}

/// Number of the pattern with the largest reward; `prints` is sorted by the numbers of the
/// patterns.
fn best_pattern(prints: &[SimulatedPrint]) -> usize {
    (0..Pattern::COUNT)
        .max_by(|&a, &b| prints[a].reward.total_cmp(&prints[b].reward))
        .expect("there are 38 patterns")
}

/// Seconds between the end of a print and the measurement of its thermal deviation.
///
/// At the moment of the last deposition, the deviation would mostly measure how close the last
/// voxel is to the section.
const REST_S: f64 = 1.0;

/// Simulated seconds between two samples of the warpage estimate.
const SAMPLE_S: f64 = 0.5;

/// Solver, material and process of all prints.
pub(super) struct Setup {
    method: Method,
    material: ThermalMaterial,
    process: ProcessParameters,
}

impl Setup {
    /// ABS with the paper's settings.
    pub(super) fn new(accuracy: Accuracy) -> Self {
        Self {
            method: Method::Fast(accuracy),
            material: ThermalMaterial::abs(),
            process: ProcessParameters::default(),
        }
    }

    /// Prints one part with each pattern and greedily, in parallel on the pool.
    pub(super) fn part_row(&self, part: HeatPart, pool: &ThreadPool) -> anyhow::Result<PartRow> {
        let begin = Instant::now();
        let name = part.name();
        let part = Arc::new(part.voxels());
        let orders = all_orders(&part)?;
        let uniform_plan = |number: usize| {
            orders.iter().map(|orders| &orders[number][..]).collect::<Vec<&[Cell]>>()
        };
        // Steps of the bar: the layers of the greedy choice, all patterns, the greedy print and
        // three warpage estimates.
        let bar = progress::bar((Pattern::COUNT + part.depth + 4) as u64, name);
        let print = |&pattern: &Pattern| {
            let print = self.print(&part, pattern.name(), &uniform_plan(pattern.number()));
            bar.inc(1);
            print
        };
        let patterns = pool.install(|| {
            Pattern::ALL.par_iter().map(print).collect::<anyhow::Result<Vec<SimulatedPrint>>>()
        })?;
        let greedy_patterns = self.greedy_patterns(&part, &orders, pool, &bar)?;
        let greedy_plan: Vec<&[Cell]> = orders
            .iter()
            .zip(&greedy_patterns)
            .map(|(orders, pattern)| &orders[pattern.number()][..])
            .collect();
        let greedy = self.print(&part, "greedy", &greedy_plan)?;
        bar.inc(1);
        let plans = [
            uniform_plan(Pattern::CONVENTIONAL.number()),
            uniform_plan(best_pattern(&patterns)),
            greedy_plan,
        ];
        let lift_mm = |plan| {
            let lift_mm = self.corner_lift_mm(&part, plan);
            bar.inc(1);
            lift_mm
        };
        let lifts_mm = pool.install(|| {
            plans.par_iter().map(|plan| lift_mm(plan)).collect::<anyhow::Result<Vec<f64>>>()
        })?;
        bar.finish_and_clear();
        Ok(PartRow {
            part: name,
            voxels: part.count(),
            layers: part.depth,
            patterns,
            greedy,
            greedy_patterns: greedy_patterns.iter().map(|pattern| pattern.name()).collect(),
            lifts_mm: lifts_mm.try_into().expect("there are three plans"),
            seconds: begin.elapsed().as_secs_f64(),
        })
    }

    /// Chooses for each layer, from the bottom up, the pattern after which the standard deviation
    /// of all temperatures is smallest.
    ///
    /// `orders` holds the orders of all patterns for each layer.
    fn greedy_patterns(
        &self,
        part: &Arc<Voxels>,
        orders: &[Vec<Vec<Cell>>],
        pool: &ThreadPool,
        bar: &ProgressBar,
    ) -> anyhow::Result<Vec<Pattern>> {
        let control = control::cancellable(Threads::Pool(pool))?;
        let cost = LayerCost::of(Objective::Reward)?;
        let (material, process) = (&self.material, &self.process);
        let mut model = Solver::new(part.clone(), material, process, self.method, cost)?;
        let mut chosen = Vec::new();
        for (layer, orders) in (0..).zip(orders) {
            let trials = try_orders(&model, layer, orders, 1, |_, cost| cost, &control)?;
            trials.interrupted.map_or(Ok(()), Err)?;
            let best = trials.best.into_iter().next().expect("there are 38 patterns");
            model = best.model;
            chosen.push(Pattern::ALL[best.index]);
            bar.inc(1);
        }
        Ok(chosen)
    }

    fn simulation(&self, part: &Arc<Voxels>) -> anyhow::Result<Simulation> {
        Ok(Simulation::new(part.clone(), &self.material, &self.process, self.method)?)
    }

    /// Simulates one print; `plan` holds the order of each layer, `pattern` its name.
    fn print(
        &self,
        part: &Arc<Voxels>,
        pattern: &str,
        plan: &[&[Cell]],
    ) -> anyhow::Result<SimulatedPrint> {
        let control = control::cancellable(Threads::One)?;
        let mut simulation = self.simulation(part)?;
        let mut reward = 0.0;
        for (layer, order) in (0..).zip(plan) {
            simulation.deposit(layer, order, &control)?;
            reward -= simulation.statistics().map_or(0.0, |all| all.std_c);
        }
        let print_seconds = simulation.seconds();
        simulation.pause(REST_S, &control)?;
        let section = simulation.section(Plane::Y(part.frame.height / 2));
        Ok(SimulatedPrint {
            pattern: pattern.to_owned(),
            reward,
            print_seconds,
            deviation_k: section.max_deviation_k().unwrap_or(0.0),
        })
    }

    /// Estimated lift of the corners after one print, mm.
    fn corner_lift_mm(&self, part: &Arc<Voxels>, plan: &[&[Cell]]) -> anyhow::Result<f64> {
        let control = control::cancellable(Threads::One)?;
        let mut simulation = self.simulation(part)?;
        let mut warpage = WarpageEstimator::new(part, &self.material);
        for (layer, order) in (0..).zip(plan) {
            let events = simulation.layer_events(layer, order);
            let sample = |simulation: &Simulation| warpage.sample(simulation);
            simulation.run_sampled(&events, SAMPLE_S, sample, &control)?;
        }
        Ok(warpage.finish(&simulation, &control)?.corner_lift_mm)
    }
}
