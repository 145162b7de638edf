//! The plans of one part, and their measures.

use std::sync::Arc;
use std::time::Instant;

use anyhow::bail;
use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_heat::bound::{HeatBound, heat_bound};
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::plan::{HeatPlan, same_order};
use beadwork_heat::planner::{Annealing, Planner, Settings, plan};
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order};
use beadwork_thermal::objective::{self, HeatMeasures, Objective, Weighted, measure_plan};
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use rayon::ThreadPool;
use serde::Serialize;

use super::fields::{Fields, PlaneDeviations, drawn};
use super::subject::Subject;

/// Time between samples of the final measures, s.
const SAMPLE_S: f64 = 0.1;

/// How parts are planned.
pub(super) struct Setup<'a> {
    pub(super) planners: &'a [Planner],
    pub(super) max_time: f64,
    pub(super) objective: &'a Weighted,
    /// The solver that planners try orders on.
    pub(super) method: Method,
    pub(super) annealing: Annealing,
    pub(super) seed: u64,
    pub(super) pool: &'a ThreadPool,
}

/// One plan of one part.
#[derive(Serialize)]
pub(super) struct PlanRow {
    /// The planner, and what it did beside its default.
    pub(super) planner: String,
    /// Minus the sum of the deviations at the layers' ends, K.
    pub(super) reward: f64,
    pub(super) reward_gain_percent: f64,
    pub(super) no_travel_gain_percent: f64,
    pub(super) time_averaged_gain_percent: f64,
    /// The same without the first layer.
    pub(super) later_time_averaged_gain_percent: f64,
    /// Estimated lift of the outline.
    pub(super) warpage_mm: f64,
    pub(super) print_seconds: f64,
    /// Wall-clock time of the planner.
    pub(super) planning_seconds: f64,
    /// Layers that the solver deposited for the planner.
    pub(super) deposited_layers: usize,
    /// Travel moves in the middle of a layer.
    pub(super) travel_moves: usize,
    /// Maximum thermal deviations on planes after the end, by the time since then.
    pub(super) plane_deviations: Vec<PlaneDeviations>,
    /// Order of each layer; `annealed` if it has no name.
    orders: Vec<String>,
    #[serde(skip)]
    pub(super) fields: Fields,
}

/// All plans of one part.
#[derive(Serialize)]
pub(super) struct PartRow {
    pub(super) part: String,
    /// Side and height of a voxel.
    pub(super) voxel_mm: [f64; 2],
    pub(super) voxels: usize,
    pub(super) layers: usize,
    /// Maximum number of connected components of a layer.
    pub(super) max_components: u32,
    /// Measures of the conventional order.
    pub(super) reward: f64,
    pub(super) warpage_mm: f64,
    pub(super) print_seconds: f64,
    pub(super) plane_deviations: Vec<PlaneDeviations>,
    /// Limits on the gain without travel, by an argument: orders of whole lines, and any order.
    pub(super) whole_lines_bound_percent: f64,
    pub(super) bound_percent: f64,
    /// Wall-clock time that they take.
    pub(super) bound_seconds: f64,
    pub(super) plans: Vec<PlanRow>,
    #[serde(skip)]
    pub(super) frame: Frame,
    #[serde(skip)]
    pub(super) fields: Fields,
}

impl PartRow {
    /// Name and fields of the conventional order, followed by those of all other plans.
    pub(super) fn fields(&self) -> Vec<(&str, &Fields)> {
        let conventional = Planner::Conventional.to_string();
        let others = self.plans.iter().filter(|plan| plan.planner != conventional);
        [("conventional", &self.fields)]
            .into_iter()
            .chain(others.map(|plan| (&plan.planner[..], &plan.fields)))
            .collect()
    }
}

