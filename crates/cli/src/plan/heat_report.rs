//! The results of a plan for even temperature, as JSON and as a summary.

use std::fmt::Write;

use beadwork_console::part::Part;
use beadwork_console::plan::Printed;
use beadwork_heat::plan::HeatPlan;
use serde_json::{Value, json};

use super::args::Files;
use super::gains::Gains;
use super::totals::{Seconds, with_totals, write_totals};

pub(super) struct HeatReport<'a> {
    pub(super) part: &'a Part,
    pub(super) plan: &'a HeatPlan,
    pub(super) gains: Gains<'a>,
    pub(super) printed: &'a Printed,
    pub(super) seconds: Seconds,
}

impl HeatReport<'_> {
    /// All results; only the seconds differ between two runs.
    pub(super) fn json(&self) -> Value {
        let Self { part, gains, printed, seconds, .. } = self;
        let frame = &part.layers.frame;
        let more = json!({
            "part": part.name,
            "remarks": part.remarks,
            "size_mm": part.bounds.size_mm(),
            "width": frame.width,
            "height": frame.height,
            "bead_mm": frame.cell_mm,
            "layer_mm": frame.layer_mm,
            "cells": part.layers.cell_count(),
            "heat": gains.json(),
            "checked": { "layers": printed.checked.layers, "cells": printed.checked.cells },
            "seconds": seconds.json(),
        });
        with_totals(&printed.totals, more)
    }

    /// Title of the picture of a layer with cells.
    pub(super) fn layer_title(&self, number: usize) -> String {
        let filled = self.plan.layers.iter().enumerate().filter(|(_, l)| !l.path.is_empty());
        let layer = filled.map(|(layer, _)| layer).nth(number).unwrap_or(number);
        format!("layer {}: {}", layer + 1, self.gains.orders[layer])
    }

    /// A few lines of text.
    pub(super) fn summary(&self, files: &Files<'_>) -> String {
        let mut text = String::new();
        self.write(&mut text, files).expect("writing to a string succeeds");
        text
    }

    fn write(&self, text: &mut String, files: &Files<'_>) -> std::fmt::Result {
        let Self { part, gains, printed, seconds, .. } = self;
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
        gains.write(text, "the cells")?;
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
