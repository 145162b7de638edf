//! Flags of `eval zones`.

use std::path::PathBuf;

use beadwork_console::search::MethodName;
use beadwork_console::{control, output};
use beadwork_search::anneal::Preset;
use rayon::ThreadPool;

use crate::args::positive;

/// Compare all methods on the 24 cells of Aali et al. (their Tables 1, 3 and 5), or examine one
/// method.
#[derive(clap::Args)]
#[command(after_help = "\
Without --method: zigzag, annealing, the genetic algorithm and the exact search on the same
instances, whose zigzag has as many crossings as the paper's to within 10 %. Tables, numbers,
convergence plots and heat maps are written to --out. An interrupted run resumes when the same
command is run again.

With --method anneal or zigzag: Tables 3 and 5. The means use the preset 'paper', then 'medium' to
'extra_long', on the instances of seeds 0, 1, 2, ...; the best reductions use all presets on
instances like the paper's.

With --method genetic: one-point, two-point and window crossover from the same first populations,
with confidence intervals. An interrupted run resumes.

With --method exact: how often the fewest crossings are proven, and how fast, on the instances of
seeds 0, 1, 2, ... of the 24 cells, of harder and larger layouts and of masks. Instances run one
after the other, each with its bound; zigzag and annealing are listed for comparison.

Examples:
  beadwork eval zones
  beadwork eval zones --seeds 30 --out /data/eval-zones --json > zones.json
  beadwork eval zones --method anneal
  beadwork eval zones --method genetic --out /data/crossovers
  beadwork eval zones --method exact --seeds 20
  beadwork eval zones --method exact --json --plot growth.svg > exact.json")]
pub(in crate::eval) struct ZonesArgs {
    /// Method to examine: zigzag, anneal, genetic or exact; all of them by default.
    #[arg(long, value_name = "METHOD")]
    pub(super) method: Option<MethodName>,
    /// Seeds per cell and preset [default: 10 for all methods, 30 for genetic, 100 otherwise; with
    /// --smoke 1, 2 and 100].
    #[arg(long, value_name = "N", value_parser = positive::<u64>())]
    pub(super) seeds: Option<u64>,
    /// All methods, genetic: folder of the results, from which an interrupted run resumes [default:
    /// datasets/eval-zones or datasets/eval-crossovers, with --smoke ...-smoke].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Anneal: presets, separated by commas; all by default.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) presets: Vec<Preset>,
    /// All methods, genetic, exact: only small grids and little work, as a test of the command.
    #[arg(long)]
    pub(super) smoke: bool,
    /// Exact: writes a chart of the run time against the numbers of cells and zones.
    #[arg(long, value_name = "FILE")]
    pub(super) plot: Option<PathBuf>,
    /// All methods except exact, which is timed on one thread: threads; 0 for one per core
    /// [default: 0].
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Prints one JSON document with a row for each run.
    #[arg(long)]
    pub(super) json: bool,
}

impl ZonesArgs {
    /// Ends the process with a usage error if a flag was given that the method ignores.
    pub(super) fn check(&self) {
        use MethodName::{Anneal, Exact, Genetic, Zigzag};

        let refuse = |given: bool, flag: &str, methods: &[Option<MethodName>]| {
            if given && methods.contains(&self.method) {
                let command = self.method.map_or_else(
                    || "eval zones without --method".to_owned(),
                    |method| format!("--method {}", method.name()),
                );
                output::usage_error(&format!("{flag} has no effect on {command}"));
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

    /// The threads to work on.
    pub(super) fn pool(&self) -> anyhow::Result<ThreadPool> {
        control::pool(self.threads.unwrap_or(0))
    }
}
