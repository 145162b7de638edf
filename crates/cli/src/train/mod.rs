//! `train`: networks trained from recorded searches, or by acting.

pub(crate) mod fusion;
mod log;
pub(crate) mod ppo;
mod ppo_log;
mod table;
mod tensorboard;

use beadwork_console::memory;
use clap::Subcommand;

/// Train a network. --resume continues a stopped run, with the same losses.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    network: Network,
}

#[derive(Subcommand)]
enum Network {
    Fusion(fusion::Args),
    Ppo(ppo::Args),
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    memory::keep_freed();
    match &args.network {
        Network::Fusion(args) => fusion::run(args),
        Network::Ppo(args) => ppo::run(args),
    }
}
