//! Run time of the exact search against the numbers of cells and zones.

use std::fmt::Write;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::chart::{Axis, Chart, GREEN, GREY, LineStyle, Series, charts};
use beadwork_console::control;
use beadwork_console::progress::ProgressBar;
use beadwork_grid::{Layout, LayoutSpec, Region};
use beadwork_search::exact;
use serde_json::{Value, json};

use crate::statistics::median;

/// One point of a curve.
struct Point {
    /// Side of the square grid, in cells.
    side: u32,
    zones: u8,
    /// Median over the seeds, in milliseconds.
    ms: f64,
}

/// Two curves: over the number of cells with 3 zones, and over the number of zones on 100x100
/// cells.
pub(super) struct Growth {
    over_cells: Vec<Point>,
    over_zones: Vec<Point>,
}

/// Seeds of each point.
const SEEDS: u64 = 15;

/// Sides of the grids of the first curve.
const SIDES: [u32; 11] = [20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1000];

/// Numbers of zones of the second curve.
const ZONES: [u8; 11] = [2, 3, 5, 8, 12, 20, 30, 50, 80, 120, 200];

/// Measures both curves on Voronoi zones, on one thread; if `smoke`, only the first four points of
/// each.
pub(super) fn measure(bar: &ProgressBar, smoke: bool) -> anyhow::Result<Growth> {
    let points = if smoke { 4 } else { SIDES.len() };
    bar.inc_length(2 * points as u64);
    let point = |side, zones| {
        let point = measure_point(side, zones);
        bar.inc(1);
        point
    };
    Ok(Growth {
        over_cells: SIDES[..points]
            .iter()
            .map(|&side| point(side, 3))
            .collect::<anyhow::Result<_>>()?,
        over_zones: ZONES[..points]
            .iter()
            .map(|&zones| point(100, zones))
            .collect::<anyhow::Result<_>>()?,
    })
}

fn measure_point(side: u32, zones: u8) -> anyhow::Result<Point> {
    let control = control::cancellable(Threads::One)?;
    let region = Region::rectangle(side, side)?;
    let spec = LayoutSpec { zones, ..LayoutSpec::new(Layout::Voronoi) };
    let mut ms = Vec::new();
    for seed in 0..SEEDS {
        let layer = spec.zones(&region, seed)?;
        let begin = Instant::now();
        exact::solve(&region, &layer, &exact::Settings::default(), &control)?;
        control.check()?;
        ms.push(1e3 * begin.elapsed().as_secs_f64());
    }
    Ok(Point { side, zones, ms: median(ms) })
}

impl Growth {
    pub(super) fn json(&self) -> Value {
        let points = |points: &[Point]| -> Vec<Value> {
            points
                .iter()
                .map(|point| json!({"side": point.side, "zones": point.zones, "ms": point.ms}))
                .collect()
        };
        json!({
            "seeds": SEEDS,
            "over_cells": points(&self.over_cells),
            "over_zones": points(&self.over_zones),
        })
    }

    pub(super) fn table(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "\n## Growth: median ms of {SEEDS} seeds\n")?;
        let sides = self.over_cells.iter().map(|point| point.side.to_string());
        curve_table(text, "side, 3 zones", sides, &self.over_cells)?;
        let zones = self.over_zones.iter().map(|point| point.zones.to_string());
        curve_table(text, "zones, 100x100", zones, &self.over_zones)
    }

    /// Chart of both curves with logarithmic axes.
    ///
    /// The chart over cells also shows linear growth through the central point, for comparison.
    pub(super) fn svg(&self) -> anyhow::Result<String> {
        let over_cells: Vec<(f64, f64)> = self
            .over_cells
            .iter()
            .map(|point| (f64::from(point.side * point.side), point.ms))
            .collect();
        let over_zones =
            self.over_zones.iter().map(|point| (f64::from(point.zones), point.ms)).collect();
        let (central_cells, central_ms) = over_cells[over_cells.len() / 2];
        let linear = [over_cells[0], over_cells[over_cells.len() - 1]]
            .map(|(cells, _)| (cells, central_ms * cells / central_cells));
        let line = |name: &str, colour, style, points| Series {
            name: name.to_owned(),
            colour,
            style,
            points,
        };
        let chart = |title: &str, label, series| Chart {
            title: title.to_owned(),
            x: Axis { label, logarithmic: true, shown: &[] },
            y: Axis { label: "ms", logarithmic: true, shown: &[] },
            series,
        };
        let over_cells = vec![
            line("exact search", GREEN, LineStyle::Dotted, over_cells),
            line("linear", GREY, LineStyle::Thin, linear.to_vec()),
        ];
        let over_zones = vec![line("exact search", GREEN, LineStyle::Dotted, over_zones)];
        let panels =
            [chart("3 zones", "cells", over_cells), chart("100 x 100 cells", "zones", over_zones)];
        charts(&panels, 2, (460, 340))
    }
}

/// A table of one curve: the sizes in the first row, the run times in the second.
fn curve_table(
    text: &mut String,
    name: &str,
    sizes: impl Iterator<Item = String>,
    points: &[Point],
) -> std::fmt::Result {
    writeln!(text, "| {name} | {} |", sizes.collect::<Vec<_>>().join(" | "))?;
    writeln!(text, "|---|{}", "---|".repeat(points.len()))?;
    let ms: Vec<String> = points.iter().map(|point| format!("{:.2}", point.ms)).collect();
    writeln!(text, "| ms | {} |\n", ms.join(" | "))
}
