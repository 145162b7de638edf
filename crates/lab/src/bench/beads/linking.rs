//! Run time of finding the permitted links and of linking lines, by the number of lines.

use std::f64::consts::TAU;
use std::fmt::Write;

use anyhow::Context;
use beadwork_base::{Control, Threads};
use beadwork_console::chart::{Axis, BLUE, Chart, GREEN, GREY, LineStyle, ORANGE, Series, charts};
use beadwork_console::{control, progress};
use beadwork_part::slice::{FillRule, LayerAreas, MaterialArea};
use beadwork_part::toolpath::{Infill, Settings, islands};
use beadwork_part::{Area, Ring};
use beadwork_search::link::{self, Method, Rule};
use serde::Serialize;

use crate::bench::timing::median_seconds;

/// Number of lines above which break points, which take the time of nearest neighbour for each end
/// of a bead, are not measured.
const MAX_BREAK_POINTS: usize = 3000;

/// Lines of a gear of this radius in mm are counted to choose the radius of others.
const SAMPLE_RADIUS_MM: f64 = 40.0;

/// Times for one number of lines, in s.
#[derive(Serialize)]
pub(super) struct Row {
    lines: usize,
    rule_seconds: f64,
    nearest: Linked,
    break_points: Option<Linked>,
    cover: Linked,
    /// Proven lower bound on the number of beads.
    bound: usize,
}

/// Result of one method.
#[derive(Serialize)]
struct Linked {
    seconds: f64,
    beads: usize,
}

/// Measures about these numbers of lines.
pub(super) fn measure(counts: &[u32], repeats: u64) -> anyhow::Result<Vec<Row>> {
    let control = &control::cancellable(Threads::One)?;
    let bar = progress::bar(counts.len() as u64, "bench linking");
    let sample = gear_infill(SAMPLE_RADIUS_MM, control)?.lines.len() as f64;
    let row = |&count: &u32| {
        let infill = infill_of(count as usize, sample, control)?;
        let row = row(&infill, repeats, control)?;
        bar.inc(1);
        Ok(row)
    };
    let rows = counts.iter().map(row).collect();
    bar.finish_and_clear();
    rows
}

/// Infill of a gear with about this number of lines.
fn infill_of(count: usize, sample: f64, control: &Control<'_>) -> anyhow::Result<Infill> {
    let mut radius_mm = SAMPLE_RADIUS_MM * count as f64 / sample;
    let mut infill = gear_infill(radius_mm, control)?;
    for _ in 0..4 {
        radius_mm *= count as f64 / infill.lines.len() as f64;
        infill = gear_infill(radius_mm, control)?;
    }
    Ok(infill)
}

/// The infill of the largest region of a gear with holes, at 100 % density.
fn gear_infill(radius_mm: f64, control: &Control<'_>) -> anyhow::Result<Infill> {
    let around = |centre: [f64; 2], corners: u32, radius: &dyn Fn(u32) -> f64| -> Ring {
        let corner = |number: u32| {
            let (sine, cosine) = (TAU * f64::from(number) / f64::from(corners)).sin_cos();
            [centre[0] + radius(number) * cosine, centre[1] + radius(number) * sine]
        };
        (0..corners).map(corner).collect()
    };
    let teeth = |number: u32| if number % 4 < 2 { radius_mm } else { 0.9 * radius_mm };
    let mut rings =
        vec![around([0.0; 2], 120, &teeth), around([0.0; 2], 60, &|_| 0.15 * radius_mm)];
    // Webs between them must be wide enough for infill.
    let holes = (radius_mm / 8.0).clamp(0.0, 12.0) as u32;
    for hole in 0..holes {
        let (sine, cosine) = (TAU * f64::from(hole) / f64::from(holes) + 0.1).sin_cos();
        for (share, size) in [(0.65, 0.1), (0.36, 0.06)] {
            let centre = [share * radius_mm * cosine, share * radius_mm * sine];
            rings.push(around(centre, 40, &|_| size * radius_mm));
        }
    }
    let area = Area::from_rings(&rings, FillRule::EvenOdd);
    let layer = LayerAreas { areas: vec![MaterialArea { material: 0, area }] };
    let settings = Settings { density: 1.0, ..Settings::default() };
    let layers = islands(&[layer], &settings, control)?;
    let infill = layers.into_iter().flatten().flat_map(|island| island.infill);
    infill.max_by_key(|infill| infill.lines.len()).context("gear without infill")
}

