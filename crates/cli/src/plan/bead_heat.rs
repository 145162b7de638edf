//! Plans the beads of a part for even temperature.

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use beadwork_base::{Control, Threads};
use beadwork_console::beads::{BeadPart, PrintedBeads, print_beads};
use beadwork_console::part::CutPart;
use beadwork_console::printer::{Profile, tool_costs};
use beadwork_console::{control, output};
use beadwork_gcode::Program;
use beadwork_heat::fill::{BeadTiming, Beads, RowOrder};
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::plan::{HeatPlan, PlanError, conventional};
use beadwork_heat::planner::{self, Planner};
use beadwork_part::slice::Voxels;
use beadwork_part::{BeadLayer, TurnedBead, print};
use beadwork_search::plan::beads;
use beadwork_thermal::objective::{self, HeatMeasures, measure_events};
use beadwork_thermal::program::{self, program_events, program_voxels};
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use rayon::ThreadPool;

use super::args::{Args, Files, PlannerName};
use super::bead_heat_report::BeadHeatReport;
use super::gains::Gains;
use super::heat::{order_names, process};
use super::totals::Seconds;

/// Share of the part's voxels that a program may leave out: coordinates are rounded, and a bead
/// that ends at the side of a cell may visit it or not.
const LEFT_OUT: f64 = 0.01;

/// Plans to make until one keeps to the limit by the printing time of its program.
const ATTEMPTS: usize = 5;

/// The error of a limit that no plan keeps to.
const TOO_SLOW: &str = "--max-time cannot be met; the conventional order takes 1";

/// Beads in one order, and how even they are.
struct Candidate {
    layers: Vec<BeadLayer>,
    /// Names of the orders of the layers.
    orders: Vec<String>,
    printed: PrintedBeads,
    measures: HeatMeasures,
}

/// A part, and how it is printed and simulated.
struct HeatBeads<'a> {
    part: &'a BeadPart,
    profile: &'a Profile,
    settings: print::Settings,
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
    let PlannerName::Search(planner) = args.heat.planner() else { bail!("policies plan cells") };
    if settings.tools.len() > 1 {
        bail!(
            "part has several materials: --objective heat plans parts of one; --objective tools \
             plans all"
        );
    }
    let bead_mm = cut.settings.cell_mm;
    let part = cut.into_beads(&args.beads.toolpath(bead_mm), Threads::Pool(pool))?;
    let sliced = begin.elapsed().as_secs_f64();
    let (material, process) = (args.heat.material(), process(&settings, 0));
    let beads = HeatBeads { part: &part, profile, settings, material, process, pool };
    let listed = beads.listed(args)?;
    let (fill, voxels, baseline) = beads.conventional(&listed)?;
    let objective = args.heat.objective();
    let model = beads.model(&fill, &voxels, LayerCost::relative(&objective, &baseline)?)?;
    let planning = Instant::now();
    let best = beads.plan(args, planner, &model, (&fill, &voxels), &baseline)?;
    let planning_seconds = planning.elapsed().as_secs_f64();
    let planned = begin.elapsed().as_secs_f64() - sliced;
    super::check_cancelled()?;
    let report = BeadHeatReport {
        part: &part,
        printed: &best.printed,
        gains: Gains {
            planner: args.heat.planner(),
            objective: &objective,
            measures: &best.measures,
            baseline: &baseline,
            bound: None,
            planning_seconds,
            orders: best.orders,
        },
        // Programs are written and checked while plans are made, since only they have exact times.
        seconds: Seconds { slice: sliced, plan: planned, print: 0.0 },
    };
    if let Some(path) = &args.svg {
        output::file(path, super::beads::draw(&part, &best.layers, &best.printed.settings))?;
    }
    if let Some(path) = files.gcode {
        output::file(path, &best.printed.text)?;
    }
    let document = report.json();
    if let Some(path) = &files.totals {
        output::file(path, format!("{document:#}\n"))?;
    }
    if args.json { output::json(&document) } else { output::text(&report.text(files)) }
}

