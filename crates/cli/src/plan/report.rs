//! The results of a plan as JSON and as a summary.

use std::fmt::Write;

use beadwork_console::output::number;
use beadwork_console::part::Part;
use beadwork_console::plan::Printed;
use beadwork_console::text::{count, duration};
use beadwork_search::plan::tools::ToolPlan;
use serde_json::{Value, json};

use super::args::Files;

/// Wall-clock time of the steps, in s.
pub(super) struct Seconds {
    /// Reading, repairing and slicing.
    pub(super) slice: f64,
    /// Planning.
    pub(super) plan: f64,
    /// Writing and checking the G-code.
    pub(super) print: f64,
}

pub(super) struct Report<'a> {
    pub(super) part: &'a Part,
    /// Position of the grid relative to the part, in fractions of a cell.
    pub(super) phase: [f64; 2],
    /// Number of grids tried.
    pub(super) grids: usize,
    pub(super) plan: &'a ToolPlan,
    pub(super) printed: &'a Printed,
    pub(super) lift_cost: u32,
    pub(super) seconds: Seconds,
}

impl Report<'_> {
    /// All results; only the seconds differ between two runs.
    pub(super) fn json(&self) -> Value {
        let Self { part, phase, grids, plan, printed, lift_cost, seconds } = self;
        let frame = &part.layers.frame;
        let totals = &printed.totals;
        let continuous = plan.layers.iter().filter(|layer| layer.is_continuous);
        let optimal = plan.layers.iter().filter(|layer| layer.is_optimal()).count();
        let kept_links = plan.layers.iter().filter_map(|layer| layer.kept_links);
        let purge = printed.settings.purge.as_ref();
        let tower = purge.and_then(|purge| purge.tower).filter(|_| totals.prime_tower_mm > 0.0);
        let mut value = json!(totals);
        let more = json!({
            "part": part.name,
            "remarks": part.remarks,
            "size_mm": part.bounds.size_mm(),
            "width": frame.width,
            "height": frame.height,
            "bead_mm": frame.cell_mm,
            "layer_mm": frame.layer_mm,
            "grid_phase": phase,
            "grids_tried": grids,
            "cells": part.layers.cell_count(),
            "materials": printed.settings.tools.iter().map(|tool| &tool.name).collect::<Vec<_>>(),
            "tool_cost": number(plan.tool_cost),
            "lift_cost": lift_cost,
            "cost": number(plan.cost((*lift_cost).into())),
            "bounds": {
                "tool_cost": number(plan.order.bound),
                "tool_changes": plan.order.min_changes,
                "layers_optimal": optimal,
            },
            "fixed_order": {
                "tool_cost": number(plan.fixed.cost),
                "tool_changes": plan.fixed.changes,
            },
            "continuous_layers": continuous.count(),
            "frontier": plan.frontier.iter().map(|point| json!({
                "lifts": point.lifts,
                "tool_cost": number(point.tool_cost),
                "up_to_lift_cost": point.up_to_lift_cost,
            })).collect::<Vec<_>>(),
            "kept_links": kept_links.map(u64::from).sum::<u64>(),
            "checked": { "layers": printed.checked.layers, "cells": printed.checked.cells },
            "tower": tower.map(|tower| json!({
                "left_mm": tower.left_mm, "front_mm": tower.front_mm, "width_mm": tower.width_mm,
            })),
            "seconds": {
                "slice": seconds.slice,
                "plan": seconds.plan,
                "print": seconds.print,
            },
        });
        if let (Value::Object(value), Value::Object(more)) = (&mut value, more) {
            value.extend(more);
        }
        value
    }

    /// A few lines of text.
    pub(super) fn summary(&self, files: &Files<'_>) -> String {
        let mut text = String::new();
        self.write(&mut text, files).expect("writing to a string succeeds");
        text
    }

    fn write(&self, text: &mut String, files: &Files<'_>) -> std::fmt::Result {
        let Self { part, plan: planned, printed, seconds, .. } = self;
        let (frame, totals) = (&part.layers.frame, &printed.totals);
        let [x, y, z] = part.bounds.size_mm();
        writeln!(
            text,
            "{}: {x:.1} x {y:.1} x {z:.1} mm, {} layers of up to {} x {} cells, {}",
            part.name,
            planned.layers.len(),
            frame.width,
            frame.height,
            count(printed.settings.tools.len() as u64, "material"),
        )?;
        if self.grids > 1 {
            let [x, y] = self.phase;
            let (bead, grids) = (frame.cell_mm, self.grids);
            writeln!(text, "beads of {bead:.4} mm, grid phase {x}, {y}: best of {grids} grids")?;
        }
        let min_changes = planned.order.min_changes;
        let bound = if u64::from(min_changes) == planned.tool_changes() {
            " (proven minimum)".to_owned()
        } else {
            format!(" (at least {min_changes})")
        };
        let optimal = planned.layers.iter().filter(|layer| layer.is_optimal()).count();
        writeln!(
            text,
            "{}{bound}, {}; {optimal} of {} layers proven optimal",
            count(planned.tool_changes(), "tool change"),
            count(planned.lifts, "lift"),
            planned.layers.len(),
        )?;
        if printed.settings.tools.len() > 1 {
            writeln!(
                text,
                "with the tools in the same order in every layer: {}",
                count(planned.fixed.changes.into(), "tool change")
            )?;
        }
        let grams: f64 = totals.tools.iter().map(|tool| tool.grams).sum();
        writeln!(
            text,
            "{} to print, {grams:.1} g, {:.1} m of beads, {:.1} m of travel",
            duration(totals.print_seconds),
            totals.extrusion_mm / 1000.0,
            totals.travel_mm / 1000.0,
        )?;
        if let Some(gcode) = files.gcode {
            let cells = printed.checked.cells;
            let beside = files
                .totals
                .as_ref()
                .map_or_else(String::new, |totals| format!(" and {}", totals.display()));
            writeln!(
                text,
                "wrote {} (checked from its text: {cells} cells, each printed once with the tool \
                 of its material){beside}",
                gcode.display()
            )?;
        }
        let Seconds { slice, plan, print } = seconds;
        writeln!(
            text,
            "{slice:.2} s to slice, {plan:.2} s to plan, {print:.2} s to write and check"
        )
    }
}
