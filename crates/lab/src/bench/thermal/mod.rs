//! `bench thermal`: the steppers of the heat equation, their errors, and how their time grows.

mod errors;
mod growth;
mod kernel;
mod parts;
mod patterns;

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::ensure;
use beadwork_base::Control;
use beadwork_console::{machine, output};
use beadwork_grid::Cell;
use beadwork_part::Pattern;
use beadwork_part::slice::Voxels;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use clap::ValueEnum;
use serde_json::json;

use self::growth::FOOT;
use crate::heat_parts::HeatPart;

/// Time, errors and growth of the thermal solver.
///
/// Parts are printed in ABS by the pattern `zigzag-x-0` without travel, so that births follow each
/// other.
/// Errors are those against a second-order stepper with four steps a birth.
///
/// Examples: beadwork bench thermal everything: about ten minutes beadwork bench thermal --what
/// parts --part u time and errors of one part beadwork bench thermal --what growth --cube 32 --cube
/// 64 --tower 32 beadwork bench thermal --what growth --svg growth.svg
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct ThermalArgs {
    /// What to measure; all by default.
    #[arg(long, value_name = "WHAT")]
    what: Vec<What>,
    /// Parts to measure; all by default.
    #[arg(long, value_name = "PART")]
    part: Vec<HeatPart>,
    /// Pattern of all layers.
    #[arg(long, value_name = "NAME", default_value = "zigzag-x-0")]
    pattern: Pattern,
    /// Sides of the cubes whose time is measured.
    #[arg(long = "cube", value_name = "VOXELS", default_values_t = [24, 32, 48, 64, 96, 128], value_parser = clap::value_parser!(u32).range(1..))]
    cubes: Vec<u32>,
    /// Heights of the towers whose time is measured, 64 x 64 voxels at their foot.
    #[arg(long = "tower", value_name = "VOXELS", default_values_t = [16, 32, 64, 128, 256, 512], value_parser = clap::value_parser!(u32).range(1..))]
    towers: Vec<u32>,
    /// Times each figure of parts is measured; the median is shown.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
    /// Draw the time for each birth against the voxels of the cubes and towers.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// The sweep of a static block against the memory it moves.
    Kernel,
    /// Time and errors of each method on the parts.
    Parts,
    /// All 38 patterns of each layer, and forks on two threads.
    Patterns,
    /// Time of cubes and of towers against their size.
    Growth,
}

pub(super) fn run(args: &ThermalArgs) -> anyhow::Result<()> {
    let wanted = |what: What| args.what.is_empty() || args.what.contains(&what);
    if let Some(path) = &args.svg {
        if !wanted(What::Growth) {
            output::usage_error("--svg draws the growth: add --what growth");
        }
        ensure!(!path.is_dir(), "'{}' is a folder", path.display());
    }
    let parts = if args.part.is_empty() { HeatPart::value_variants() } else { &args.part };
    let mut document = json!({ "machine": machine::facts(), "repeats": args.repeats, "pattern": args.pattern.name() });
    let mut text = format!(
        "Machine: {}. ABS, pattern {} without travel, medians of {} runs in turn.\n",
        machine::line(),
        args.pattern,
        args.repeats
    );
    if wanted(What::Kernel) {
        let kernel = kernel::measure(args.repeats)?;
        write!(text, "\n{kernel}")?;
        document["kernel"] = json!(kernel);
    }
    if wanted(What::Parts) {
        let rows = parts.iter().map(|&part| parts::measure(part, args.pattern, args.repeats));
        let rows = rows.collect::<anyhow::Result<Vec<_>>>()?.concat();
        write!(text, "\n{}", parts::table(&rows)?)?;
        document["parts"] = json!(rows);
    }
    if wanted(What::Patterns) {
        let patterns = patterns::measure()?;
        write!(text, "\n{patterns}")?;
        document["patterns"] = json!(patterns);
    }
    if wanted(What::Growth) {
        let cubes = args.cubes.iter().map(|&side| growth::measure([side; 3]));
        let cubes = cubes.collect::<anyhow::Result<Vec<_>>>()?;
        let towers = args.towers.iter().map(|&height| growth::measure([FOOT, FOOT, height]));
        let towers = towers.collect::<anyhow::Result<Vec<_>>>()?;
        write!(text, "\n{}\n{}", growth::table(&cubes)?, growth::table(&towers)?)?;
        if let Some(path) = &args.svg {
            output::file(path, growth::svg(&cubes, &towers)?)?;
        }
        document["growth"] = json!({ "cubes": cubes, "towers": towers });
    }
    if args.json { output::json(&document) } else { output::text(&text) }
}

const FAST: Method = Method::Fast(Accuracy::Standard);

/// The paper's process but without travel: births follow each other without a pause.
fn process() -> ProcessParameters {
    ProcessParameters { travel_mm_s: None, ..ProcessParameters::default() }
}

/// Prints a whole part, tells the seconds that took, and lets the state at each layer's end be
/// looked at meanwhile.
fn print(
    part: &Arc<Voxels>,
    orders: &[Vec<Cell>],
    method: Method,
    mut look: impl FnMut(usize, &Simulation),
) -> anyhow::Result<f64> {
    let mut simulation =
        Simulation::new(part.clone(), &ThermalMaterial::abs(), &process(), method)?;
    let mut seconds = 0.0;
    for (layer, order) in orders.iter().enumerate() {
        let begin = Instant::now();
        simulation.deposit(layer as u32, order, &Control::default())?;
        seconds += begin.elapsed().as_secs_f64();
        look(layer, &simulation);
    }
    Ok(seconds)
}
