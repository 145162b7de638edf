//! `bench`: run times, rates and memory on the machine at hand.

mod beads;
mod dataset;
mod grid;
mod heat;
#[cfg(feature = "learn")]
mod learn;
mod part;
mod thermal;
mod timing;
mod zones;

use clap::Subcommand;

/// Measure run times, rates and memory on this machine.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Grid(grid::GridArgs),
    Zones(zones::ZonesArgs),
    Part(part::PartArgs),
    Beads(beads::BeadsArgs),
    Thermal(thermal::ThermalArgs),
    Heat(heat::HeatArgs),
    Dataset(dataset::DatasetArgs),
    #[cfg(feature = "learn")]
    Learn(learn::LearnArgs),
}

/// Runs the benchmark that the arguments name.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.command {
        Command::Grid(args) => grid::run(args),
        Command::Zones(args) => zones::run(args),
        Command::Part(args) => part::run(args),
        Command::Beads(args) => beads::run(args),
        Command::Thermal(args) => thermal::run(args),
        Command::Heat(args) => heat::run(args),
        Command::Dataset(args) => dataset::run(args),
        #[cfg(feature = "learn")]
        Command::Learn(args) => learn::run(args),
    }
}
