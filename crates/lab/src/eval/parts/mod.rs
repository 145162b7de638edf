//! `eval parts`: plans of whole parts with their bounds, starts from the layer below, and cells
//! compared with surfaces.

mod cases;
mod distances;
mod plans;
mod stacks;
mod surfaces;

use std::fmt::Write;
use std::path::PathBuf;

use beadwork_console::{control, machine, output, progress};
use serde_json::json;

/// Steps of the progress bar for each part: three planning modes, the starts, and the surface.
const STEPS: usize = 3 + stacks::STARTS + 1;

/// Plan whole parts in all modes, and report tool changes, lifts and their lower bounds.
///
/// Further tables compare starts from the layer below with starts from scratch, and cells with the
/// surfaces that they fill.
/// The parts are the built-in examples and files of the CC0 collection SlicerTestModels.
#[derive(clap::Args)]
#[command(after_help = "\
The files are in the folder 3mf of SlicerTestModels: yin_yang.3mf, 8_extruders.3mf, Bearing.3mf,
torus.3mf, heartgears.3mf and dodeca_chain_loop_color.3mf. Missing files are left out, and listed.

Examples:
  beadwork eval parts
  beadwork eval parts --files ../shared/parts --json")]
pub(super) struct PartsArgs {
    /// Folder of the files; only the built-in examples by default.
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Threads; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &PartsArgs) -> anyhow::Result<()> {
    let pool = control::pool(args.threads)?;
    let (cases, missing) = cases::load(args.files.as_deref(), &pool)?;
    let bar = progress::bar((cases.len() * STEPS) as u64, "eval parts");
    let plans = plans::measure(&cases, args.seed, &pool, &bar)?;
    let stacks = stacks::measure(&cases, args.seed, &bar)?;
    let surfaces = surfaces::measure(&cases, &bar)?;
    bar.finish_and_clear();
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "seed": args.seed,
            "missing": missing,
            "plans": plans,
            "stacks": stacks,
            "surfaces": surfaces,
        }));
    }
    let mut text = format!("{}\n\n", machine::line());
    if !missing.is_empty() {
        writeln!(text, "Left out, because the file does not exist: {}.\n", missing.join(", "))?;
    }
    plans::tables(&mut text, &plans)?;
    stacks::table(&mut text, &stacks)?;
    surfaces::table(&mut text, &surfaces)?;
    output::text(&text)
}
