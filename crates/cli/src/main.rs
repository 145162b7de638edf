//! The command line of beadwork.
//!
//! Exit codes: 0 success, 1 failure, 2 usage error.
//! Results go to stdout (with `--json` one JSON document and nothing else), progress and errors to
//! stderr; a closed pipe is not a failure.

#![allow(clippy::print_stderr, reason = "a command line reports to its terminal")]
#![allow(
    clippy::doc_markdown,
    reason = "the comments on flags are their help, where backticks are noise"
)]

mod completions;
mod doctor;
mod gen_data;
mod generations;
mod inspect;
mod instance;
mod path_file;
mod plan;
mod simulate;
mod terminals;
#[cfg(feature = "learn")]
mod train;
mod zones;

use std::process::ExitCode;

use beadwork_console::output;
use beadwork_lab::{bench, eval};
use clap::{CommandFactory, Parser, Subcommand};

/// Plans toolpaths of 3D printers with few tool changes and lifts, and simulates the temperatures
/// of a print.
#[derive(Parser)]
#[command(version, name = "beadwork", propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    GenData(gen_data::Args),
    Inspect(inspect::Args),
    Zones(zones::Args),
    Plan(plan::Args),
    Simulate(Box<simulate::Args>),
    #[cfg(feature = "learn")]
    Train(train::Args),
    Eval(eval::Args),
    Bench(bench::Args),
    Doctor(doctor::Args),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::GenData(args) => gen_data::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Zones(args) => zones::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        #[cfg(feature = "learn")]
        Command::Train(args) => train::run(&args),
        Command::Eval(args) => eval::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Completions(args) => completions::run(&args, Cli::command()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("beadwork: {error:#}");
            ExitCode::FAILURE
        }
    }
}
