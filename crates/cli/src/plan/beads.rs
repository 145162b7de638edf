//! Plans a part in beads: insets, skeletons and infill.

use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::beads::{BeadPart, print_beads};
use beadwork_console::part::CutPart;
use beadwork_console::printer::{Profile, tool_costs};
use beadwork_console::text::count;
use beadwork_console::{control, output};
use beadwork_part::print::Settings;
use beadwork_part::{BeadLayer, BeadPanel, bead_svg};
use beadwork_search::plan::beads;
use rayon::ThreadPool;

use super::args::{Args, Files};
use super::bead_report::BeadSummary;
use super::totals::Seconds;

/// Maximum number of layers drawn: two rows.
const PANELS: usize = 4;

/// Plans the part, writes the files and reports the result.
pub(super) fn run(
    args: &Args,
    files: &Files<'_>,
    cut: CutPart,
    profile: &Profile,
    settings: Settings,
    begin: Instant,
    pool: &ThreadPool,
) -> anyhow::Result<()> {
    let threads = Threads::Pool(pool);
    let costs = tool_costs(settings.purge.as_ref().expect("complete settings have volumes"))?;
    let bead_mm = cut.settings.cell_mm;
    let part = cut.into_beads(&args.beads.toolpath(bead_mm), threads)?;
    let sliced = begin.elapsed().as_secs_f64();
    let planner = beads::Settings {
        constraints: args.constraints(),
        tool_change_mm: profile.tower_mm(&part.frame, &settings),
        retraction: profile.retraction(),
        ..args.beads.plan(bead_mm, args.seed)
    };
    let plan = control::with_bar("plan", threads, |control| {
        beads::solve(&part.islands, &part.toolpath, &costs, &planner, control)
    })??;
    let planned = begin.elapsed().as_secs_f64();
    let printed = print_beads(&part, &plan.layers, profile, settings, threads)?;
    let done = begin.elapsed().as_secs_f64();
    super::check_cancelled()?;
    if let Some(path) = &args.svg {
        output::file(path, draw(&part, &plan.layers, &printed.settings))?;
    }
    if let Some(path) = files.gcode {
        output::file(path, &printed.text)?;
    }
    let seconds = Seconds { slice: sliced, plan: planned - sliced, print: done - planned };
    let summary = BeadSummary { part: &part, plan: &plan, printed: &printed, seconds };
    let document = summary.json();
    if let Some(path) = &files.totals {
        output::file(path, format!("{document:#}\n"))?;
    }
    if args.json { output::json(&document) } else { output::text(&summary.text(files)) }
}

/// Draws up to [`PANELS`] layers from bottom to top.
pub(super) fn draw(part: &BeadPart, layers: &[BeadLayer], settings: &Settings) -> String {
    let count_of = layers.len();
    let shown: Vec<usize> = if count_of > PANELS {
        (0..PANELS).map(|panel| panel * (count_of - 1) / (PANELS - 1)).collect()
    } else {
        (0..count_of).collect()
    };
    let title = |&at: &usize| {
        let beads = count(layers[at].beads.len() as u64, "bead");
        format!("{}, layer {}: {beads}", part.name, at + 1)
    };
    let titles: Vec<String> = shown.iter().map(title).collect();
    let panels: Vec<BeadPanel<'_>> = shown
        .iter()
        .zip(&titles)
        .map(|(&at, title)| BeadPanel { title, layer: &layers[at] })
        .collect();
    let colours: Vec<[u8; 3]> = settings.tools.iter().map(|tool| tool.colour).collect();
    let differ = colours.iter().any(|colour| *colour != colours[0]);
    bead_svg(&panels, differ.then_some(&colours[..]))
}
