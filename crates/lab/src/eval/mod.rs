//! `eval`: tables beside the papers' figures, and of whole parts.

mod anneal_tables;
mod crossovers;
mod exact_tables;
#[cfg(feature = "learn")]
mod fusion;
mod growth;
mod paper_tables;
mod parts;
mod statistics;
mod store;
mod table;
mod thermal;

use std::path::PathBuf;

use beadwork_console::search::MethodName;
use beadwork_console::{control, output};
use beadwork_search::anneal::Preset;
use clap::Subcommand;

/// Print tables beside the papers' figures, and of whole parts.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Zones(ZonesArgs),
    Parts(parts::PartsArgs),
    Thermal(thermal::ThermalArgs),
    #[cfg(feature = "learn")]
    Fusion(fusion::FusionArgs),
}

/// Crossings over the 24 cells of Aali et al.: their Tables 1, 3 and 5 by every method, or one
/// method looked at closely.
#[derive(clap::Args)]
#[command(after_help = "\
Without --method: zigzag, annealing, the genetic algorithm and the exact search on the same instances, those whose \
zigzag crosses within 10 % as often as the paper's. Tables, numbers, convergence plots and heat maps are left in --out; \
an interrupted run goes on when the same command is run again.

With --method anneal or zigzag: the tables of means run the preset 'paper', then 'medium' to 'extra_long', on the \
instances of seeds 0, 1, 2, ...; the table of bests runs all presets on instances like the paper's.

With --method genetic: one-point, two-point and window crossover on the same first populations, with confidence \
intervals. It, too, goes on where it was interrupted.

With --method exact: how often the fewest crossings are proven, and in what time, on the instances of seeds 0, 1, 2, \
... of the 24 cells, of harder and larger layouts and of masks; each instance one after the other, bound included; \
zigzag and annealing beside it.

Examples:
  beadwork eval zones
  beadwork eval zones --seeds 30 --out /data/eval-zones --json > zones.json
  beadwork eval zones --method anneal
  beadwork eval zones --method genetic --out /data/crossovers
  beadwork eval zones --method exact --seeds 20
  beadwork eval zones --method exact --json --plot growth.svg > exact.json")]
struct ZonesArgs {
    /// Look at one method: zigzag, anneal, genetic or exact; all of them, side by side, if not
    /// given.
    #[arg(long, value_name = "METHOD")]
    method: Option<MethodName>,
    /// Seeds per cell and preset; if not given 10 for the table of all methods, 30 for genetic, 100
    /// for the others (with --smoke 1, 2 and 100).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    seeds: Option<u64>,
    /// All methods, genetic: folder to leave results in and to go on from; datasets/eval-zones or
    /// datasets/eval-crossovers if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Anneal: presets, with commas; all if not given.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    presets: Vec<Preset>,
    /// All methods, genetic, exact: only small planes and little work, to see that all is in order.
    #[arg(long)]
    smoke: bool,
    /// Exact: draw how the time grows with cells and with zones.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Threads; 0 for one a core.
    /// The exact search alone is timed on one.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print one JSON document, with a row for each run.
    #[arg(long)]
    json: bool,
}

impl ZonesArgs {
    /// Refuses flags that the method would ignore.
    fn check(&self) {
        use MethodName::{Anneal, Exact, Genetic, Zigzag};

        let refuse = |given: bool, flag: &str, methods: &[Option<MethodName>]| {
            if given && methods.contains(&self.method) {
                let method = self.method.map_or("the table of all methods", MethodName::name);
                output::usage_error(&format!("{flag} means nothing to {method}"));
            }
        };
        refuse(self.out.is_some(), "--out", &[Some(Anneal), Some(Zigzag), Some(Exact)]);
        refuse(
            !self.presets.is_empty(),
            "--presets",
            &[None, Some(Zigzag), Some(Genetic), Some(Exact)],
        );
        refuse(self.smoke, "--smoke", &[Some(Anneal), Some(Zigzag)]);
        refuse(self.plot.is_some(), "--plot", &[None, Some(Zigzag), Some(Anneal), Some(Genetic)]);
        refuse(self.threads.is_some(), "--threads", &[Some(Exact)]);
    }

    fn pool(&self) -> anyhow::Result<rayon::ThreadPool> {
        let threads = control::thread_count(self.threads.unwrap_or(0));
        Ok(control::pool(threads)?)
    }
}

/// Runs the evaluation that the arguments name.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let args = match &args.what {
        What::Zones(args) => args,
        What::Parts(args) => return parts::run(args),
        What::Thermal(args) => return thermal::run(args),
        #[cfg(feature = "learn")]
        What::Fusion(args) => return fusion::run(args),
    };
    args.check();
    match args.method {
        None => paper_tables::run(args),
        Some(MethodName::Zigzag | MethodName::Anneal) => anneal_tables::run(args),
        Some(MethodName::Genetic) => crossovers::run(args),
        Some(MethodName::Exact) => exact_tables::run(args),
        Some(MethodName::Fusion) => {
            output::usage_error("FusionNet has tables of its own: eval fusion")
        }
    }
}
