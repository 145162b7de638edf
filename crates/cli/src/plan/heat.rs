//! Plans the cells of a part for even temperature.

use std::fmt::Display;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use beadwork_base::Threads;
use beadwork_console::part::{CutPart, check_layers, printed_voxels, report_lowering};
use beadwork_console::plan::print_paths;
use beadwork_console::printer::Profile;
use beadwork_console::{control, output};
use beadwork_grid::Path;
use beadwork_heat::bound::{HeatBound, heat_bound};
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::plan::{HeatPlan, PlanError, same_order};
use beadwork_heat::planner::{self, Settings};
use beadwork_part::print;
use beadwork_part::slice::{Layers, Voxels};
use beadwork_part::{Order, Panel, svg};
use beadwork_thermal::objective::{self, HeatMeasures, Objective, Weighted, measure_plan};
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use rayon::ThreadPool;

use super::args::{Args, Files, PlannerName};
use super::gains::Gains;
use super::heat_report::HeatReport;
use super::policy::Policy;
use super::totals::Seconds;

/// Maximum number of layers drawn: two rows.
const PANELS: usize = 6;

/// A part whose temperatures are simulated.
struct HeatPart<'a> {
    voxels: Arc<Voxels>,
    material: ThermalMaterial,
    process: ProcessParameters,
    pool: &'a ThreadPool,
}

/// Plans the part, writes the files and reports the result.
pub(super) fn run(
    args: &Args,
    files: &Files<'_>,
    cut: CutPart,
    profile: &Profile,
    settings: print::Settings,
    begin: Instant,
    pool: &ThreadPool,
) -> anyhow::Result<()> {
    let threads = Threads::Pool(pool);
    let grid = *args.grid.best(&cut, 1, threads)?.first().context("no grid to plan on")?;
    let layers = cut.layers(&grid, threads)?;
    check_layers(&layers)?;
    report_lowering(&layers);
    let voxels = printed_voxels(&layers);
    let tool = only_material(&voxels)?;
    let part = cut.with_layers(layers, &grid, threads)?;
    let heat = HeatPart {
        voxels: Arc::new(voxels),
        material: args.heat.material(),
        process: process(&settings, tool),
        pool,
    };
    let planner = args.heat.planner();
    let policy =
        (planner == PlannerName::Ppo).then(|| Policy::open(args.heat.policy())).transpose()?;
    let objective = match &policy {
        Some(policy) => Weighted::new(vec![(policy.objective(), 1.0)])?,
        None => args.heat.objective(),
    };
    let sliced = begin.elapsed().as_secs_f64();
    let conventional = heat.conventional()?;
    let baseline = heat.measure(&conventional)?;
    let planning = Instant::now();
    let max_seconds = args.heat.max_time() * conventional.seconds();
    let search = Settings { max_seconds, seed: args.seed, ..Settings::default() };
    let plan = if let PlannerName::Search(planner) = planner {
        heat.plan(&objective, &baseline, &Settings { planner, ..search })?
    } else {
        let annealing = search.annealing.clone().filter(|_| args.heat.refine());
        let search = Settings { annealing, ..search };
        heat.plan_by(policy.as_ref().context("no policy")?, &search)?
    };
    let planning_seconds = planning.elapsed().as_secs_f64();
    let measures = heat.measure(&plan)?;
    let bound = heat.bound()?;
    let planned = begin.elapsed().as_secs_f64();
    let paths = paths(&heat.voxels, &plan)?;
    let printed = print_paths(&part, paths.iter(), profile, settings, threads)?;
    let done = begin.elapsed().as_secs_f64();
    super::check_cancelled()?;
    let report = HeatReport {
        part: &part,
        plan: &plan,
        gains: Gains {
            planner,
            objective: &objective,
            measures: &measures,
            baseline: &baseline,
            bound: Some(&bound),
            planning_seconds,
            orders: order_names(&plan),
        },
        printed: &printed,
        seconds: Seconds { slice: sliced, plan: planned - sliced, print: done - planned },
    };
    if let Some(path) = &args.svg {
        output::file(path, draw(&part.layers, &paths, &report))?;
    }
    if let Some(path) = files.gcode {
        output::file(path, &printed.text)?;
    }
    let document = report.json();
    if let Some(path) = &files.totals {
        output::file(path, format!("{document:#}\n"))?;
    }
    if args.json { output::json(&document) } else { output::text(&report.summary(files)) }
}

/// Name of the order of each layer.
pub(super) fn order_names<P, N: Display>(plan: &HeatPlan<P, N>) -> Vec<String> {
    let name = |order: &Option<N>| {
        order.as_ref().map_or_else(|| "annealed lines".to_owned(), ToString::to_string)
    };
    plan.layers.iter().map(|layer| name(&layer.order)).collect()
}

