//! The results of a plan as JSON and as a summary.

use std::fmt::Write;

use beadwork_console::output::number;
use beadwork_console::part::Part;
use beadwork_console::plan::Printed;
use beadwork_console::text::count;
use beadwork_search::plan::tools::ToolPlan;
use serde_json::{Value, json};

use super::args::Files;
use super::totals::{Seconds, tower, with_totals, write_totals};

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
            "tower": tower(&printed.settings, totals),
            "seconds": seconds.json(),
        });
        with_totals(totals, more)
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
        write_totals(text, totals)?;
        if let Some(gcode) = files.gcode {
            let cells = printed.checked.cells;
            let beside = files.beside();
            writeln!(
                text,
                "wrote {} (checked from its text: {cells} cells, each printed once with the tool \
                 of its material){beside}",
                gcode.display()
            )?;
        }
        seconds.write(text)
    }
}
