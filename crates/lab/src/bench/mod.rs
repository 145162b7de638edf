//! `bench`: rates and ratios, measured in one run.

mod dataset;
mod grid;
#[cfg(feature = "learn")]
mod learn;
mod part;
mod thermal;
mod zones;

use std::time::Instant;

use clap::Subcommand;

/// Measure rates on this machine.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Grid(grid::GridArgs),
    Zones(zones::ZonesArgs),
    Part(part::PartArgs),
    Thermal(thermal::ThermalArgs),
    Dataset(dataset::DatasetArgs),
    #[cfg(feature = "learn")]
    Learn(learn::LearnArgs),
}

/// Runs the benchmark that the arguments name.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.what {
        What::Grid(args) => grid::run(args),
        What::Zones(args) => zones::run(args),
        What::Part(args) => part::run(args),
        What::Thermal(args) => thermal::run(args),
        What::Dataset(args) => dataset::run(args),
        #[cfg(feature = "learn")]
        What::Learn(args) => learn::run(args),
    }
}

/// Median seconds of several runs after one that does not count.
fn median(repeats: u64, mut run: impl FnMut(u64)) -> f64 {
    run(0);
    let times = (0..repeats).map(|seed| {
        let begin = Instant::now();
        run(seed);
        begin.elapsed().as_secs_f64()
    });
    middle(times.collect())
}

fn middle(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
