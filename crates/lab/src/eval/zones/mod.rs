//! `eval zones`: crossings of every method on the layouts and sizes of Aali et al.

mod anneal_tables;
mod args;
mod cell_table;
mod crossovers;
mod exact_tables;
mod paper_tables;

use beadwork_console::output;
use beadwork_console::search::MethodName;

pub(super) use self::args::ZonesArgs;

/// Runs the evaluation of all methods, or of the one that the arguments name.
pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    args.check();
    match args.method {
        None => paper_tables::run(args),
        Some(MethodName::Zigzag | MethodName::Anneal) => anneal_tables::run(args),
        Some(MethodName::Genetic) => crossovers::run(args),
        Some(MethodName::Exact) => exact_tables::run(args),
        Some(MethodName::Fusion) => {
            output::usage_error("--method fusion has its own command: eval fusion")
        }
    }
}
