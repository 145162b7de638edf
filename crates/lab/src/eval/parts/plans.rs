//! Tool changes and lifts in all planning modes, checked in the text of the G-code.

use std::fmt::Write;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_console::plan::{print, refs};
use beadwork_console::printer::{Profile, tool_costs};
use beadwork_console::progress::ProgressBar;
use beadwork_gcode::ToolUse;
use beadwork_search::plan::tools::{self, Mode, Settings};
use rayon::ThreadPool;
use serde::Serialize;

use super::cases::Case;

/// Cost of a lift in these tables, in mm³ of purged filament; a tool change purges 140.
const LIFT_COST: f64 = 2.0;

/// One part in one mode.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    mode: &'static str,
    tools: usize,
    layers: usize,
    cells: u64,
    /// Cells that the G-code prints, according to the check of its text.
    /// The check fails unless each cell is printed once, with the tool of its zone, and nothing
    /// else is printed.
    cells_checked: u64,
    tool_changes: u64,
    /// Proven minimum of the tool changes in any mode.
    #[serde(rename = "least_tool_changes")]
    min_tool_changes: u32,
    /// Tool changes if each layer used its tools in rising order.
    fixed_order_changes: u32,
    lifts: u64,
    /// Layers whose path is proven optimal.
    layers_optimal: usize,
    print_seconds: f64,
    grams: f64,
    purge_grams: f64,
    plan_seconds: f64,
    /// Wall-clock time to write the G-code and to check its text.
    write_seconds: f64,
    /// Number of lifts and purge volume in mm³ at the corners of their Pareto frontier.
    frontier: Vec<(u64, u64)>,
}

/// Plans all parts in all modes.
pub(super) fn measure(
    cases: &[Case],
    seed: u64,
    pool: &ThreadPool,
    bar: &ProgressBar,
) -> anyhow::Result<Vec<Row>> {
    let profile = Profile::for_tables();
    let mut rows = Vec::new();
    for case in cases {
        for mode in [Mode::Cheapest, Mode::Continuous, Mode::Free] {
            rows.push(row(case, mode, seed, &profile, pool)?);
            bar.inc(1);
        }
    }
    Ok(rows)
}

fn row(
    Case { name, part, .. }: &Case,
    mode: Mode,
    seed: u64,
    profile: &Profile,
    pool: &ThreadPool,
) -> anyhow::Result<Row> {
    let control = control::cancellable(Threads::Pool(pool))?;
    let print_settings = profile.complete(&part.model)?;
    let costs = tool_costs(print_settings.purge.as_ref().expect("complete settings have volumes"))?;
    let settings = Settings { mode, seed, lift_cost: LIFT_COST, ..Settings::default() };
    let begin = Instant::now();
    let plan = tools::solve(&refs(&part.layers), &costs, &settings, &control)?;
    let plan_seconds = begin.elapsed().as_secs_f64();
    control.check()?;
    let begin = Instant::now();
    let printed = print(part, &plan, profile, print_settings, Threads::Pool(pool))?;
    let write_seconds = begin.elapsed().as_secs_f64();
    let tools = &printed.totals.tools;
    let purged = |tool: &ToolUse| tool.grams * tool.purge_mm / tool.filament_mm.max(1e-9);
    let frontier = plan.frontier.iter().map(|point| (point.lifts, point.tool_cost as u64));
    Ok(Row {
        part: name,
        mode: mode.name(),
        tools: part.model.materials.len(),
        layers: plan.layers.len(),
        cells: part.layers.cell_count(),
        cells_checked: printed.checked.cells,
        tool_changes: plan.tool_changes(),
        min_tool_changes: plan.order.min_changes,
        fixed_order_changes: plan.fixed.changes,
        lifts: plan.lifts,
        layers_optimal: plan.layers.iter().filter(|layer| layer.is_optimal()).count(),
        print_seconds: printed.totals.print_seconds,
        grams: tools.iter().map(|tool| tool.grams).sum(),
        purge_grams: tools.iter().map(purged).sum(),
        plan_seconds,
        write_seconds,
        frontier: frontier.collect(),
    })
}

pub(super) fn tables(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "Tool changes and lifts; beads of 0.5 mm, layers of 0.25 mm, 140 mm³ purged per tool \
         change, cost of a lift {LIFT_COST} mm³:\n\n\
         | part | tools | layers | cells | mode | tool changes | at least | fixed order | lifts \
         | layers proven optimal | cells printed once | hours | g (purged) | s to plan \
         | s to write and check |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    )?;
    for row in rows {
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1} % | {} | {:.2} | {:.1} ({:.1}) \
             | {:.2} | {:.2} |",
            row.part,
            row.tools,
            row.layers,
            row.cells,
            row.mode,
            row.tool_changes,
            row.min_tool_changes,
            row.fixed_order_changes,
            row.lifts,
            100.0 * row.layers_optimal as f64 / row.layers as f64,
            if row.cells == row.cells_checked { "all" } else { "NOT ALL" },
            row.print_seconds / 3600.0,
            row.grams,
            row.purge_grams,
            row.plan_seconds,
            row.write_seconds,
        )?;
    }
    writeln!(
        text,
        "\nNumber of lifts: purged mm³, for all costs of a lift (corners of the frontier):\n"
    )?;
    for row in rows.iter().filter(|row| row.mode == "cheapest" && row.frontier.len() > 1) {
        let points: Vec<String> =
            row.frontier.iter().map(|(lifts, cost)| format!("{lifts}: {cost}")).collect();
        writeln!(text, "- {}: {}", row.part, points.join(", "))?;
    }
    Ok(())
}