fn row(infill: &Infill, repeats: u64, control: &Control<'_>) -> anyhow::Result<Row> {
    let rings: Vec<Ring> = infill.region.rings().cloned().collect();
    let rule = Rule::default();
    let find = || rule.links(&infill.lines, &rings, infill.spacing_mm);
    let links = find()?;
    let rule_seconds = median_seconds(repeats, |_| {
        drop(find()?);
        Ok(())
    })?;
    let mut bound = 0;
    let mut linked = |method: Method| -> anyhow::Result<Linked> {
        let settings = link::Settings { method, ..link::Settings::default() };
        let solve = || link::solve(&links, &settings, control);
        let outcome = solve();
        bound = bound.max(outcome.bound);
        let seconds = median_seconds(repeats, |_| {
            drop(solve());
            Ok(control.check()?)
        })?;
        Ok(Linked { seconds, beads: outcome.beads.len() })
    };
    let nearest = linked(Method::Nearest)?;
    let is_short = infill.lines.len() <= MAX_BREAK_POINTS;
    let break_points = is_short.then(|| linked(Method::BreakPoints)).transpose()?;
    let cover = linked(Method::Cover)?;
    let lines = infill.lines.len();
    Ok(Row { lines, rule_seconds, nearest, break_points, cover, bound })
}

pub(super) fn table(rows: &[Row]) -> Result<String, std::fmt::Error> {
    let mut text = String::from(
        "| lines | permitted links, ms | NN: beads, ms | ns per line and log2 \
         | break points: beads, ms | cover: beads, bound, ms |\n|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let per = 1e9 * row.nearest.seconds / (row.lines as f64 * (row.lines as f64).log2());
        let linked = |linked: &Linked| format!("{}, {:.2}", linked.beads, 1e3 * linked.seconds);
        writeln!(
            text,
            "| {} | {:.2} | {} | {per:.0} | {} | {}, {}, {:.2} |",
            row.lines,
            1e3 * row.rule_seconds,
            linked(&row.nearest),
            row.break_points.as_ref().map_or("-".to_owned(), linked),
            row.cover.beads,
            row.bound,
            1e3 * row.cover.seconds,
        )?;
    }
    Ok(text)
}

/// Chart of the run times against the number of lines.
pub(super) fn svg(rows: &[Row]) -> anyhow::Result<String> {
    let series = |name: &str, colour, seconds: &dyn Fn(&Row) -> Option<f64>| {
        let point = |row: &Row| Some((row.lines as f64, 1e3 * seconds(row)?));
        let points = rows.iter().filter_map(point).collect();
        Series { name: name.to_owned(), colour, style: LineStyle::Dotted, points }
    };
    // What nearest neighbour would take in proportion to n log n, from its last measurement.
    let n_log_n = |lines: f64| lines * lines.log2();
    let scaled = rows.last().map_or(0.0, |last| last.nearest.seconds / n_log_n(last.lines as f64));
    let mut ideal = series("n log n", GREY, &|row| Some(scaled * n_log_n(row.lines as f64)));
    ideal.style = LineStyle::Thin;
    let chart = Chart {
        title: "Linking infill lines".to_owned(),
        x: Axis { label: "lines", logarithmic: true, shown: &[] },
        y: Axis { label: "ms", logarithmic: true, shown: &[] },
        series: vec![
            series("nearest neighbour", BLUE, &|row| Some(row.nearest.seconds)),
            ideal,
            series("break points", ORANGE, &|row| Some(row.break_points.as_ref()?.seconds)),
            series("cover", GREEN, &|row| Some(row.cover.seconds)),
        ],
    };
    charts(&[chart], 1, (560, 380))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gears_have_about_the_lines_wanted() {
        let rows = measure(&[60, 400], 1).unwrap();
        for (row, wanted) in rows.iter().zip([60.0, 400.0]) {
            assert!((row.lines as f64 / wanted - 1.0).abs() < 0.2, "{} {wanted}", row.lines);
            assert!(row.bound <= row.cover.beads && row.cover.beads <= row.nearest.beads);
        }
        assert_eq!(table(&rows).unwrap().lines().count(), 4);
        assert!(svg(&rows).unwrap().contains("break points"));
    }
}
