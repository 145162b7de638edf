//! The shapes of the paper, with nearest neighbour from many random starts.

use std::fmt::Write;

use beadwork_base::Control;
use serde::Serialize;

use super::cases::Case;
use super::methods::{Column, Regions};
use super::shapes::Shape;

/// Number of random starts: seeds from 0 on.
pub(super) const STARTS: u64 = 20;

/// Infill beads of a method from all starts, for each layer of a flat shape, and for all layers of
/// the manifold.
#[derive(Debug, Serialize)]
pub(super) struct Beads {
    pub(super) min: f64,
    pub(super) mean: f64,
    pub(super) max: f64,
}

/// A shape.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    shape: &'static str,
    /// Infill density in per cent.
    density: f64,
    /// Infill beads of nearest neighbour and of break points, as the paper states them.
    paper: Option<[u32; 2]>,
    pub(super) nearest: Beads,
    pub(super) break_points: Beads,
    /// Reduction by break points in per cent, from the means.
    break_points_percent: f64,
    pub(super) cover: Beads,
    /// Reduction by cover in per cent.
    cover_percent: f64,
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
    let beads = |column: Column, starts: u64| -> anyhow::Result<Beads> {
        let counts = (0..starts)
            .map(|seed| {
                let linked = regions.link(column, seed, control)?;
                Ok(linked.infill_beads as f64 / layers as f64)
            })
            .collect::<anyhow::Result<Vec<f64>>>()?;
        Ok(Beads {
            min: counts.iter().copied().fold(f64::INFINITY, f64::min),
            mean: counts.iter().sum::<f64>() / counts.len() as f64,
            max: counts.iter().copied().fold(0.0, f64::max),
        })
    };
    let nearest = beads(Column::NEAREST, STARTS)?;
    let break_points = beads(Column::BREAK_POINTS, STARTS)?;
    let cover = beads(Column::COVER, 1)?;
    let percent = |after: &Beads| 100.0 * (1.0 - after.mean / nearest.mean);
    Ok(Row {
        shape: shape.name(),
        density: 100.0 * case.toolpath.density,
        paper: paper(shape),
        break_points_percent: percent(&break_points),
        cover_percent: percent(&cover),
        nearest,
        break_points,
        cover,
    })
}

/// Appends the table.
pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "Infill beads of one layer, of the manifold in all layers: minimum to maximum (mean) of \
         {STARTS} random starts.\n"
    )?;
    writeln!(
        text,
        "| shape | density, % | paper: NN, break points | NN | break points | reduction, % | cover \
         | reduction, % |"
    )?;
    writeln!(text, "|{}", "---|".repeat(8))?;
    for row in rows {
        let range = |beads: &Beads| {
            let Beads { min, mean, max } = beads;
            format!("{min} to {max} ({mean:.1})")
        };
        let paper = match (row.paper, row.shape) {
            (Some([before, after]), _) => format!("{before}, {after}"),
            (None, "manifold") => "-21 %".to_owned(),
            _ => "-".to_owned(),
        };
        writeln!(
            text,
            "| {} | {} | {paper} | {} | {} | {:.0} | {} | {:.0} |",
            row.shape,
            row.density,
            range(&row.nearest),
            range(&row.break_points),
            row.break_points_percent,
            row.cover.mean,
            row.cover_percent
        )?;
    }
    writeln!(text)
}
