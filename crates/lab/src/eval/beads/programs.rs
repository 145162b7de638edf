//! The table of programs.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::Context;
use beadwork_base::Threads;
use beadwork_console::{control, machine, output};
use beadwork_gcode::{Filament, MotionLimits, Program};
use serde::Serialize;
use serde_json::json;

use super::BeadsArgs;
use super::count::BeadCounts;

/// One program.
#[derive(Serialize)]
struct Row {
    program: String,
    #[serde(flatten)]
    counts: BeadCounts,
}

/// Counts the programs and prints the table.
pub(super) fn run(args: &BeadsArgs) -> anyhow::Result<()> {
    let limits = MotionLimits {
        acceleration_mm_s2: args.acceleration,
        square_corner_mm_s: args.square_corner,
        max_speed_mm_s: args.max_speed,
    };
    // The density has no effect on counts.
    let filament = Filament { diameter_mm: args.filament_diameter, density_g_cm3: 1.0 };
    let rows = args
        .program
        .iter()
        .map(|path| row(path, limits, filament))
        .collect::<anyhow::Result<Vec<_>>>()?;
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "acceleration_mm_s2": args.acceleration,
            "square_corner_mm_s": args.square_corner,
            "max_speed_mm_s": args.max_speed,
            "filament_diameter_mm": args.filament_diameter,
            "programs": rows,
        }));
    }
    output::text(&table(&rows)?)
}

fn row(path: &Path, limits: MotionLimits, filament: Filament) -> anyhow::Result<Row> {
    let in_file = || format!("cannot use '{}'", path.display());
    let bytes = fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))?;
    let program = control::quiet(Threads::One, |control| Program::from_bytes(&bytes, control))?
        .with_context(in_file)?;
    let counts = control::quiet(Threads::One, |control| {
        BeadCounts::measure(&program, limits, filament, control)
    })?
    .with_context(in_file)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Row { program: name, counts })
}

fn table(rows: &[Row]) -> Result<String, std::fmt::Error> {
    let mut text = "| program | layers | beads | walls | infill | gap fill | other | joined \
                    | lifts | tool changes | travel, m | retractions | extruded, m \
                    | filament, mm³ | time, s |\n"
        .to_owned();
    writeln!(text, "|{}", "---|".repeat(15))?;
    for Row { program, counts } in rows {
        writeln!(
            text,
            "| {program} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.2} | {} | {:.2} \
             | {:.0} | {:.0} |",
            counts.layers,
            counts.beads,
            counts.walls,
            counts.infill,
            counts.gap_fill,
            counts.other,
            counts.joined,
            counts.lifts,
            counts.tool_changes,
            counts.travel_mm / 1000.0,
            counts.retractions,
            counts.extrusion_mm / 1000.0,
            counts.filament_mm3,
            counts.print_seconds
        )?;
    }
    Ok(text)
}
