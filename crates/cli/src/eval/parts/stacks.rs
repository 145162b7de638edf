//! Starts from the layer below beside starts from scratch.

use std::fmt::Write;
use std::time::Instant;

use beadwork_grid::Path;
use beadwork_search::exact::{self, solve};
use beadwork_search::plan::{Stacking, kept_links};
use indicatif::ProgressBar;
use serde::Serialize;

use super::Case;
use crate::plan::refs;

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
    attempts: u64,
    seconds: f64,
}

/// One path of a layer.
struct Solved {
    path: Path,
    crossings: u32,
    is_optimal: bool,
    attempts: u32,
    seconds: f64,
}

/// On one thread. Only layers that differ from the one below count: an equal one is solved once.
pub(super) fn measure(cases: &[Case], seed: u64, bar: &ProgressBar) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for Case { name, part, .. } in cases {
        let mut layers = refs(&part.layers);
        layers.dedup_by(|b, a| (a.region, a.zones) == (b.region, b.zones));
        if layers.len() < 3 {
            bar.inc(1);
            continue;
        }
        let one = |at: usize, below: Option<&Path>| -> anyhow::Result<Solved> {
            let begin = Instant::now();
            let settings = exact::Settings { seed, below, ..exact::Settings::default() };
            let plan = solve(layers[at].region, layers[at].zones, &settings)?;
            let (is_optimal, seconds) = (plan.is_optimal(), begin.elapsed().as_secs_f64());
            Ok(Solved {
                path: plan.path,
                crossings: plan.crossings,
                is_optimal,
                attempts: plan.attempts,
                seconds,
            })
        };
        let scratch = (0..layers.len()).map(|at| one(at, None)).collect::<anyhow::Result<Vec<_>>>()?;
        let mut below = vec![one(0, None)?];
        for at in 1..layers.len() {
            below.push(one(at, Some(&below[at - 1].path))?);
        }
        rows.push(row(name, "scratch", &scratch.iter().collect::<Vec<_>>()));
        rows.push(row(name, "layer below", &below.iter().collect::<Vec<_>>()));
        // The better of both, where each layer stands on the one chosen before it.
        for (stacking, start) in
            [(Stacking::Keep, "better, more kept"), (Stacking::Break, "better, fewer kept")]
        {
            let mut chosen = vec![one(0, None)?];
            for at in 1..layers.len() {
                let beneath = &chosen[at - 1].path;
                let (alone, aware) = (one(at, None)?, one(at, Some(beneath))?);
                let merit = |solved: &Solved| (solved.path.pieces(), solved.crossings);
                let kept = |solved: &Solved| kept_links(beneath, &solved.path);
                let takes_aware = match merit(&aware).cmp(&merit(&alone)) {
                    std::cmp::Ordering::Less => true,
                    std::cmp::Ordering::Greater => false,
                    std::cmp::Ordering::Equal => {
                        (kept(&aware) >= kept(&alone)) == (stacking == Stacking::Keep)
                    }
                };
                let seconds = alone.seconds + aware.seconds;
                let attempts = alone.attempts + aware.attempts;
                let better = if takes_aware { aware } else { alone };
                chosen.push(Solved { seconds, attempts, ..better });
            }
            rows.push(row(name, start, &chosen.iter().collect::<Vec<_>>()));
        }
        bar.inc(1);
    }
    Ok(rows)
}

fn row(part: &'static str, start: &'static str, layers: &[&Solved]) -> Row {
    let links = |solved: &Solved| solved.path.order().len() as u64 - u64::from(solved.path.pieces());
    let possible: u64 = layers[1..].iter().map(|solved| links(solved)).sum();
    let kept: u64 = layers.windows(2).map(|pair| u64::from(kept_links(&pair[0].path, &pair[1].path))).sum();
    Row {
        part,
        start,
        layers: layers.len(),
        pieces: layers.iter().map(|solved| u64::from(solved.path.pieces())).sum(),
        crossings: layers.iter().map(|solved| u64::from(solved.crossings)).sum(),
        layers_optimal: layers.iter().filter(|solved| solved.is_optimal).count(),
        kept: kept as f64 / possible as f64,
        attempts: layers.iter().map(|solved| u64::from(solved.attempts)).sum(),
        seconds: layers.iter().map(|solved| solved.seconds).sum(),
    }
}

pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "\nStarts from scratch and from the layer below, over layers that differ from the one below; continuous, on one thread:\n"
    )?;
    writeln!(
        text,
        "| part | layers | start | pieces | crossings | layers proven optimal | links kept | attempts | seconds |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|---|")?;
    for row in rows {
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {:.1} % | {} | {:.3} |",
            row.part,
            row.layers,
            row.start,
            row.pieces,
            row.crossings,
            row.layers_optimal,
            100.0 * row.kept,
            row.attempts,
            row.seconds
        )?;
    }
    Ok(())
}
