//! How the time of the exact search grows with cells and with zones.

use std::fmt::Write;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::chart::{Axis, Chart, GREEN, GREY, LineStyle, Series, charts};
use beadwork_console::control;
use beadwork_console::progress::ProgressBar;
use beadwork_grid::{Layout, LayoutSpec, Region};
use beadwork_search::exact;
use serde_json::{Value, json};

/// One point of a curve.
struct Point {
    side: u32,
    zones: u8,
    /// Medians over the seeds.
    ms: f64,
}

/// Two curves: over the cells with 3 zones, and over the zones on 100x100 cells.
pub(super) struct Growth {
    cells: Vec<Point>,
    zones: Vec<Point>,
}

/// Seeds of each point.
const SEEDS: u64 = 15;

/// Measures both curves on Voronoi zones.
pub(super) fn measure(bar: &ProgressBar, small: bool) -> anyhow::Result<Growth> {
    let sides = [20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1000];
    let zones = [2, 3, 5, 8, 12, 20, 30, 50, 80, 120, 200];
    // Only the small ones of both.
    let few = |all: usize| if small { 4 } else { all };
    let (sides, zones) = (&sides[..few(sides.len())], &zones[..few(zones.len())]);
    bar.inc_length((sides.len() + zones.len()) as u64);
    let points = |pairs: &mut dyn Iterator<Item = (u32, u8)>| {
        pairs
            .map(|(side, zones)| {
                let point = point(side, zones);
                bar.inc(1);
                point
            })
            .collect::<anyhow::Result<Vec<Point>>>()
    };
    Ok(Growth {
        cells: points(&mut sides.iter().map(|&side| (side, 3)))?,
        zones: points(&mut zones.iter().map(|&zones| (100, zones)))?,
    })
}

fn point(side: u32, zones: u8) -> anyhow::Result<Point> {
    let region = Region::rectangle(side, side)?;
    let spec = LayoutSpec { zones, ..LayoutSpec::new(Layout::Voronoi) };
    let mut ms = Vec::new();
    for seed in 0..SEEDS {
        let layer = spec.zones(&region, seed)?;
        let begin = Instant::now();
        control::quiet(Threads::One, |control| {
            exact::solve(&region, &layer, &exact::Settings::default(), control)?;
            Ok::<(), anyhow::Error>(control.check()?)
        })??;
        ms.push(1e3 * begin.elapsed().as_secs_f64());
    }
    ms.sort_by(f64::total_cmp);
    Ok(Point { side, zones, ms: ms[ms.len() / 2] })
}

impl Growth {
    pub(super) fn json(&self) -> Value {
        let points = |points: &[Point]| -> Vec<Value> {
            points
                .iter()
                .map(|point| json!({"side": point.side, "zones": point.zones, "ms": point.ms}))
                .collect()
        };
        json!({"seeds": SEEDS, "over_cells": points(&self.cells), "over_zones": points(&self.zones)})
    }

    pub(super) fn table(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "\n## Growth: median ms of {SEEDS} seeds\n")?;
        let row = |text: &mut String, name: &str, cells: &mut dyn Iterator<Item = String>| {
            writeln!(text, "| {name} | {} |", cells.collect::<Vec<_>>().join(" | "))
        };
        for (name, points) in [("side, 3 zones", &self.cells), ("zones, 100x100", &self.zones)] {
            let over_cells = name.starts_with("side");
            let head = |point: &Point| if over_cells { point.side } else { u32::from(point.zones) };
            row(text, name, &mut points.iter().map(|point| head(point).to_string()))?;
            writeln!(text, "|---|{}", "---|".repeat(points.len()))?;
            row(text, "ms", &mut points.iter().map(|point| format!("{:.2}", point.ms)))?;
            writeln!(text)?;
        }
        Ok(())
    }

    /// Both curves with logarithmic axes; beside that over the cells, linear growth from its
    /// middle.
    pub(super) fn svg(&self) -> anyhow::Result<String> {
        let cells: Vec<(f64, f64)> =
            self.cells.iter().map(|point| (f64::from(point.side * point.side), point.ms)).collect();
        let zones = self.zones.iter().map(|point| (f64::from(point.zones), point.ms)).collect();
        let (middle_cells, middle_ms) = cells[cells.len() / 2];
        let linear =
            [cells[0], cells[cells.len() - 1]].map(|(at, _)| (at, middle_ms * at / middle_cells));
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
            line("exact search", GREEN, LineStyle::Dotted, cells),
            line("linear", GREY, LineStyle::Thin, linear.to_vec()),
        ];
        let over_zones = vec![line("exact search", GREEN, LineStyle::Dotted, zones)];
        let panels =
            [chart("3 zones", "cells", over_cells), chart("100 x 100 cells", "zones", over_zones)];
        charts(&panels, 2, (460, 340))
    }
}