impl Setup<'_> {
    /// Plans a part with each planner.
    pub(super) fn part_row(&self, part: Subject) -> anyhow::Result<PartRow> {
        let max_components = part.max_components()?;
        let voxels = Arc::new(part.voxels);
        let reward = self.solver(&voxels, LayerCost::of(Objective::Reward)?)?;
        let conventional = self.with_bar("conventional", |control| {
            Ok(same_order(&reward, Order::CONVENTIONAL, control)?)
        })?;
        let baseline = self.measure(&voxels, &conventional)?;
        let fields = self.fields(&voxels, &conventional)?;
        let begin = Instant::now();
        let bound = self.bound(&voxels)?;
        let bound_seconds = begin.elapsed().as_secs_f64();
        let objective = LayerCost::relative(self.objective, &baseline)?;
        let weighted = self.solver(&voxels, objective)?;
        let mut plans = Vec::new();
        for &planner in self.planners {
            let settings = Settings {
                planner,
                max_seconds: self.max_time * conventional.seconds(),
                seed: self.seed,
                annealing: Some(self.annealing.clone()),
                ..Settings::default()
            };
            if planner == Planner::Lines {
                let named = Settings { annealing: None, ..settings.clone() };
                let name = "lines, not annealed";
                plans.push(self.plan_row(name, &weighted, &named, &baseline)?);
                plans.push(self.plan_row("lines", &weighted, &settings, &baseline)?);
            } else {
                let orders = OrderSet::Patterns.orders();
                let settings = Settings { orders, ..settings };
                plans.push(self.plan_row(&planner.to_string(), &reward, &settings, &baseline)?);
            }
        }
        Ok(PartRow {
            part: part.name,
            voxel_mm: [voxels.frame.cell_mm, voxels.frame.layer_mm],
            voxels: voxels.count(),
            layers: voxels.depth,
            max_components,
            reward: baseline.reward(),
            warpage_mm: baseline.warpage_mm.unwrap_or(f64::NAN),
            print_seconds: baseline.print_seconds(),
            plane_deviations: fields.planes.clone(),
            whole_lines_bound_percent: bound.whole_lines_percent().unwrap_or(f64::NAN),
            bound_percent: bound.any_order_percent().unwrap_or(f64::NAN),
            bound_seconds,
            plans,
            frame: voxels.frame,
            fields,
        })
    }

    fn bound(&self, part: &Arc<Voxels>) -> anyhow::Result<HeatBound> {
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        self.with_bar("limit", |control| {
            Ok(heat_bound(part, &material, &process, self.method, control)?)
        })
    }

    fn solver(&self, part: &Arc<Voxels>, cost: LayerCost) -> anyhow::Result<Solver> {
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        Ok(Solver::new(part.clone(), &material, &process, self.method, cost)?)
    }

    fn plan_row(
        &self,
        name: &str,
        model: &Solver,
        settings: &Settings,
        baseline: &HeatMeasures,
    ) -> anyhow::Result<PlanRow> {
        let begin = Instant::now();
        let plan = self.with_bar("plan", |control| Ok(plan(model, settings, control)?))?;
        let planning_seconds = begin.elapsed().as_secs_f64();
        if plan.stop.is_interrupted() {
            bail!("stopped");
        }
        let part = Arc::new(model.part().clone());
        let measures = self.measure(&part, &plan)?;
        let fields = self.fields(&part, &plan)?;
        let gain =
            |objective: Objective| objective.gain_percent(&measures, baseline).unwrap_or(f64::NAN);
        Ok(PlanRow {
            planner: name.to_owned(),
            reward: measures.reward(),
            reward_gain_percent: gain(Objective::Reward),
            no_travel_gain_percent: gain(Objective::NoTravel),
            time_averaged_gain_percent: gain(Objective::TimeAveraged),
            later_time_averaged_gain_percent: {
                let (plan, baseline) = (later(&measures), later(baseline));
                Objective::TimeAveraged.gain_percent(&plan, &baseline).unwrap_or(f64::NAN)
            },
            warpage_mm: measures.warpage_mm.unwrap_or(f64::NAN),
            print_seconds: measures.print_seconds(),
            planning_seconds,
            deposited_layers: plan.deposited_layers,
            travel_moves: travel_moves(&plan, &part),
            plane_deviations: fields.planes.clone(),
            orders: plan
                .layers
                .iter()
                .map(|layer| layer.order.map_or("annealed".to_owned(), |order| order.to_string()))
                .collect(),
            fields,
        })
    }

    fn fields(&self, part: &Arc<Voxels>, plan: &HeatPlan) -> anyhow::Result<Fields> {
        self.with_bar("fields", |control| Fields::of(part, plan, &drawn(part), control))
    }

    /// Measures by a simulation of high accuracy.
    fn measure(&self, part: &Arc<Voxels>, plan: &HeatPlan) -> anyhow::Result<HeatMeasures> {
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let settings = objective::Settings {
            sample_s: Some(SAMPLE_S),
            warpage: true,
            ..objective::Settings::default()
        };
        let (method, orders) = (Method::Fast(Accuracy::High), plan.paths());
        self.with_bar("measure", |control| {
            Ok(measure_plan(part, &material, &process, method, &orders, &settings, control)?)
        })
    }

    fn with_bar<R>(
        &self,
        what: &'static str,
        call: impl FnOnce(&beadwork_base::Control<'_>) -> anyhow::Result<R>,
    ) -> anyhow::Result<R> {
        control::with_bar(what, Threads::Pool(self.pool), call)?
    }
}

/// The measures without the first layer.
fn later(measures: &HeatMeasures) -> HeatMeasures {
    HeatMeasures { layers: measures.layers[1..].to_vec(), ..measures.clone() }
}

/// Number of cells that follow a cell of the same layer which is not their neighbour.
fn travel_moves(plan: &HeatPlan, part: &Voxels) -> usize {
    let width = part.frame.width;
    let is_travel = |pair: &[u32]| {
        let (x, y) = (
            (pair[0] % width).abs_diff(pair[1] % width),
            (pair[0] / width).abs_diff(pair[1] / width),
        );
        x + y > 1
    };
    plan.layers
        .iter()
        .map(|layer| layer.path.windows(2).filter(|pair| is_travel(pair)).count())
        .sum()
}
