//! `bench thermal`: run time, errors and scaling of the thermal solver.

mod errors;
mod growth;
mod kernel;
mod parts;
mod patterns;
mod printing;

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::ensure;
use beadwork_console::{machine, output};
use beadwork_part::Pattern;
use clap::ValueEnum;
use serde_json::json;

use self::growth::BASE;
use crate::args::positive;
use crate::heat_parts::HeatPart;

/// Measure run time, errors and scaling of the thermal solver.
///
/// Parts are printed in ABS without travel, so that depositions follow each other without a pause.
/// Errors are relative to a second-order method with four steps per deposited voxel.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench thermal                                  # about ten minutes
  beadwork bench thermal --what parts --part u            # run time and errors on one part
  beadwork bench thermal --what growth --cube 32 --cube 64 --tower 32
  beadwork bench thermal --what growth --svg growth.svg")]
pub(super) struct ThermalArgs {
    /// What to measure; may be repeated; everything by default.
    #[arg(long, value_name = "WHAT")]
    what: Vec<What>,
    /// Part on which the methods are compared; may be repeated; all parts by default.
    #[arg(long, value_name = "PART")]
    part: Vec<HeatPart>,
    /// Pattern of all layers in that comparison.
    #[arg(long, value_name = "NAME", default_value = "zigzag-x-0")]
    pattern: Pattern,
    /// Side of a cube whose run time is measured, in voxels; may be repeated.
    #[arg(
        long = "cube",
        value_name = "VOXELS",
        default_values_t = [24, 32, 48, 64, 96, 128],
        value_parser = positive::<u32>()
    )]
    cubes: Vec<u32>,
    /// Height of a tower of 64 x 64 voxels whose run time is measured, in voxels; may be repeated.
    #[arg(
        long = "tower",
        value_name = "VOXELS",
        default_values_t = [16, 32, 64, 128, 256, 512],
        value_parser = positive::<u32>()
    )]
    towers: Vec<u32>,
    /// Runs of each measurement, of which the median is reported.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = positive::<u64>())]
    repeats: u64,
    /// Draw the run time per voxel against the size of the cubes and towers.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Speed of the sweep over a static block, relative to the memory traffic it causes.
    Kernel,
    /// Run time and errors of each method on the parts.
    Parts,
    /// Run time of trying all 38 patterns on each layer, on one thread and on two.
    Patterns,
    /// Run time of cubes and towers against their size.
    Growth,
}

impl ThermalArgs {
    fn measures(&self, what: What) -> bool {
        self.what.is_empty() || self.what.contains(&what)
    }

    /// Reports errors in the arguments before the long measurements begin.
    fn check(&self) -> anyhow::Result<()> {
        if let Some(path) = &self.svg {
            if !self.measures(What::Growth) {
                output::usage_error("--svg requires --what growth, whose results it draws");
            }
            ensure!(!path.is_dir(), "--svg '{}' is a folder, not a file", path.display());
        }
        Ok(())
    }
}

/// Runs the measurements that the arguments select, and prints their tables.
pub(super) fn run(args: &ThermalArgs) -> anyhow::Result<()> {
    args.check()?;
    let mut document = json!({
        "machine": machine::facts(), "repeats": args.repeats, "pattern": args.pattern.name(),
    });
    let mut text = format!(
        "Machine: {}. ABS, pattern {} without travel, medians of {} alternating runs.\n",
        machine::line(),
        args.pattern,
        args.repeats
    );
    if args.measures(What::Kernel) {
        let kernel = kernel::measure(args.repeats)?;
        write!(text, "\n{kernel}")?;
        document["kernel"] = json!(kernel);
    }
    if args.measures(What::Parts) {
        let parts = if args.part.is_empty() { HeatPart::value_variants() } else { &args.part };
        let rows = parts.iter().map(|&part| parts::measure(part, args.pattern, args.repeats));
        let rows = rows.collect::<anyhow::Result<Vec<_>>>()?.concat();
        write!(text, "\n{}", parts::table(&rows)?)?;
        document["parts"] = json!(rows);
    }
    if args.measures(What::Patterns) {
        let patterns = patterns::measure()?;
        write!(text, "\n{patterns}")?;
        document["patterns"] = json!(patterns);
    }
    if args.measures(What::Growth) {
        let cubes: Vec<_> = args.cubes.iter().map(|&side| [side; 3]).collect();
        let cubes = growth::measure(&cubes, "voxels of cubes")?;
        let towers: Vec<_> = args.towers.iter().map(|&height| [BASE, BASE, height]).collect();
        let towers = growth::measure(&towers, "voxels of towers")?;
        write!(text, "\n{}\n{}", growth::table(&cubes)?, growth::table(&towers)?)?;
        if let Some(path) = &args.svg {
            output::file(path, growth::svg(&cubes, &towers)?)?;
        }
        document["growth"] = json!({ "cubes": cubes, "towers": towers });
    }
    if args.json { output::json(&document) } else { output::text(&text) }
}
