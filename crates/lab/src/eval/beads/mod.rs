//! `eval beads`: beads, lifts and travel of programs, whichever slicer wrote them.

mod count;
mod programs;
mod shapes;
mod shapes_table;

use std::path::PathBuf;

use beadwork_console::output;

/// Count beads, lifts, travel and time of G-code, or list the shapes of the paper.
///
/// With --program, counts what any slicer's programs print, from the first to the last extrusion
/// move of the part: start and end sequences, skirts, supports and prime towers do not count as
/// beads.
/// A bead is an extrusion without travel of more than 0.01 mm in between; beads are sorted by the
/// features that the slicer's comments name.
/// Printing times are those of a printer with the given limits, at the speeds and accelerations
/// that the program sets.
///
/// Without --program, lists generated shapes like those of the paper about infill with fewer lifts
/// (ORNL toolpath RL), with the beads of their insets.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork eval beads
  beadwork eval beads --program part.gcode --program other_slicer.gcode --json")]
pub(super) struct BeadsArgs {
    /// G-code file; may be repeated.
    #[arg(long, value_name = "FILE")]
    program: Vec<PathBuf>,
    /// Acceleration in mm/s², where the program sets none.
    #[arg(long, value_name = "MM_S2", default_value_t = 1000.0)]
    acceleration: f64,
    /// Speed through a right-angled corner, in mm/s.
    #[arg(long, value_name = "MM_S", default_value_t = 5.0)]
    square_corner: f64,
    /// Maximum speed in mm/s.
    #[arg(long, value_name = "MM_S", default_value_t = 200.0)]
    max_speed: f64,
    /// Diameter of the filament in mm.
    #[arg(long, value_name = "MM", default_value_t = 1.75)]
    filament_diameter: f64,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

/// Counts the programs, or lists the shapes, and prints a table.
pub(super) fn run(args: &BeadsArgs) -> anyhow::Result<()> {
    if args.program.is_empty() {
        return shapes_table::run(args.json);
    }
    let is_positive = |value: f64| value > 0.0 && value.is_finite();
    if !is_positive(args.acceleration)
        || !is_positive(args.max_speed)
        || !is_positive(args.filament_diameter)
        || !(0.0..f64::INFINITY).contains(&args.square_corner)
    {
        output::usage_error(
            "--acceleration, --max-speed and --filament-diameter must be more than 0, \
             --square-corner at least 0",
        );
    }
    programs::run(args)
}
