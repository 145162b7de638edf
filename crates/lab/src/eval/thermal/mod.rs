//! `eval thermal`: the effect of the deposition pattern on temperatures, on parts like the paper's
//! (Kim et al. 2026).

mod part_row;
mod tables;

use beadwork_console::accuracy::AccuracyName;
use beadwork_console::{control, machine, output};
use serde_json::json;

use self::part_row::Setup;
use crate::heat_parts::HeatPart;

/// Compare the rewards of all 38 deposition patterns on parts like the paper's three, next to its
/// figures.
///
/// The reward of a layer is minus the standard deviation, at the end of the layer, of the
/// temperatures of all voxels deposited so far; the reward of a part is the sum over its layers
/// (Kim et al. 2026).
/// Each part is printed in ABS with the paper's settings: with each of the 38 patterns in all
/// layers, and greedily, each layer with the pattern that gives it the largest reward.
/// The paper does not state the sizes of its parts: ours are a cuboid of 120 x 40 x 12 voxels, a U
/// of 90 x 50 x 12 and a pyramid of 77 layers with a base of 60 x 60. Gains can therefore be
/// compared with the paper's, but rewards cannot.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork eval thermal
  beadwork eval thermal --part u --json > u.json")]
pub(super) struct ThermalArgs {
    /// Part to print; may be repeated; the paper's three by default.
    #[arg(long, value_name = "PART")]
    part: Vec<HeatPart>,
    /// Accuracy of the solver.
    #[arg(long, value_name = "NAME", default_value = "standard")]
    accuracy: AccuracyName,
    /// Threads; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

/// Prints all parts in all ways, and writes the tables to stdout.
pub(super) fn run(args: &ThermalArgs) -> anyhow::Result<()> {
    let parts = if args.part.is_empty() { &HeatPart::PAPER[..] } else { &args.part };
    let pool = control::pool(args.threads)?;
    let setup = Setup::new(args.accuracy.into());
    let rows = parts
        .iter()
        .map(|&part| setup.part_row(part, &pool))
        .collect::<anyhow::Result<Vec<_>>>()?;
    if args.json {
        let threads = pool.current_num_threads();
        return output::json(
            &json!({ "machine": machine::facts(), "threads": threads, "parts": rows }),
        );
    }
    output::text(&tables::text(&rows)?)
}
