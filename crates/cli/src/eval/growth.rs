//! How the time of the exact search grows with cells and with zones.

use std::fmt::Write;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::bail;
use beadwork_grid::{Layout, LayoutSpec, Region};
use beadwork_search::exact;
use indicatif::ProgressBar;
use serde_json::{Value, json};

use crate::cancel;

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
        let cancel = cancel::token()?;
        exact::solve(
            &region,
            &layer,
            &exact::Settings { cancel: Some(cancel), ..exact::Settings::default() },
        )?;
        if cancel.load(Ordering::Relaxed) {
            bail!("stopped");
        }
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

    /// Both curves with logarithmic axes.
    pub(super) fn svg(&self) -> String {
        const WIDTH: f64 = 460.0;
        const HEIGHT: f64 = 340.0;

        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{HEIGHT}\" viewBox=\"0 0 {0} {HEIGHT}\" \
             font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            2.0 * WIDTH
        );
        let over_cells: Vec<(f64, f64)> =
            self.cells.iter().map(|point| (f64::from(point.side * point.side), point.ms)).collect();
        let over_zones: Vec<(f64, f64)> =
            self.zones.iter().map(|point| (f64::from(point.zones), point.ms)).collect();
        panel(&mut svg, 0.0, "cells (3 zones)", &over_cells, true);
        panel(&mut svg, WIDTH, "zones (100 x 100 cells)", &over_zones, false);
        svg.push_str("</svg>\n");
        svg
    }
}

/// One curve in a frame with a line for each power of ten; a dashed line shows linear growth from its middle.
fn panel(svg: &mut String, left: f64, title: &str, points: &[(f64, f64)], with_linear: bool) {
    const FRAME: (f64, f64, f64, f64) = (64.0, 40.0, 440.0, 290.0);

    let decades = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) =
            values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        (low.log10().floor(), high.log10().ceil())
    };
    let (x_low, x_high) = decades(&mut points.iter().map(|point| point.0));
    let (y_low, y_high) = decades(&mut points.iter().map(|point| point.1));
    let x = |value: f64| left + FRAME.0 + (value.log10() - x_low) / (x_high - x_low) * (FRAME.2 - FRAME.0);
    let y = |value: f64| FRAME.3 - (value.log10() - y_low) / (y_high - y_low) * (FRAME.3 - FRAME.1);
    let (x0, x1, y0, y1) = (left + FRAME.0, left + FRAME.2, FRAME.1, FRAME.3);
    let mut line = |text: String| {
        svg.push_str(&text);
        svg.push('\n');
    };
    for power in x_low as i32..=x_high as i32 {
        let at = x(10_f64.powi(power));
        line(format!(
            "<path d=\"M{at:.1} {y0}V{y1}\" stroke=\"#dde\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            y1 + 18.0,
            decade(power)
        ));
    }
    for power in y_low as i32..=y_high as i32 {
        let at = y(10_f64.powi(power));
        line(format!(
            "<path d=\"M{x0} {at:.1}H{x1}\" stroke=\"#dde\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            x0 - 8.0,
            at + 4.0,
            decade(power)
        ));
    }
    line(format!(
        "<text x=\"{:.1}\" y=\"24\" text-anchor=\"middle\" font-weight=\"bold\">ms over {title}</text>",
        f64::midpoint(x0, x1)
    ));
    if with_linear {
        let (middle_x, middle_y) = points[points.len() / 2];
        let along = |value: f64| middle_y * value / middle_x;
        let (first, last) = (points[0].0, points[points.len() - 1].0);
        line(format!(
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"#999\" stroke-dasharray=\"5 4\"/>",
            x(first),
            y(along(first)),
            x(last),
            y(along(last))
        ));
    }
    let path: Vec<String> = points.iter().map(|&(px, py)| format!("{:.1} {:.1}", x(px), y(py))).collect();
    line(format!("<path d=\"M{}\" fill=\"none\" stroke=\"#0a5\" stroke-width=\"2\"/>", path.join("L")));
    for &(px, py) in points {
        line(format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"#0a5\"/>", x(px), y(py)));
    }
}

fn decade(power: i32) -> String {
    match power {
        -2..=4 => format!("{}", 10_f64.powi(power)),
        5 => "100,000".to_owned(),
        6 => "1,000,000".to_owned(),
        _ => format!("1e{power}"),
    }
}
