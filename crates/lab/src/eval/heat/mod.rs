//! `eval heat`: planners for even temperature, on parts like the paper's (Kim et al. 2026) and
//! others.

mod fields;
mod pictures;
mod plans;
mod subject;
mod tables;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use beadwork_console::accuracy::AccuracyName;
use beadwork_console::part::PartArgs;
use beadwork_console::{control, machine, output};
use beadwork_heat::planner::{Annealing, Planner};
use beadwork_thermal::objective::Weighted;
use beadwork_thermal::simulation::Method;
use rayon::ThreadPool;
use serde_json::json;

use self::plans::{PartRow, Setup};
use self::subject::Subject;
use crate::heat_parts::HeatPart;

/// Compare planners for even temperature with the conventional order.
///
/// Each part is printed in ABS with the paper's settings (Kim et al. 2026), in the conventional
/// order and in the plan of each planner, within a limit on the printing time.
/// Plans are judged by a simulation of high accuracy: by the paper's reward, by the reward if
/// travel took no time, which orders cannot raise by waiting, and by the deviation averaged over
/// time.
/// The last is given for the whole print and without its first layer, whose deviation while its
/// first voxels are deposited is the same for all orders.
///
/// The parts are generated, or files that are sliced as `plan` does; each file is one part, and all
/// of its bodies are of one material.
#[derive(clap::Args)]
#[command(
    mut_arg("parts", |parts| {
        parts.required(false).help("Mesh files (STL, 3MF or OBJ) or built-in examples, each a part")
    }),
    // Files are parts of one material.
    mut_arg("materials", |materials| materials.hide(true)),
    after_help = "\
Examples:
  beadwork eval heat
  beadwork eval heat --part u --planner greedy --planner lines --max-time 1.05 --json > u.json
  beadwork eval heat torus.3mf Bearing.3mf --bead 0.8 --layer 0.4 --planner lines
  beadwork eval heat --part rectangular --pictures pictures"
)]
pub(super) struct HeatArgs {
    #[command(flatten)]
    files: PartArgs,
    /// Generated part to print; may be repeated; without any and without files, the paper's three,
    /// the L and the blob.
    #[arg(long, value_name = "PART")]
    part: Vec<HeatPart>,
    /// Planner: conventional, constant, greedy, beam, smart-scan, lines; may be repeated; all by
    /// default.
    #[arg(long, value_name = "NAME")]
    planner: Vec<Planner>,
    /// Maximum printing time, as a multiple of that of the conventional order.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.02)]
    max_time: f64,
    /// What the planner lines plans for: objectives with weights.
    /// All other planners plan for the paper's reward.
    #[arg(long, value_name = "WEIGHTS", default_value_t = Weighted::even())]
    objective: Weighted,
    /// Accuracy of the solver while planning; plans are measured by high accuracy.
    #[arg(long, value_name = "NAME", default_value = "draft")]
    accuracy: AccuracyName,
    /// Orders that annealing tries in all layers together, at most 1,000 in each.
    #[arg(long, value_name = "N", default_value_t = Annealing::default().trials)]
    anneal_trials: usize,
    /// Seconds at the end of each layer whose lines are annealed.
    #[arg(long, value_name = "S", default_value_t = Annealing::default().tail_s)]
    anneal_seconds: f64,
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Threads; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Draw the temperatures at the ends of the middle and the last layer, in all plans side by
    /// side, as one SVG per part in this folder.
    /// The tip of a part that tapers off is left out.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

/// Plans all parts, and writes the tables to stdout.
pub(super) fn run(args: &HeatArgs) -> anyhow::Result<()> {
    let planners = if args.planner.is_empty() { &Planner::ALL[..] } else { &args.planner };
    let pool = control::pool(args.threads)?;
    let setup = Setup {
        planners,
        max_time: args.max_time,
        objective: &args.objective,
        method: Method::Fast(args.accuracy.into()),
        annealing: Annealing {
            trials: args.anneal_trials,
            tail_s: args.anneal_seconds,
            ..Annealing::default()
        },
        seed: args.seed,
        pool: &pool,
    };
    let parts = subjects(args, &pool)?;
    if args.pictures.is_some() {
        check_names(&parts)?;
    }
    let rows =
        parts.into_iter().map(|part| setup.part_row(part)).collect::<anyhow::Result<Vec<_>>>()?;
    if let Some(folder) = &args.pictures {
        rows.iter().try_for_each(|row| draw(row, folder))?;
    }
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "threads": pool.current_num_threads(),
            "seed": args.seed,
            "max_time": args.max_time,
            "objective": args.objective.to_string(),
            "parts": rows,
        }));
    }
    output::text(&tables::text(&rows, args.max_time)?)
}

/// The parts that the arguments name.
fn subjects(args: &HeatArgs, pool: &ThreadPool) -> anyhow::Result<Vec<Subject>> {
    let mut parts: Vec<Subject> = args.part.iter().copied().map(Subject::generated).collect();
    parts.extend(Subject::from_files(&args.files, pool)?);
    if parts.is_empty() {
        parts = HeatPart::PLANNED.map(Subject::generated).into();
    }
    Ok(parts)
}

/// Refuses parts of the same name, whose pictures would overwrite each other.
fn check_names(parts: &[Subject]) -> anyhow::Result<()> {
    let mut names: Vec<&str> = parts.iter().map(|part| &part.name[..]).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => bail!(
            "two parts are named '{}', and their pictures would overwrite each other: rename a \
             file, or draw them one at a time",
            pair[0]
        ),
        None => Ok(()),
    }
}

/// Draws the plans of a part, named for it, into a folder.
fn draw(row: &PartRow, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create '{}'", folder.display()))?;
    output::file(
        &folder.join(format!("{}.svg", row.part)),
        pictures::draw(&row.frame, &row.fields()),
    )
}
