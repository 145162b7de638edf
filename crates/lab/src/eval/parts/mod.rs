//! Whole parts: tool changes and lifts against their bounds, layers on layers, and cells against
//! surfaces.

mod plans;
mod stacks;
mod surfaces;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use beadwork_console::part::{Numbers, Part, PartArgs, Rule};
use beadwork_console::printer::Profile;
use beadwork_console::{control, machine, output, progress};
use beadwork_mesh::Example;
use serde_json::json;

/// Plan whole parts in all modes, and measure what they come to.
#[derive(clap::Args)]
#[command(after_help = "\
The real parts are files of the CC0 collection SlicerTestModels (its folder 3mf): give the folder that holds
yin_yang.3mf, 8_extruders.3mf, Bearing.3mf, torus.3mf, heartgears.3mf and dodeca_chain_loop_color.3mf. Those that are
missing are left out, and named.

Examples:
  beadwork eval parts
  beadwork eval parts --files ../shared/parts --json")]
pub(super) struct PartsArgs {
    /// Folder of the real parts.
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Threads; 0 for one a core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// A part of the tables.
struct Case {
    name: &'static str,
    part: Part,
    /// Whether its cells are compared with its surface: the same part with other materials is not,
    /// once more.
    is_new_shape: bool,
}

/// File, name in the tables, turn about x, and what is a material.
const FILES: [(&str, &str, f64, Rule); 7] = [
    ("yin_yang.3mf", "yin_yang", 90.0, Rule::Stated),
    ("8_extruders.3mf", "8_extruders", 0.0, Rule::Stated),
    ("Bearing.3mf", "Bearing", 0.0, Rule::Stated),
    ("Bearing.3mf", "Bearing, 8 tools", 0.0, Rule::Bodies),
    ("torus.3mf", "torus", 0.0, Rule::Stated),
    ("heartgears.3mf", "heartgears", 0.0, Rule::Stated),
    ("dodeca_chain_loop_color.3mf", "dodeca_chain", 0.0, Rule::Stated),
];

pub(super) fn run(args: &PartsArgs) -> anyhow::Result<()> {
    let pool = control::pool(args.threads)?;
    let mut missing = Vec::new();
    let cases = cases(args.files.as_deref(), &pool, &mut missing)?;
    let bar = progress::bar(3 * cases.len() as u64, "eval parts");
    let plans = plans::measure(&cases, args.seed, &pool, &bar)?;
    let stacks = stacks::measure(&cases, args.seed, &bar)?;
    let surfaces = surfaces::measure(&cases, &bar);
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
        writeln!(text, "Left out, for there is no such file: {}.\n", missing.join(", "))?;
    }
    plans::tables(&mut text, &plans)?;
    stacks::table(&mut text, &stacks)?;
    surfaces::table(&mut text, &surfaces)?;
    output::text(&text)
}

fn cases(
    folder: Option<&Path>,
    pool: &rayon::ThreadPool,
    missing: &mut Vec<&'static str>,
) -> anyhow::Result<Vec<Case>> {
    let bed_mm = Profile::for_tables().bed_mm();
    let mut cases = Vec::new();
    for example in Example::ALL {
        let part = PartArgs::usual(format!("example:{example}").into()).load(bed_mm, pool)?;
        cases.push(Case { name: example.name(), part, is_new_shape: true });
    }
    for (file, name, turn, materials) in FILES {
        let path = folder.map(|folder| folder.join(file)).filter(|path| path.exists());
        let Some(path) = path else {
            missing.push(file);
            continue;
        };
        let mut flags = PartArgs::usual(path);
        (flags.rotate, flags.materials) = (Numbers([turn, 0.0, 0.0]), materials);
        let is_new_shape = matches!(materials, Rule::Stated);
        cases.push(Case { name, part: flags.load(bed_mm, pool)?, is_new_shape });
    }
    missing.dedup();
    Ok(cases)
}
