//! `plan`: from meshes to G-code, with as few and as cheap tool changes and as few lifts as can be.

mod drawing;
mod report;

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use anyhow::bail;
use beadwork_base::Threads;
use beadwork_console::part::PartArgs;
use beadwork_console::plan::{print, refs};
use beadwork_console::printer::{ProfileArgs, tool_costs};
use beadwork_console::text::count;
use beadwork_console::{cancel, control, output};
use beadwork_search::plan::Constraints;
use beadwork_search::plan::tools::{self, Mode, Settings, Stacking};
use clap::ValueEnum;

use report::{Report, Seconds};

/// Plan how a part is printed, and write its G-code.
///
/// Meshes are cut into layers of cells one bead wide; every layer is covered by beads, the order of
/// beads and tools is chosen for the part as a whole, and the G-code, read again from its text, is
/// checked to print every cell once with the tool of its material.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork plan example:logo-plate --objective tools --out logo.gcode
  beadwork plan yin_yang.3mf --rotate 90,0,0 --objective tools --out yin_yang.gcode --svg layers.svg
  beadwork plan body.stl inlay.stl --objective tools --mode free --flavour klipper --out badge.gcode
  beadwork plan plate.3mf --objective tools --lift-cost 50 --purge 90 --before 1:0 --json
  beadwork plan part.obj --unit in --bead 0.45 --layer 0.2 --profile printer.toml --objective tools --out part.gcode")]
pub(crate) struct Args {
    #[command(flatten)]
    part: PartArgs,
    /// What to save: tools (tool changes, at a price of lifts).
    #[arg(long, value_name = "NAME")]
    objective: Objective,
    /// How layers may be printed: each the cheaper way, without lifts wherever possible
    /// (continuous), or tool by tool (free).
    #[arg(long, value_name = "MODE", default_value = "cheapest")]
    mode: ModeName,
    /// What a lift costs, in mm³ of purged material.
    #[arg(long, value_name = "MM3", default_value_t = 2)]
    lift_cost: u32,
    /// A pair of tools, numbered from 0 as in the G-code: in every layer that uses both, the first
    /// one comes first.
    /// May be given several times.
    #[arg(long, value_name = "A:B")]
    before: Vec<Pair>,
    /// The tool, numbered from 0 as in the G-code, that begins the print.
    #[arg(long, value_name = "TOOL")]
    first_tool: Option<u8>,
    /// Use the tools in the same order in every layer.
    #[arg(long)]
    same_order: bool,
    /// Try the path of the layer below for each layer; of equally good paths, take the one that
    /// keeps more of its links (keep) or fewer (break).
    #[arg(long, value_name = "RULE")]
    stacking: Option<StackingName>,
    #[command(flatten)]
    profile: ProfileArgs,
    /// G-code to write; a JSON file with the totals is written beside it, under the same name and
    /// .json.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Draw some layers with their paths.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Most attempts at each connected part of a layer.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    attempts: u32,
    /// Threads; 0 for one a core.
    /// They change the time and nothing else.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Objective {
    Tools,
}

#[derive(Clone, Copy, ValueEnum)]
enum ModeName {
    Cheapest,
    Continuous,
    Free,
}

#[derive(Clone, Copy, ValueEnum)]
enum StackingName {
    Keep,
    Break,
}

/// Two tools.
#[derive(Clone, Copy)]
struct Pair(u8, u8);

impl FromStr for Pair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let tool = |text: &str| text.trim().parse().ok();
        let pair = text.split_once(':').and_then(|(a, b)| Some(Self(tool(a)?, tool(b)?)));
        pair.ok_or_else(|| "give two tools, numbered from 0, as 1:0".to_owned())
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let Objective::Tools = args.objective;
    let files = args.files()?;
    let profile = args.profile.load()?;
    let pool = control::pool(args.threads)?;
    let begin = Instant::now();
    let part = args.part.load(profile.bed_mm(), &pool)?;
    for (body, repaired) in &part.repaired {
        eprintln!("beadwork: repaired {body}: {}", beadwork_console::part::describe(repaired));
    }
    if let Some(layer) = part.layers.gap() {
        bail!("layer {} has no cells: what lies above it would be printed in the air", layer + 1);
    }
    if part.layers.empty_below() > 0 {
        let count = count(part.layers.empty_below() as u64, "layer");
        eprintln!(
            "beadwork: the part is lowered by {count} without cells: its tip is thinner than a bead"
        );
    }
    let settings = profile.complete(&part.model.materials)?;
    let costs = tool_costs(settings.purge.as_ref().expect("complete settings have volumes"))?;
    let sliced = begin.elapsed().as_secs_f64();
    let constraints = Constraints {
        before: args.before.iter().map(|&Pair(a, b)| (a, b)).collect(),
        first: args.first_tool,
        same_order: args.same_order,
        ..Constraints::default()
    };
    let how = Settings {
        mode: match args.mode {
            ModeName::Cheapest => Mode::Cheapest,
            ModeName::Continuous => Mode::Continuous,
            ModeName::Free => Mode::Free,
        },
        lift_cost: args.lift_cost.into(),
        constraints,
        stacking: args.stacking.map(|rule| match rule {
            StackingName::Keep => Stacking::Keep,
            StackingName::Break => Stacking::Break,
        }),
        seed: args.seed,
        attempts: args.attempts,
        ..Settings::default()
    };
    let plan = control::with_bar("plan", Threads::Pool(&pool), |control| {
        tools::solve(&refs(&part.layers), &costs, &how, control)
    })??;
    let planned = begin.elapsed().as_secs_f64();
    let printed = print(&part, &plan, &profile, settings)?;
    let done = begin.elapsed().as_secs_f64();
    let seconds = Seconds { slice: sliced, plan: planned - sliced, print: done - planned };
    let report =
        Report { part: &part, plan: &plan, printed: &printed, lift_cost: args.lift_cost, seconds };
    if cancel::token()?.is_cancelled() {
        bail!("stopped; nothing was written");
    }
    if let Some(path) = &args.svg {
        output::file(path, drawing::draw(&part, &plan, &printed.settings))?;
    }
    if let Some(path) = &args.out {
        output::file(path, &printed.text)?;
    }
    let document = report.json();
    if let Some(path) = &files.totals {
        output::file(path, format!("{document:#}\n"))?;
    }
    if args.json { output::json(&document) } else { output::text(&report.summary(&files)) }
}

/// What is written.
struct Files<'a> {
    gcode: Option<&'a Path>,
    /// Beside the G-code; not where that is a terminal or a pipe.
    totals: Option<PathBuf>,
}

impl Args {
    /// The files to write; refuses, before any work, those that can't all be.
    fn files(&self) -> anyhow::Result<Files<'_>> {
        let gcode = self.out.as_deref();
        let is_file = |path: &&Path| fs::metadata(path).map_or(true, |metadata| metadata.is_file());
        for path in [gcode, self.svg.as_deref()].into_iter().flatten() {
            if path.is_dir() {
                bail!("'{}' is a folder", path.display());
            }
        }
        let totals = gcode.filter(is_file).map(|path| {
            let mut name = path.as_os_str().to_owned();
            name.push(".json");
            PathBuf::from(name)
        });
        if self.svg.is_some() && (self.svg.as_deref() == gcode || self.svg == totals) {
            output::usage_error("--svg and --out name the same file");
        }
        Ok(Files { gcode, totals })
    }
}
