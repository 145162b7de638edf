//! `eval`: tables that reproduce and extend those of the papers, and tables of whole parts.

mod beads;
#[cfg(feature = "learn")]
mod fusion;
mod heat;
mod parts;
mod store;
mod thermal;
mod warpage;
mod zones;

use clap::Subcommand;

/// Print tables that reproduce and extend those of the papers, and tables of whole parts.
///
/// The papers are by Aali et al., who reduce the zone crossings of a layer's path, and by Kim et
/// al. (2026), who choose deposition patterns for uniform temperatures.
/// README.md gives their titles.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Zones(zones::ZonesArgs),
    Parts(parts::PartsArgs),
    Thermal(thermal::ThermalArgs),
    Warpage(warpage::WarpageArgs),
    Heat(heat::HeatArgs),
    Beads(beads::BeadsArgs),
    #[cfg(feature = "learn")]
    Fusion(fusion::FusionArgs),
}

/// Runs the evaluation that the arguments name.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.command {
        Command::Zones(args) => zones::run(args),
        Command::Parts(args) => parts::run(args),
        Command::Thermal(args) => thermal::run(args),
        Command::Warpage(args) => warpage::run(args),
        Command::Heat(args) => heat::run(args),
        Command::Beads(args) => beads::run(args),
        #[cfg(feature = "learn")]
        Command::Fusion(args) => fusion::run(args),
    }
}
