//! `eval beads`: methods that link infill, and beads, lifts and travel of any slicer's programs.

mod cases;
mod count;
mod drawing;
mod methods;
mod neighbours;
mod programs;
mod shapes;
mod shapes_table;
mod starts;
mod surface;
mod tables;

use std::path::PathBuf;

use beadwork_console::output;

/// Compare methods that link infill lines to beads, or count the beads of G-code.
///
/// Lays out parts, or generated shapes like those of the paper about infill with fewer lifts (ORNL
/// toolpath RL), with two insets and infill lines.
/// Links the lines by each method, and orders the beads of all methods in the same way.
/// NN is nearest neighbour from a random start; break points is the method of the paper; repetitive
/// NN starts at all ends (in regions of more than 300 lines, at break points); cover finds the
/// fewest beads.
///
/// With --program, counts what any slicer's programs print, from the first to the last extrusion
/// move of the part: start and end sequences, skirts, supports and prime towers do not count as
/// beads.
/// A bead is an extrusion without travel of more than 0.01 mm in between; beads are sorted by the
/// features that the slicer's comments name.
/// Printing times are those of a printer with the given limits, at the speeds and accelerations
/// that the program sets.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork eval beads --svg .
  beadwork eval beads torus.3mf yin_yang.3mf@90 --density 20,100 --json
  beadwork eval beads --program part.gcode --program other_slicer.gcode --json")]
pub(super) struct BeadsArgs {
    /// Mesh files or built-in examples; PART@DEGREES is rotated about x.
    /// The shapes of the paper by default.
    #[arg(value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Infill densities in per cent.
    #[arg(long, value_name = "PERCENT", default_value = "20", value_delimiter = ',')]
    density: Vec<f64>,
    /// Draw each shape with nearest neighbour and with cover, as SHAPE.svg in this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Threads; 0 for one per core.
    /// Only times depend on them.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// G-code file; may be repeated.
    #[arg(long, value_name = "FILE", conflicts_with = "parts")]
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

/// Counts the programs, or compares methods, and prints tables.
pub(super) fn run(args: &BeadsArgs) -> anyhow::Result<()> {
    if args.program.is_empty() {
        return tables::run(args);
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