/// The number of the material of all voxels.
fn only_material(voxels: &Voxels) -> anyhow::Result<u8> {
    let materials = voxels.materials();
    let mut materials = materials.iter().filter(|&&material| material != Voxels::EMPTY);
    let first = *materials.next().context("part has no cells")?;
    if let Some(other) = materials.find(|&&material| material != first) {
        bail!(
            "part has several materials (tools {first} and {other}): --objective heat plans parts \
             of one; --objective tools plans all"
        );
    }
    Ok(first)
}

/// The process of a profile; layers have one speed, which is not that of the first layer.
pub(super) fn process(settings: &print::Settings, tool: u8) -> ProcessParameters {
    let tool = settings.tools.get(usize::from(tool));
    let default = ProcessParameters::default();
    ProcessParameters {
        extrusion_c: tool.map_or(default.extrusion_c, |tool| tool.nozzle_c),
        plate_c: Some(settings.process.bed_c),
        print_mm_s: settings.process.print_mm_s,
        travel_mm_s: Some(settings.process.travel_mm_s),
        ..default
    }
}

impl HeatPart<'_> {
    fn solver(&self, cost: LayerCost) -> anyhow::Result<Solver> {
        let Self { voxels, material, process, .. } = self;
        // Draft accuracy ranks orders as high accuracy does, and the plan is measured by high.
        let method = Method::Fast(Accuracy::Draft);
        Ok(Solver::new(voxels.clone(), material, process, method, cost)?)
    }

    fn conventional(&self) -> anyhow::Result<HeatPlan> {
        let model = self.solver(LayerCost::of(Objective::Reward)?)?;
        control::with_bar("conventional order", Threads::Pool(self.pool), |control| {
            Ok(same_order(&model, Order::CONVENTIONAL, control)?)
        })?
    }

    /// The plan of a policy, with annealed lines if the settings have an annealing.
    fn plan_by(&self, policy: &Policy, settings: &Settings) -> anyhow::Result<HeatPlan> {
        let unprinted = self.solver(LayerCost::of(policy.objective())?)?;
        control::with_bar("plan", Threads::Pool(self.pool), |control| {
            let plan = policy.plan(&unprinted, settings.max_seconds, control)?;
            Ok(planner::refine(&unprinted, &plan, settings, control)?)
        })?
    }

    fn plan(
        &self,
        objective: &Weighted,
        baseline: &HeatMeasures,
        settings: &Settings,
    ) -> anyhow::Result<HeatPlan> {
        let model = self.solver(LayerCost::relative(objective, baseline)?)?;
        let plan = control::with_bar("plan", Threads::Pool(self.pool), |control| {
            planner::plan(&model, settings, control)
        })?;
        match plan {
            Err(error @ PlanError::TooSlow { .. }) => {
                Err(error).context("--max-time cannot be met; the conventional order takes 1")
            }
            plan => Ok(plan?),
        }
    }

    fn bound(&self) -> anyhow::Result<HeatBound> {
        let Self { voxels, material, process, pool } = self;
        let method = Method::Fast(Accuracy::Draft);
        control::with_bar("limit", Threads::Pool(pool), |control| {
            Ok(heat_bound(voxels, material, process, method, control)?)
        })?
    }

    /// Measures by a simulation of high accuracy.
    fn measure(&self, plan: &HeatPlan) -> anyhow::Result<HeatMeasures> {
        let settings = objective::Settings { warpage: true, ..objective::Settings::default() };
        let (method, orders) = (Method::Fast(Accuracy::High), plan.paths());
        let Self { voxels, material, process, pool } = self;
        control::with_bar("measure", Threads::Pool(pool), |control| {
            Ok(measure_plan(voxels, material, process, method, &orders, &settings, control)?)
        })?
    }
}

/// The paths of the layers that have cells.
fn paths(voxels: &Voxels, plan: &HeatPlan) -> anyhow::Result<Vec<Path>> {
    let printed = plan.layers.iter().enumerate().filter(|(_, layer)| !layer.path.is_empty());
    let path = |(z, layer): (usize, &beadwork_heat::plan::PlannedLayer)| {
        Ok(Path::in_pieces(&voxels.region(z)?, layer.path.clone())?)
    };
    printed.map(path).collect()
}

/// Draws up to [`PANELS`] layers from bottom to top.
fn draw(layers: &Layers, paths: &[Path], report: &HeatReport<'_>) -> String {
    let filled: Vec<_> = layers.layers.iter().flatten().collect();
    let count = filled.len();
    let shown: Vec<usize> = if count > PANELS {
        (0..PANELS).map(|panel| panel * (count - 1) / (PANELS - 1)).collect()
    } else {
        (0..count).collect()
    };
    let titles: Vec<String> = shown.iter().map(|&at| report.layer_title(at)).collect();
    let panels: Vec<Panel<'_>> = shown
        .iter()
        .zip(&titles)
        .map(|(&at, title)| Panel {
            title,
            region: &filled[at].region,
            zones: &filled[at].zones,
            path: Some(&paths[at]),
            links: &[],
        })
        .collect();
    svg(&panels, None)
}
