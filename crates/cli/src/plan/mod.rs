//! `plan`: from meshes to G-code, with the fewest beads, tool changes and lifts, or with even
//! temperatures.

mod args;
mod bead_heat;
mod bead_heat_report;
mod bead_report;
mod beads;
mod drawing;
mod gains;
mod heat;
mod heat_report;
#[cfg_attr(not(feature = "learn"), path = "no_policy.rs")]
mod policy;
mod report;
mod totals;

use std::time::Instant;

use anyhow::{Context, bail};
use beadwork_base::Threads;
use beadwork_console::part::{CutPart, check_layers, report_lowering};
use beadwork_console::plan::{print, refs};
use beadwork_console::printer::{Profile, tool_costs};
use beadwork_console::{cancel, control, output};
use beadwork_part::print::Settings;
use beadwork_part::slice::{self, Layers};
use beadwork_search::CostMatrix;
use beadwork_search::plan::tools::{self, ToolPlan};
use rayon::ThreadPool;

pub(crate) use args::Args;

use report::Report;
use totals::Seconds;

/// Maximum number of grids that are planned: the best ones of those that were screened.
const PLANNED_GRIDS: usize = 4;

/// Plans a cut part, writes the files and reports the result.
type Run = fn(
    &Args,
    &args::Files<'_>,
    CutPart,
    &Profile,
    Settings,
    Instant,
    &ThreadPool,
) -> anyhow::Result<()>;

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let files = args.files()?;
    let is_for_heat = args.is_for_heat();
    let profile = args.profile.load()?;
    let pool = control::pool(args.threads)?;
    let begin = Instant::now();
    let cut = args.part.cut(profile.bed_mm(), &pool)?;
    profile.report_purge(&cut.model);
    let settings = profile.complete(&cut.model)?;
    let run = match (is_for_heat, args.has_beads()) {
        (true, true) => Some(bead_heat::run as Run),
        (true, false) => Some(heat::run as Run),
        (false, true) => Some(beads::run as Run),
        (false, false) => None,
    };
    if let Some(run) = run {
        return run(args, &files, cut, &profile, settings, begin, &pool);
    }
    let costs = tool_costs(settings.purge.as_ref().expect("complete settings have volumes"))?;
    let grids = args.grid.best(&cut, PLANNED_GRIDS, Threads::Pool(&pool))?;
    let sliced = begin.elapsed().as_secs_f64();
    let (grid, layers, plan) = cheapest(args, &cut, &grids, &costs, &pool)?;
    report_lowering(&layers);
    let part = cut.with_layers(layers, &grid, Threads::Pool(&pool))?;
    let planned = begin.elapsed().as_secs_f64();
    let printed = print(&part, &plan, &profile, settings, Threads::Pool(&pool))?;
    let done = begin.elapsed().as_secs_f64();
    let seconds = Seconds { slice: sliced, plan: planned - sliced, print: done - planned };
    let report = Report {
        part: &part,
        phase: grid.phase,
        grids: args.grid.count(),
        plan: &plan,
        printed: &printed,
        lift_cost: args.lift_cost,
        seconds,
    };
    check_cancelled()?;
    if let Some(path) = &args.svg {
        output::file(path, drawing::draw(&part, &plan, &printed.settings))?;
    }
    if let Some(path) = files.gcode {
        output::file(path, &printed.text)?;
    }
    let document = report.json();
    if let Some(path) = &files.totals {
        output::file(path, format!("{document:#}\n"))?;
    }
    if args.json { output::json(&document) } else { output::text(&report.summary(&files)) }
}

/// Plans the part on each of the grids; returns the cheapest plan with its grid and its layers.
///
/// Of equally cheap plans, the first one wins.
fn cheapest(
    args: &Args,
    cut: &CutPart,
    grids: &[slice::Settings],
    costs: &CostMatrix,
    pool: &ThreadPool,
) -> anyhow::Result<(slice::Settings, Layers, ToolPlan)> {
    let settings = args.settings();
    let mut best: Option<(slice::Settings, Layers, ToolPlan)> = None;
    for grid in grids {
        let layers = cut.layers(grid, Threads::Pool(pool))?;
        check_layers(&layers)?;
        let plan = control::with_bar("plan", Threads::Pool(pool), |control| {
            tools::solve(&refs(&layers), costs, &settings, control)
        })??;
        let is_cheaper = |(_, _, best): &(_, _, ToolPlan)| {
            plan.cost(settings.lift_cost) < best.cost(settings.lift_cost)
        };
        if best.as_ref().is_none_or(is_cheaper) {
            best = Some((*grid, layers, plan));
        }
    }
    best.context("no grid to plan on")
}

/// Returns an error if the user interrupted the command.
fn check_cancelled() -> anyhow::Result<()> {
    if cancel::token()?.is_cancelled() {
        bail!("stopped; nothing was written");
    }
    Ok(())
}
