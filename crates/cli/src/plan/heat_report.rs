//! The results of a plan for even temperature, as JSON and as a summary.

use std::fmt::Write;

use beadwork_console::part::Part;
use beadwork_console::plan::Printed;
use beadwork_heat::bound::HeatBound;
use beadwork_heat::plan::HeatPlan;
use beadwork_thermal::objective::{HeatMeasures, Objective, Weighted};
use serde_json::{Value, json};

use super::args::{Files, PlannerName};
use super::totals::{Seconds, with_totals, write_totals};

pub(super) struct HeatReport<'a> {
    pub(super) part: &'a Part,
    pub(super) plan: &'a HeatPlan,
    pub(super) planner: PlannerName,
    pub(super) objective: &'a Weighted,
    /// Measures of the plan, and of the conventional order.
    pub(super) measures: &'a HeatMeasures,
    pub(super) baseline: &'a HeatMeasures,
    pub(super) bound: &'a HeatBound,
    /// Wall-clock time of the planner alone.
    pub(super) planning_seconds: f64,
    pub(super) printed: &'a Printed,
    pub(super) seconds: Seconds,
}

impl HeatReport<'_> {
    fn gain(&self, objective: Objective) -> Option<f64> {
        objective.gain_percent(self.measures, self.baseline)
    }

    /// All results; only the seconds differ between two runs.
    pub(super) fn json(&self) -> Value {
        let Self { part, plan, measures, baseline, printed, seconds, .. } = self;
        let frame = &part.layers.frame;
        let heat = json!({
            "planner": self.planner.to_string(),
            "objective": self.objective.to_string(),
            "reward": measures.reward(),
            "conventional_reward": baseline.reward(),
            "gain_percent": self.gain(Objective::Reward),
            "no_travel_gain_percent": self.gain(Objective::NoTravel),
            "time_averaged_gain_percent": self.gain(Objective::TimeAveraged),
            "warpage_mm": measures.warpage_mm,
            "conventional_warpage_mm": baseline.warpage_mm,
            "print_seconds": measures.print_seconds(),
            "conventional_print_seconds": baseline.print_seconds(),
            "planning_seconds": self.planning_seconds,
            // Of the gain if travel takes no time; by an argument, not a proof.
            "bound_percent": self.bound.any_order_percent(),
            "whole_lines_bound_percent": self.bound.whole_lines_percent(),
            "orders": (0..plan.layers.len()).map(|at| self.order_name(at)).collect::<Vec<_>>(),
        });
        let more = json!({
            "part": part.name,
            "remarks": part.remarks,
            "size_mm": part.bounds.size_mm(),
            "width": frame.width,
            "height": frame.height,
            "bead_mm": frame.cell_mm,
            "layer_mm": frame.layer_mm,
            "cells": part.layers.cell_count(),
            "heat": heat,
            "checked": { "layers": printed.checked.layers, "cells": printed.checked.cells },
            "seconds": seconds.json(),
        });
        with_totals(&printed.totals, more)
    }

    /// Name of the order of a planned layer.
    fn order_name(&self, layer: usize) -> String {
        let order = self.plan.layers[layer].order;
        order.map_or_else(|| "annealed lines".to_owned(), |order| order.to_string())
    }

    /// Title of the picture of a layer with cells.
    pub(super) fn layer_title(&self, number: usize) -> String {
        let filled = self.plan.layers.iter().enumerate().filter(|(_, l)| !l.path.is_empty());
        let layer = filled.map(|(layer, _)| layer).nth(number).unwrap_or(number);
        format!("layer {}: {}", layer + 1, self.order_name(layer))
    }

    /// A few lines of text.
    pub(super) fn summary(&self, files: &Files<'_>) -> String {
        let mut text = String::new();
        self.write(&mut text, files).expect("writing to a string succeeds");
        text
    }

    fn write(&self, text: &mut String, files: &Files<'_>) -> std::fmt::Result {
        let Self { part, measures, baseline, printed, seconds, .. } = self;
        let frame = &part.layers.frame;
        let [x, y, z] = part.bounds.size_mm();
        writeln!(
            text,
            "{}: {x:.1} x {y:.1} x {z:.1} mm, {} layers of up to {} x {} cells",
            part.name,
            self.plan.layers.len(),
            frame.width,
            frame.height,
        )?;
        let percent =
            |gain: Option<f64>| gain.map_or("-".to_owned(), |gain| format!("{gain:.1} %"));
        writeln!(
            text,
            "more even than the conventional order: {} at the layers' ends ({} if travel took no \
             time), {} on average over time",
            percent(self.gain(Objective::Reward)),
            percent(self.gain(Objective::NoTravel)),
            percent(self.gain(Objective::TimeAveraged)),
        )?;
        writeln!(
            text,
            "expected limit of the gain if travel took no time: {} for orders of whole lines, {} \
             for any order",
            percent(self.bound.whole_lines_percent()),
            percent(self.bound.any_order_percent()),
        )?;
        let longer = 100.0 * (measures.print_seconds() / baseline.print_seconds() - 1.0);
        write!(text, "printing time of the cells: {longer:+.1} %")?;
        if let (Some(lift), Some(before)) = (measures.warpage_mm, baseline.warpage_mm) {
            write!(
                text,
                "; estimated lift of the outline: {lift:.3} mm, conventional {before:.3} mm"
            )?;
        }
        writeln!(text)?;
        write_totals(text, &printed.totals)?;
        if let Some(gcode) = files.gcode {
            let (cells, beside) = (printed.checked.cells, files.beside());
            writeln!(
                text,
                "wrote {} (checked from its text: {cells} cells, each printed once){beside}",
                gcode.display()
            )?;
        }
        seconds.write(text)
    }
}
