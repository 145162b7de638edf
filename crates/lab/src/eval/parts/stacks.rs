//! The exact search started from the layer below, compared with starts from scratch.

use std::fmt::Write;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::plan::refs;
use beadwork_console::progress::ProgressBar;
use beadwork_grid::Path;
use beadwork_search::plan::kept_links;
use beadwork_search::plan::tools::{self, LayerRef, Mode, Settings, Stacking};
use beadwork_search::{CostMatrix, exact};
use serde::Serialize;

use super::cases::Case;

/// All layers of one part with one kind of start.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    start: &'static str,
    /// Number of layers that differ from the layer below.
    layers: usize,
    pieces: u64,
    crossings: u64,
    /// Layers whose path is proven optimal.
    layers_optimal: usize,
    /// Share of links, in layers above the first, that also occur in the layer below.
    #[serde(rename = "kept")]
    kept_share: f64,
    seconds: f64,
}

/// The path of one layer.
struct Solved {
    path: Path,
    crossings: u32,
    is_optimal: bool,
}

/// Number of rows, and of steps of the progress bar, for each part.
pub(super) const STARTS: usize = 4;

/// Solves the layers of all parts with each kind of start, on one thread.
///
/// Layers that equal the one below are left out; so are parts with fewer than three other layers.
pub(super) fn measure(cases: &[Case], seed: u64, bar: &ProgressBar) -> anyhow::Result<Vec<Row>> {
    let control = &control::cancellable(Threads::One)?;
    let mut rows = Vec::new();
    for Case { name, part, .. } in cases {
        let mut layers = refs(&part.layers);
        layers.dedup_by(|b, a| (a.region, a.zones) == (b.region, b.zones));
        if layers.len() < 3 {
            bar.inc(STARTS as u64);
            continue;
        }
        let tools = part.layers.tools() as usize;
        let mut add = |start, solve: &dyn Fn() -> anyhow::Result<Vec<Solved>>| {
            let begin = Instant::now();
            let solved = solve()?;
            control.check()?;
            rows.push(row(name, start, &solved, begin.elapsed().as_secs_f64()));
            bar.inc(1);
            anyhow::Ok(())
        };
        add("scratch", &|| one_start(&layers, false, seed, control))?;
        add("layer below", &|| one_start(&layers, true, seed, control))?;
        add("better of both, more kept", &|| {
            both_starts(&layers, Stacking::Keep, tools, seed, control)
        })?;
        add("better of both, fewer kept", &|| {
            both_starts(&layers, Stacking::Break, tools, seed, control)
        })?;
    }
    Ok(rows)
}

/// Solves each layer once, from scratch or from the path of the layer below.
fn one_start(
    layers: &[LayerRef<'_>],
    from_below: bool,
    seed: u64,
    control: &Control<'_>,
) -> anyhow::Result<Vec<Solved>> {
    let mut solved: Vec<Solved> = Vec::new();
    for layer in layers {
        let below = solved.last().filter(|_| from_below).map(|below| &below.path);
        let settings = exact::Settings { seed, below, ..exact::Settings::default() };
        let outcome = exact::solve(layer.region, layer.zones, &settings, control)?;
        let is_optimal = outcome.is_optimal();
        solved.push(Solved { path: outcome.path, crossings: outcome.crossings, is_optimal });
    }
    Ok(solved)
}

/// Solves each layer with both starts and takes the better path; `stacking` decides between equally
/// good ones.
fn both_starts(
    layers: &[LayerRef<'_>],
    stacking: Stacking,
    tools: usize,
    seed: u64,
    control: &Control<'_>,
) -> anyhow::Result<Vec<Solved>> {
    let settings =
        Settings { mode: Mode::Continuous, stacking: Some(stacking), seed, ..Settings::default() };
    let plan = tools::solve(layers, &CostMatrix::uniform(tools), &settings, control)?;
    let solved = plan.layers.into_iter().map(|layer| {
        let is_optimal = layer.is_optimal();
        Solved { path: layer.path, crossings: layer.crossings, is_optimal }
    });
    Ok(solved.collect())
}

fn row(part: &'static str, start: &'static str, layers: &[Solved], seconds: f64) -> Row {
    let links =
        |solved: &Solved| solved.path.order().len() as u64 - u64::from(solved.path.pieces());
    let possible: u64 = layers[1..].iter().map(links).sum();
    let kept: u64 =
        layers.windows(2).map(|pair| u64::from(kept_links(&pair[0].path, &pair[1].path))).sum();
    Row {
        part,
        start,
        layers: layers.len(),
        pieces: layers.iter().map(|solved| u64::from(solved.path.pieces())).sum(),
        crossings: layers.iter().map(|solved| u64::from(solved.crossings)).sum(),
        layers_optimal: layers.iter().filter(|solved| solved.is_optimal).count(),
        kept_share: kept as f64 / possible as f64,
        seconds,
    }
}

pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "\nStarts from scratch and from the layer below, over the layers that differ from the one \
         below; continuous mode, one thread:\n\n\
         | part | layers | start | pieces | crossings | layers proven optimal | links kept \
         | seconds |\n\
         |---|---|---|---|---|---|---|---|"
    )?;
    for row in rows {
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {:.1} % | {:.3} |",
            row.part,
            row.layers,
            row.start,
            row.pieces,
            row.crossings,
            row.layers_optimal,
            100.0 * row.kept_share,
            row.seconds
        )?;
    }
    Ok(())
}
