//! Starts from the layer below beside starts from scratch.

use std::fmt::Write;
use std::time::Instant;

use beadwork_base::Control;
use beadwork_console::plan::refs;
use beadwork_console::progress::ProgressBar;
use beadwork_grid::Path;
use beadwork_search::CostMatrix;
use beadwork_search::exact::{self, solve};
use beadwork_search::plan::kept_links;
use beadwork_search::plan::tools::{self, Mode, Settings, Stacking};
use serde::Serialize;

use super::cases::Case;

/// All layers of one part with one kind of start.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    start: &'static str,
    /// Layers on a layer that differs.
    layers: usize,
    pieces: u64,
    crossings: u64,
    layers_optimal: usize,
    /// Share of the links of layers above the first that the layer below has too.
    kept: f64,
    seconds: f64,
}

/// What became of one layer.
struct Solved {
    path: Path,
    crossings: u32,
    is_optimal: bool,
}

/// On one thread.
/// Only layers that differ from the one below count: an equal one is solved once.
pub(super) fn measure(cases: &[Case], seed: u64, bar: &ProgressBar) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for Case { name, part, .. } in cases {
        let mut layers = refs(&part.layers);
        layers.dedup_by(|b, a| (a.region, a.zones) == (b.region, b.zones));
        bar.inc(1);
        if layers.len() < 3 {
            continue;
        }
        for (start, is_aware) in [("scratch", false), ("layer below", true)] {
            let begin = Instant::now();
            let mut solved: Vec<Solved> = Vec::new();
            for layer in &layers {
                let below = solved.last().filter(|_| is_aware).map(|below| &below.path);
                let settings = exact::Settings { seed, below, ..exact::Settings::default() };
                let plan = solve(layer.region, layer.zones, &settings, &Control::default())?;
                let is_optimal = plan.is_optimal();
                solved.push(Solved { path: plan.path, crossings: plan.crossings, is_optimal });
            }
            rows.push(row(name, start, &solved, begin));
        }
        // The better of both, where each layer stands on the one chosen before it.
        let costs = CostMatrix::uniform(part.layers.tools() as usize);
        for (stacking, start) in [
            (Stacking::Keep, "better of both, more kept"),
            (Stacking::Break, "better of both, fewer kept"),
        ] {
            let begin = Instant::now();
            let settings = Settings {
                mode: Mode::Continuous,
                stacking: Some(stacking),
                seed,
                ..Settings::default()
            };
            let plan = tools::solve(&layers, &costs, &settings, &Control::default())?;
            let solved = plan.layers.into_iter().map(|layer| {
                let is_optimal = layer.is_optimal();
                Solved { path: layer.path, crossings: layer.crossings, is_optimal }
            });
            rows.push(row(name, start, &solved.collect::<Vec<_>>(), begin));
        }
    }
    Ok(rows)
}

fn row(part: &'static str, start: &'static str, layers: &[Solved], begin: Instant) -> Row {
    let seconds = begin.elapsed().as_secs_f64();
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
        kept: kept as f64 / possible as f64,
        seconds,
    }
}

pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "\nStarts from scratch and from the layer below, over layers that differ from the one below; continuous, on one thread:\n"
    )?;
    writeln!(
        text,
        "| part | layers | start | pieces | crossings | layers proven optimal | links kept | seconds |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|")?;
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
            100.0 * row.kept,
            row.seconds
        )?;
    }
    Ok(())
}
