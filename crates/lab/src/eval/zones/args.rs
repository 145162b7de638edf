//! Flags of `eval zones`.

use std::path::PathBuf;

use beadwork_console::search::MethodName;
use beadwork_console::{control, output};
use beadwork_search::anneal::Preset;
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use rayon::ThreadPool;

use crate::args::positive;

/// Compare all methods on the layouts and sizes of Aali et al. (their Tables 1, 3 and 5), or
/// examine one method.
#[derive(clap::Args)]
#[command(after_help = "\
Each of the four layouts in each of the six sizes is a cell of the paper's tables. The paper's
random instances are not published: instances whose zigzag has as many crossings, to within 10 %,
replace them.

Without --method: the zigzag, annealing, the genetic algorithm and the exact search, all on the same
instances. Tables, numbers, convergence plots and heat maps are written to --out. If the run is
interrupted, the same command resumes it.

With --method anneal or zigzag: Tables 3 and 5. Means are taken over the instances of seeds 0, 1, 2,
..., for the preset 'paper' and for the presets 'medium' to 'extra_long'; the best reductions are
those of all presets on instances like the paper's.

With --method genetic: one-point, two-point and window crossover from the same first populations,
with confidence intervals. If the run is interrupted, the same command resumes it.

With --method exact: how often the fewest crossings are proven, and how fast, on the instances of
seeds 0, 1, 2, ... of the 24 cells, of harder and larger layouts, and of regions that are not
rectangles. The search runs on one instance at a time; the zigzag and annealing are listed for
comparison.

Examples:
  beadwork eval zones
  beadwork eval zones --seeds 30 --out /data/eval-zones --json > zones.json
  beadwork eval zones --method anneal
  beadwork eval zones --method genetic --out /data/crossovers
  beadwork eval zones --method exact --seeds 20
  beadwork eval zones --method exact --json --plot growth.svg > exact.json")]
pub(in crate::eval) struct ZonesArgs {
    /// Method to examine; all of them by default.
    /// FusionNet has a command of its own, eval fusion.
    #[arg(long, value_name = "METHOD", value_parser = method_parser())]
    pub(super) method: Option<MethodName>,
    /// Number of seeds for each layout, size and preset [default: 10 without --method, 30 with
    /// genetic, 100 with any other method; with --smoke 1 without --method, 2 with genetic].
    #[arg(long, value_name = "N", value_parser = positive::<u64>())]
    pub(super) seeds: Option<u64>,
    /// Without --method, or with genetic: folder for the results, from which an interrupted run
    /// resumes [default: datasets/eval-zones, or datasets/eval-crossovers with genetic; with
    /// --smoke, -smoke is appended].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Anneal: presets, separated by commas; all presets by default.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) presets: Vec<Preset>,
    /// Without --method, or with genetic or exact: a quick test of the command on small grids.
    #[arg(long)]
    pub(super) smoke: bool,
    /// Exact: draw the run time against the number of cells and of zones, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(super) plot: Option<PathBuf>,
    /// Threads; 0 for one per core [default: 0].
    /// Not with exact, which is timed on one thread.
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Print one JSON document with a row for each run.
    #[arg(long)]
    pub(super) json: bool,
}

/// Parser of `--method`.
///
/// `fusion` is hidden from the help but accepted, so that `run` can point to `eval fusion`.
fn method_parser() -> impl TypedValueParser<Value = MethodName> {
    let names = MethodName::value_variants()
        .iter()
        .filter_map(|method| Some(method.to_possible_value()?.hide(*method == MethodName::Fusion)));
    PossibleValuesParser::new(names).try_map(|name| MethodName::from_str(&name, false))
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
