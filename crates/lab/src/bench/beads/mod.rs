//! `bench beads`: run time of linking infill, and how good the order of beads is.

mod linking;
mod ordering;

use std::fmt::Write;
use std::path::PathBuf;

use beadwork_console::{control, machine, output};
use serde_json::json;

use crate::args::positive;

/// Measure the run time of linking infill lines by their number, and the travel of planned layers
/// beside long searches.
///
/// Lines fill gears with holes at 100 % density; all times are those of one thread.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench beads                              # about three minutes
  beadwork bench beads --svg linking.svg            # with a chart of the run times
  beadwork bench beads --lines 100 --lines 2000 --repeats 9
  beadwork bench beads heartgears.3mf torus.3mf     # also the order of the beads of 20 layers")]
pub(super) struct BeadsArgs {
    /// Parts (STL, 3MF or OBJ) of each of which up to 20 layers are ordered.
    #[arg(value_name = "PART")]
    parts: Vec<PathBuf>,
    /// About how many infill lines are linked; may be repeated.
    #[arg(
        long,
        value_name = "N",
        default_values_t = [100, 200, 500, 1000, 2000, 5000, 10_000, 20_000],
        value_parser = positive::<u32>()
    )]
    lines: Vec<u32>,
    /// Runs of each measurement, of which the median is reported.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = positive::<u64>())]
    repeats: u64,
    /// Draw the run times against the number of lines.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

/// Runs the measurements, and prints their tables.
pub(super) fn run(args: &BeadsArgs) -> anyhow::Result<()> {
    let linking = linking::measure(&args.lines, args.repeats)?;
    if let Some(path) = &args.svg {
        output::file(path, linking::svg(&linking)?)?;
    }
    let pool = control::pool(0)?;
    let ordering = args.parts.iter().map(|path| ordering::measure(path, &pool));
    let ordering = ordering.collect::<anyhow::Result<Vec<_>>>()?.concat();
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(), "repeats": args.repeats, "linking": linking,
            "ordering": ordering,
        }));
    }
    let mut text = format!(
        "Machine: {}. Medians of {} runs on one thread.\n\n{}",
        machine::line(),
        args.repeats,
        linking::table(&linking)?
    );
    if !ordering.is_empty() {
        write!(text, "\n{}", ordering::table(&ordering)?)?;
    }
    output::text(&text)
}
