//! `bench heat`: the proxy of a layer's temperatures against the solver, and the speed of both.

mod ranks;
mod steps;

use beadwork_console::accuracy::AccuracyName;
use beadwork_console::{control, machine, output};
use beadwork_part::Order;
use clap::ValueEnum;
use serde_json::json;

use crate::args::positive;
use crate::heat_parts::HeatPart;

/// Measure how well the proxy of a layer's temperatures ranks orders, and the speed of proxy and
/// solver.
///
/// Parts are printed in ABS with the paper's settings (Kim et al. 2026).
#[derive(clap::Args)]
#[command(after_help = "\
Ranks: layers below are printed in one order, then every named order of the layer is tried on the
solver and on the proxy.
The better half of a layer's orders is that of the lowest deviations by the solver.

Examples:
  beadwork bench heat
  beadwork bench heat --what ranks --part u --layer 6 --layer 11 --json
  beadwork bench heat --what steps --episodes 20")]
pub(super) struct HeatArgs {
    /// What to measure; may be repeated; everything by default.
    #[arg(long, value_name = "WHAT")]
    what: Vec<What>,
    /// Part to print; may be repeated; those that `eval heat` plans by default.
    #[arg(long, value_name = "PART")]
    part: Vec<HeatPart>,
    /// Layer whose orders are ranked, from 0; may be repeated; five from the first to the last by
    /// default.
    #[arg(long = "layer", value_name = "N")]
    layers: Vec<u32>,
    /// Order of the layers below.
    #[arg(long, value_name = "ORDER", default_value = "lines-x-scattered-7-0")]
    below: Order,
    /// Accuracy of the solver that ranks orders.
    #[arg(long, value_name = "NAME", default_value = "standard")]
    accuracy: AccuracyName,
    /// Episodes of each environment whose steps are counted.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = positive::<u32>())]
    episodes: u32,
    /// Threads that try orders; 0 for one per core; times are those of one thread.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Rank correlation of the proxy with the solver, and the time that each takes for an order.
    Ranks,
    /// Steps per second of environments that deposit one layer a step, on one thread and on two.
    Steps,
}

impl HeatArgs {
    fn measures(&self, what: What) -> bool {
        self.what.is_empty() || self.what.contains(&what)
    }
}

/// Runs the measurements that the arguments select, and prints their tables.
pub(super) fn run(args: &HeatArgs) -> anyhow::Result<()> {
    let parts = if args.part.is_empty() { &HeatPart::PLANNED[..] } else { &args.part };
    let mut document = json!({ "machine": machine::facts(), "below": args.below.to_string() });
    let mut text = format!("Machine: {}.\n", machine::line());
    if args.measures(What::Ranks) {
        let pool = control::pool(args.threads)?;
        let setup = ranks::Setup { below: args.below, accuracy: args.accuracy.into(), pool: &pool };
        let rows = parts.iter().map(|&part| setup.rows(part, &args.layers));
        let rows = rows.collect::<anyhow::Result<Vec<_>>>()?.concat();
        text += &ranks::table(&rows)?;
        document["ranks"] = json!(rows);
    }
    if args.measures(What::Steps) {
        let rows = parts.iter().map(|&part| steps::rows(part, args.episodes));
        let rows = rows.collect::<anyhow::Result<Vec<_>>>()?.concat();
        text += &steps::table(&rows)?;
        document["steps"] = json!(rows);
    }
    if args.json { output::json(&document) } else { output::text(&text) }
}
