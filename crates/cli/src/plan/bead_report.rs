//! The results of a plan of beads as JSON and as a summary.

use std::fmt::Write;

use beadwork_console::beads::{BeadPart, PrintedBeads};
use beadwork_console::output::number;
use beadwork_console::text::count;
use beadwork_search::plan::beads::BeadPlan;
use serde_json::{Value, json};

use super::args::Files;
use super::totals::{Seconds, extended, tower, with_totals, write_totals};

pub(super) struct BeadSummary<'a> {
    pub(super) part: &'a BeadPart,
    pub(super) plan: &'a BeadPlan,
    pub(super) printed: &'a PrintedBeads,
    pub(super) seconds: Seconds,
}

impl BeadSummary<'_> {
    /// All results; only the seconds differ between two runs.
    pub(super) fn json(&self) -> Value {
        let Self { part, plan, printed, seconds } = self;
        let total = plan.total();
        let more = json!({
            "beads": total.beads,
            "bead_bound": total.bead_bound,
            "loops": total.loops,
            "skeletons": total.skeletons,
            "infill_beads": total.infill,
            "infill_bead_bound": total.infill_bound,
            "lifts": plan.lifts(),
            "bead_travel_mm": number(plan.travel_mm),
            "travel_bound_mm": plan.travel_bound_mm.map(number),
            "tool_cost": number(plan.order.cost),
            "bounds": {
                "tool_cost": number(plan.order.bound),
                "tool_changes": plan.order.min_changes,
                "regions": total.regions,
                "regions_optimal": total.optimal_regions,
            },
            "fixed_order": {
                "tool_cost": number(plan.fixed.cost),
                "tool_changes": plan.fixed.changes,
            },
            "tower": tower(&printed.settings, &printed.totals),
            "seconds": seconds.json(),
        });
        extended(of_beads(part, printed), more)
    }

    /// A few lines of text.
    pub(super) fn text(&self, files: &Files<'_>) -> String {
        let mut text = String::new();
        self.write(&mut text, files).expect("writing to a string succeeds");
        text
    }

    fn write(&self, text: &mut String, files: &Files<'_>) -> std::fmt::Result {
        let Self { part, plan, printed, seconds } = self;
        let total = plan.total();
        write_part(text, part, printed)?;
        let proof = |value: usize, bound: usize| {
            if value == bound { "proven minimum".to_owned() } else { format!("at least {bound}") }
        };
        writeln!(
            text,
            "{} ({}): {} of insets, {} of infill ({})",
            count(total.beads as u64, "bead"),
            proof(total.beads, total.bead_bound),
            total.loops,
            total.infill,
            proof(total.infill, total.infill_bound),
        )?;
        if total.skeletons > 0 {
            writeln!(text, "{} in thin walls and gaps", count(total.skeletons as u64, "skeleton"))?;
        }
        if printed.settings.tools.len() > 1 {
            writeln!(
                text,
                "{} ({}); with the tools in the same order in every layer: {}",
                count(plan.order.changes.into(), "tool change"),
                proof(plan.order.changes as usize, plan.order.min_changes as usize),
                plan.fixed.changes
            )?;
        }
        write_totals(text, &printed.totals)?;
        write_gcode(text, printed, files)?;
        seconds.write(text)
    }
}

/// What a program of beads prints, whatever it was planned for.
pub(super) fn of_beads(part: &BeadPart, printed: &PrintedBeads) -> Value {
    let toolpath = &part.toolpath;
    let fill: Vec<Value> =
        printed.checked.fill.iter().map(|fill| number(fill.ratio().unwrap_or(0.0))).collect();
    let more = json!({
        "part": part.name,
        "remarks": part.remarks,
        "size_mm": part.bounds.size_mm(),
        "bead_mm": toolpath.bead_mm,
        "layer_mm": part.frame.layer_mm,
        "density": number(100.0 * toolpath.density),
        "pattern": toolpath.pattern.name(),
        "perimeters": toolpath.perimeters,
        "materials": printed.settings.tools.iter().map(|tool| &tool.name).collect::<Vec<_>>(),
        "checked": {
            "layers": printed.checked.layers,
            "beads": printed.checked.beads,
            "dropped_beads": printed.checked.dropped_beads,
            "motions": printed.checked.motions,
            "fill": fill,
        },
    });
    with_totals(&printed.totals, more)
}

/// Writes a line about a part and how it is laid out.
pub(super) fn write_part(
    text: &mut String,
    part: &BeadPart,
    printed: &PrintedBeads,
) -> std::fmt::Result {
    let toolpath = &part.toolpath;
    let [x, y, z] = part.bounds.size_mm();
    writeln!(
        text,
        "{}: {x:.1} x {y:.1} x {z:.1} mm, {} layers, {}, {}, {} % {}",
        part.name,
        printed.checked.layers,
        count(printed.settings.tools.len() as u64, "material"),
        count(toolpath.perimeters.into(), "perimeter"),
        number(100.0 * toolpath.density),
        toolpath.pattern,
    )
}

/// Writes a line about the program, if it is written to a file.
pub(super) fn write_gcode(
    text: &mut String,
    printed: &PrintedBeads,
    files: &Files<'_>,
) -> std::fmt::Result {
    let Some(gcode) = files.gcode else { return Ok(()) };
    writeln!(
        text,
        "wrote {} (checked from its text: {} beads, each printed once, within the outlines){}",
        gcode.display(),
        printed.checked.beads,
        files.beside()
    )
}
