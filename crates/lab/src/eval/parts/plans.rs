//! Tool changes and lifts in all modes, checked from the text of the G-code.

use std::fmt::Write;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_console::plan::{print, refs};
use beadwork_console::printer::{Profile, tool_costs};
use beadwork_console::progress::ProgressBar;
use beadwork_search::plan::tools::{self, Mode, Settings};
use serde::Serialize;

use super::cases::Case;

/// What a lift costs in these tables, in mm³; a change of tools purges 140.
const LIFT_COST: f64 = 2.0;

/// One part in one mode.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    mode: &'static str,
    tools: usize,
    layers: usize,
    cells: u64,
    /// Cells that the G-code prints, counted from its text: each once, with the tool of its zone,
    /// and nothing else.
    cells_checked: u64,
    tool_changes: u64,
    least_tool_changes: Option<u32>,
    fixed_order_changes: Option<u32>,
    lifts: u64,
    layers_optimal: usize,
    print_seconds: f64,
    grams: f64,
    purge_grams: f64,
    plan_seconds: f64,
    write_seconds: f64,
    frontier: Vec<(u64, u64)>,
}

pub(super) fn measure(
    cases: &[Case],
    seed: u64,
    pool: &rayon::ThreadPool,
    bar: &ProgressBar,
) -> anyhow::Result<Vec<Row>> {
    let profile = Profile::for_tables();
    let mut rows = Vec::new();
    for Case { name, part, .. } in cases {
        for (mode, mode_name) in
            [(Mode::Cheapest, "cheapest"), (Mode::Continuous, "continuous"), (Mode::Free, "free")]
        {
            let settings = profile.complete(&part.model.materials)?;
            let costs =
                tool_costs(settings.purge.as_ref().expect("complete settings have volumes"))?;
            let how = Settings { mode, seed, lift_cost: LIFT_COST, ..Settings::default() };
            let begin = Instant::now();
            let plan = control::quiet(Threads::Pool(pool), |control| {
                tools::solve(&refs(&part.layers), &costs, &how, control)
            })??;
            let plan_seconds = begin.elapsed().as_secs_f64();
            let begin = Instant::now();
            let printed = print(part, &plan, &profile, settings)?;
            let write_seconds = begin.elapsed().as_secs_f64();
            let tools = &printed.totals.tools;
            let purged = |tool: &beadwork_gcode::ToolUse| {
                tool.grams * tool.purge_mm / tool.filament_mm.max(1e-9)
            };
            rows.push(Row {
                part: name,
                mode: mode_name,
                tools: part.model.materials.len(),
                layers: plan.layers.len(),
                cells: part.layers.cell_count(),
                cells_checked: printed.checked.cells,
                tool_changes: plan.tool_changes(),
                least_tool_changes: Some(plan.order.min_changes),
                fixed_order_changes: Some(plan.fixed.changes),
                lifts: plan.lifts,
                layers_optimal: plan.layers.iter().filter(|layer| layer.is_optimal()).count(),
                print_seconds: printed.totals.print_seconds,
                grams: tools.iter().map(|tool| tool.grams).sum(),
                purge_grams: tools.iter().map(purged).sum(),
                plan_seconds,
                write_seconds,
                frontier: plan
                    .frontier
                    .iter()
                    .map(|point| (point.lifts, point.tool_cost as u64))
                    .collect(),
            });
        }
        bar.inc(1);
    }
    Ok(rows)
}

pub(super) fn tables(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "Tool changes and lifts; beads of 0.5 mm, layers of 0.25 mm, 140 mm³ purged a change, a lift at {LIFT_COST} mm³:\n"
    )?;
    writeln!(
        text,
        "| part | tools | layers | cells | mode | tool changes | at least | fixed order | lifts | layers proven optimal | cells printed once | hours | g (purged) | s to plan | s to write and check |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")?;
    let number =
        |value: Option<u32>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
    for row in rows {
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1} % | {} | {:.2} | {:.1} ({:.1}) | {:.2} | {:.2} |",
            row.part,
            row.tools,
            row.layers,
            row.cells,
            row.mode,
            row.tool_changes,
            number(row.least_tool_changes),
            number(row.fixed_order_changes),
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
        "\nLifts against purged mm³, at any price of a lift (corners of the frontier):\n"
    )?;
    for row in rows.iter().filter(|row| row.mode == "cheapest" && row.frontier.len() > 1) {
        let points: Vec<String> =
            row.frontier.iter().map(|(lifts, cost)| format!("{lifts}: {cost}")).collect();
        writeln!(text, "- {}: {}", row.part, points.join(", "))?;
    }
    Ok(())
}
