//! The shapes of the paper, with nearest neighbour from many random starts.

use std::fmt::{Display, Formatter, Write};

use beadwork_base::Control;
use serde::Serialize;

use super::cases::Case;
use super::methods::{Column, Regions};
use super::shapes::Shape;

/// Number of random starts: seeds from 0 on.
pub(super) const STARTS: u64 = 20;

/// A figure of all starts.
#[derive(Debug, Serialize)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) mean: f64,
    pub(super) max: f64,
}

/// Infill beads of all starts, for each layer of a flat shape, and for all layers of the manifold.
#[derive(Debug, Serialize)]
pub(super) struct Counts {
    pub(super) nearest: Range,
    pub(super) break_points: Range,
    /// Break points repeated from those of the best result until nothing improves.
    pub(super) repeated: Range,
    /// Nearest neighbour from all ends.
    pub(super) all_starts: f64,
    /// Of one start, on which it does not depend.
    pub(super) cover: Range,
}

/// A shape.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    shape: &'static str,
    /// Infill density in per cent.
    density: f64,
    /// Infill beads of nearest neighbour and of break points, as the paper states them.
    paper: Option<[u32; 2]>,
    #[serde(flatten)]
    counts: Counts,
    /// Reduction by break points in per cent, from the means.
    break_points_percent: f64,
    /// Reduction of each single start, which is what the paper states.
    break_points_percents: Range,
    /// Reduction by repeated break points in per cent, from the means.
    repeated_percent: f64,
    /// Reduction by cover in per cent.
    cover_percent: f64,
}

impl Range {
    fn new(values: &[f64]) -> Self {
        Self {
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            mean: values.iter().sum::<f64>() / values.len() as f64,
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

impl Counts {
    /// Reduction by a method compared with nearest neighbour, in per cent, from the means.
    pub(super) fn percent(&self, after: f64) -> f64 {
        100.0 * (1.0 - after / self.nearest.mean)
    }
}

impl Display for Range {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        let Self { min, mean, max } = self;
        write!(formatter, "{min} to {max} ({mean:.1})")
    }
}

/// Infill beads of the paper before and after; of the manifold it only states the reduction.
fn paper(shape: Shape) -> Option<[u32; 2]> {
    match shape {
        Shape::Disc => Some([2, 1]),
        Shape::Pacman => Some([4, 2]),
        Shape::FiveHoles => Some([7, 5]),
        Shape::OneHole | Shape::Pillars | Shape::Manifold => None,
    }
}

/// Infill beads of a method, for each start.
fn beads(
    regions: &Regions,
    column: Column,
    starts: u64,
    layers: usize,
    control: &Control<'_>,
) -> anyhow::Result<Vec<f64>> {
    let beads = |seed| {
        let linked = regions.link(column, seed, control)?;
        Ok(linked.infill_beads as f64 / layers as f64)
    };
    (0..starts).map(beads).collect()
}

/// Links infill by each method; counts are divided by a number of layers.
pub(super) fn counts(
    regions: &Regions,
    layers: usize,
    control: &Control<'_>,
) -> anyhow::Result<Counts> {
    let range = |column: Column| -> anyhow::Result<Range> {
        Ok(Range::new(&beads(regions, column, STARTS, layers, control)?))
    };
    // The results of these do not depend on a start.
    let once = |column: Column| -> anyhow::Result<f64> {
        Ok(beads(regions, column, 1, layers, control)?[0])
    };
    Ok(Counts {
        nearest: range(Column::NEAREST)?,
        break_points: range(Column::BREAK_POINTS)?,
        repeated: range(Column::REPEATED)?,
        all_starts: once(Column::ALL_STARTS)?,
        cover: Range::new(&[once(Column::COVER)?]),
    })
}

/// Links the infill of a shape by nearest neighbour and by break points, as the paper does, and by
/// cover.
pub(super) fn row(
    shape: Shape,
    case: &Case,
    regions: &Regions,
    control: &Control<'_>,
) -> anyhow::Result<Row> {
    // Flat shapes have an infill of each direction, which the paper's figures count one of.
    let layers = if shape == Shape::Manifold { 1 } else { case.layers.len() };
    let nearest = beads(regions, Column::NEAREST, STARTS, layers, control)?;
    let break_points = beads(regions, Column::BREAK_POINTS, STARTS, layers, control)?;
    let single: Vec<f64> = std::iter::zip(&nearest, &break_points)
        .map(|(before, after)| 100.0 * (1.0 - after / before))
        .collect();
    let counts = counts(regions, layers, control)?;
    Ok(Row {
        shape: shape.name(),
        density: 100.0 * case.toolpath.density,
        paper: paper(shape),
        break_points_percent: counts.percent(counts.break_points.mean),
        break_points_percents: Range::new(&single),
        repeated_percent: counts.percent(counts.repeated.mean),
        cover_percent: counts.percent(counts.cover.mean),
        counts,
    })
}

/// Appends the table.
pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "Infill beads of one layer, of the manifold in all layers: minimum to maximum (mean) of \
         {STARTS} random starts.\n\
         Reductions are those of single starts, as in the paper, and of the mean counts.\n"
    )?;
    writeln!(
        text,
        "| shape | density, % | paper: NN, break points | NN | break points | reduction, % \
         | of means | repeated | of means | all starts | cover | of means |"
    )?;
    writeln!(text, "|{}", "---|".repeat(12))?;
    for row in rows {
        let paper = match (row.paper, row.shape) {
            (Some([before, after]), _) => format!("{before}, {after}"),
            (None, "manifold") => "-21 %".to_owned(),
            _ => "-".to_owned(),
        };
        let Counts { nearest, break_points, repeated, all_starts, cover } = &row.counts;
        let Range { min, max, .. } = row.break_points_percents;
        writeln!(
            text,
            "| {} | {} | {paper} | {nearest} | {break_points} | {min:.1} to {max:.1} | {:.1} \
             | {repeated} | {:.1} | {all_starts} | {} | {:.1} |",
            row.shape,
            row.density,
            row.break_points_percent,
            row.repeated_percent,
            cover.mean,
            row.cover_percent
        )?;
    }
    writeln!(text)
}
