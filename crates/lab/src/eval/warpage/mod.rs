//! `eval warpage`: the warpage estimate against published measurements, and against the objectives
//! of plans.

mod measured;
mod orders;
mod published;
mod tables;

use beadwork_base::Threads;
use beadwork_console::accuracy::AccuracyName;
use beadwork_console::{control, machine, output};
use beadwork_thermal::simulation::Method;
use clap::ValueEnum;
use serde_json::json;

use crate::heat_parts::HeatPart;

/// Compare the warpage estimate with published measurements, and with how even the temperatures of
/// a print are.
///
/// `measured` simulates prints whose warpage was measured and published, and reports the rank
/// correlation of the estimated lift with the measurements.
/// Measurements are only compared within one publication.
/// Where a publication, or the part of it that is at hand, gives an order instead of numbers, that
/// order is used; sizes that are not published are ours, and marked.
/// `heights` estimates blocks of one footprint and several heights.
/// `orders` prints parts like the three of Kim et al. (2026) with the 38 patterns and with 30
/// orders of lines, each in all layers, and reports the rank correlation of each objective with the
/// estimated lift: 1 if the plan that is better by the objective always lifts less.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork eval warpage --what measured
  beadwork eval warpage --what orders --part u --json > u.json")]
pub(super) struct WarpageArgs {
    /// Tables to compute; may be repeated; all by default.
    #[arg(long, value_name = "NAME")]
    what: Vec<What>,
    /// Part of the table `orders`; may be repeated; the paper's three by default.
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

/// A group of tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// Published measurements.
    Measured,
    /// Blocks of several heights.
    Heights,
    /// Objectives of many orders.
    Orders,
}

/// Computes the tables and writes them to stdout.
pub(super) fn run(args: &WarpageArgs) -> anyhow::Result<()> {
    let is_due = |what: What| args.what.is_empty() || args.what.contains(&what);
    let parts = if args.part.is_empty() { &HeatPart::PAPER[..] } else { &args.part };
    let pool = control::pool(args.threads)?;
    let control = control::cancellable(Threads::Pool(&pool))?;
    let method = Method::Fast(args.accuracy.into());
    let measured = is_due(What::Measured).then(|| measured::rows(method, &control)).transpose()?;
    let heights = is_due(What::Heights).then(|| measured::heights(method, &control)).transpose()?;
    let of_parts = || {
        let rows = parts.iter().map(|&part| orders::rows(part, method, &control));
        rows.collect::<anyhow::Result<Vec<_>>>()
    };
    let orders = is_due(What::Orders).then(of_parts).transpose()?;
    if args.json {
        let threads = pool.current_num_threads();
        return output::json(&json!({
            "machine": machine::facts(), "threads": threads,
            "measured": measured, "heights": heights, "orders": orders,
        }));
    }
    output::text(&tables::text(measured.as_ref(), heights.as_deref(), orders.as_deref())?)
}