impl HeatBeads<'_> {
    /// The beads in the order of short travel.
    fn listed(&self, args: &Args) -> anyhow::Result<Vec<BeadLayer>> {
        let purge = self.settings.purge.as_ref().expect("complete settings have volumes");
        let costs = tool_costs(purge)?;
        let settings = beads::Settings {
            retraction: self.profile.retraction(),
            ..args.beads.plan(self.part.toolpath.bead_mm, args.seed)
        };
        let solve = |control: &Control<'_>| {
            beads::solve(&self.part.islands, &self.part.toolpath, &costs, &settings, control)
        };
        Ok(control::with_bar("beads", Threads::Pool(self.pool), solve)??.layers)
    }

    /// The fill of the listed beads, the voxels that it deposits, and their measures.
    fn conventional(
        &self,
        listed: &[BeadLayer],
    ) -> anyhow::Result<(Beads, Arc<Voxels>, HeatMeasures)> {
        let program = self.parse(&self.print(listed)?)?;
        let (bead_mm, layer_mm) = (self.part.toolpath.bead_mm, self.part.frame.layer_mm);
        let grid = control::quiet(Threads::Pool(self.pool), |control| {
            program_voxels(&program, bead_mm, layer_mm, control)
        })??;
        let (process, limits) = (self.settings.process, self.settings.printer.limits());
        let fill = Beads::new(listed, grid.frame, BeadTiming { process, limits });
        let voxels = Arc::new(fill.voxels());
        let measures = self.measure(&voxels, &program)?;
        Ok((fill, voxels, measures))
    }

    fn model(
        &self,
        fill: &Beads,
        voxels: &Arc<Voxels>,
        cost: LayerCost,
    ) -> anyhow::Result<Solver<Beads>> {
        let Self { material, process, .. } = self;
        let method = Method::Fast(Accuracy::Draft);
        Ok(Solver::of_fill(fill.clone(), voxels.clone(), material, process, method, cost)?)
    }

    /// Plans within `--max-time`, which holds for the printing time of the program.
    ///
    /// Planners estimate times, so the first plan shows how exact they are, and the limit on the
    /// estimates follows from it.
    fn plan(
        &self,
        args: &Args,
        planner: Planner,
        model: &Solver<Beads>,
        (fill, voxels): (&Beads, &Arc<Voxels>),
        baseline: &HeatMeasures,
    ) -> anyhow::Result<Candidate> {
        let threads = Threads::Pool(self.pool);
        let own_seconds = control::with_bar("conventional order", threads, |control| {
            conventional(model, control).map(|plan| plan.seconds())
        })??;
        let allowed = (args.heat.max_time() - 1.0) * baseline.print_seconds();
        let mut limit = (args.heat.max_time() - 1.0) * own_seconds;
        let mut best = None;
        for attempt in 0..ATTEMPTS {
            let default = planner::Settings::default();
            let settings = planner::Settings {
                planner,
                max_seconds: own_seconds + limit,
                seed: args.seed,
                annealing: default.annealing.clone().filter(|_| attempt > 0),
                ..default
            };
            let plan = control::with_bar("plan", threads, |control| {
                planner::plan(model, &settings, control)
            })?;
            let plan = match plan {
                Err(error @ PlanError::TooSlow { .. }) => return Err(error).context(TOO_SLOW),
                plan => plan?,
            };
            let candidate = self.candidate(&plan, fill, voxels)?;
            let estimate = plan.seconds() - own_seconds;
            let exact = candidate.measures.print_seconds() - baseline.print_seconds();
            if exact <= allowed {
                best = Some(candidate);
                if attempt > 0 {
                    break;
                }
            }
            limit = next_limit(limit, estimate, exact, allowed);
        }
        best.context(TOO_SLOW)
    }

    /// The program of a plan, and its measures.
    fn candidate(
        &self,
        plan: &HeatPlan<Vec<TurnedBead>, RowOrder>,
        fill: &Beads,
        voxels: &Arc<Voxels>,
    ) -> anyhow::Result<Candidate> {
        let beads = |number: usize| fill.beads(number as u32, &plan.layers[number].path);
        let layer = |number: usize| BeadLayer { number, beads: beads(number) };
        let layers: Vec<BeadLayer> = (0..plan.layers.len()).map(layer).collect();
        let printed = self.print(&layers)?;
        let measures = self.measure(voxels, &self.parse(&printed)?)?;
        Ok(Candidate { layers, orders: order_names(plan), printed, measures })
    }

    fn print(&self, layers: &[BeadLayer]) -> anyhow::Result<PrintedBeads> {
        let threads = Threads::Pool(self.pool);
        print_beads(self.part, layers, self.profile, self.settings.clone(), threads)
    }

    fn parse(&self, printed: &PrintedBeads) -> anyhow::Result<Program> {
        let parse = |control: &Control<'_>| Program::parse(&printed.text, control);
        Ok(control::quiet(Threads::Pool(self.pool), parse)??)
    }

    /// Measures a program by a simulation of high accuracy.
    fn measure(&self, voxels: &Arc<Voxels>, program: &Program) -> anyhow::Result<HeatMeasures> {
        let Self { material, process, pool, .. } = self;
        let limits = self.settings.printer.limits();
        let mapping = program::Settings { limits, tolerated_share: LEFT_OUT };
        let events = control::quiet(Threads::Pool(pool), |control| {
            program_events(program, voxels, &mapping, control)
        })??;
        let part = Arc::new(events.printed(voxels));
        let layers = events.layers();
        let settings = objective::Settings { warpage: true, ..objective::Settings::default() };
        let method = Method::Fast(Accuracy::High);
        control::with_bar("measure", Threads::Pool(pool), |control| {
            Ok(measure_events(&part, material, process, method, &layers, &settings, control)?)
        })?
    }
}

/// The next limit on the estimated time that a plan takes more than the conventional order, after a
/// plan that kept to `limit` by its estimate, but took `exact` of `allowed`; all in s.
fn next_limit(limit: f64, estimate: f64, exact: f64, allowed: f64) -> f64 {
    /// A little less than what is permitted, since the ratio varies.
    const SHARE: f64 = 0.98;
    let is_known = estimate > 0.0 && exact > 0.0 && allowed > 0.0;
    let scaled = if is_known { SHARE * allowed * estimate / exact } else { limit };
    // After an excess, the limit falls in any case.
    if exact > allowed { scaled.min(limit - 1.1 * (exact - allowed)) } else { scaled }
}

#[cfg(test)]
mod tests {
    use super::next_limit;

    #[test]
    fn limits_follow_the_ratio_of_estimates_to_exact_times() {
        assert!((next_limit(10.0, 9.0, 6.0, 10.0) - 14.7).abs() < 1e-9);
        assert!((next_limit(10.0, 10.0, 12.0, 10.0) - 7.8).abs() < 1e-9);
        // Nothing is permitted, or the plan is faster than the conventional order.
        assert!((next_limit(0.0, 0.0, 2.0, 0.0) + 2.2).abs() < 1e-9);
        assert!((next_limit(10.0, -1.0, -2.0, 10.0) - 10.0).abs() < 1e-9);
    }
}
