//! `eval`: tables beside the papers' figures.

mod exact_tables;
mod growth;
mod paper_tables;

use std::path::PathBuf;

use beadwork_search::Preset;
use clap::Subcommand;

use crate::search::MethodName;

/// Print tables beside the papers' figures.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Zones(ZonesArgs),
}

/// Crossings over the 24 cells of Aali et al.: their Tables 3 and 5, or what is proven of the fewest.
#[derive(clap::Args)]
#[command(after_help = "\
With --method anneal or zigzag: the tables of means run the preset 'paper', then 'medium' to 'extra_long', on the instances of seeds 0, 1, 2, ...; the table of
bests runs all presets on instances whose zigzag crosses within 10 % as often as the paper's.

With --method exact: how often the fewest crossings are proven, and in what time, on the instances of seeds 0, 1, 2, ... of the 24 cells, of
harder and larger layouts and of masks; each instance one after the other, bound included; zigzag and annealing beside it.

Examples:
  beadwork eval zones --method anneal
  beadwork eval zones --method anneal --seeds 100 --json > anneal.json
  beadwork eval zones --method exact --seeds 20
  beadwork eval zones --method exact --json --plot growth.svg > exact.json")]
struct ZonesArgs {
    /// How to choose the paths.
    #[arg(long, value_name = "METHOD", default_value = "anneal")]
    method: MethodName,
    /// Seeds per cell and preset.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Presets, with commas; all if not given.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    presets: Vec<Preset>,
    /// Exact: only small planes, to see that all is in order.
    #[arg(long)]
    smoke: bool,
    /// Exact: draw how the time grows with cells and with zones.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Threads of annealing; 0 for one a core. The exact search is timed on one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document, with a row for each run.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.what {
        What::Zones(args) if args.method == MethodName::Exact => exact_tables::run(args),
        What::Zones(args) => paper_tables::run(args),
    }
}
