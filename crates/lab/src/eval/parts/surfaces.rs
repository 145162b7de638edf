//! The cells of a part compared with the surface that they fill.

use std::fmt::Write;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_console::progress::ProgressBar;
use beadwork_part::slice::{FillRule, Outline, cut};
use serde::Serialize;

use super::cases::Case;
use super::distances::{Distances, HALF};

/// One part.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    /// Volume of the meshes; if bodies overlap, volume within the outlines of the layers.
    solid_mm3: f64,
    /// Whether bodies overlap.
    overlap: bool,
    voxels_mm3: f64,
    /// Maximum distance from the sides of the cells to the outlines, in beads.
    #[serde(rename = "cells_off")]
    max_cell_distance: f64,
    /// Share of the outlines' length that has a side of a cell within half a bead.
    #[serde(rename = "outline_met")]
    outline_share_near: f64,
    /// Share of the remaining length where the part, or the gap next to it, is thinner than the
    /// diagonal of a cell, so that it can fit between the centres of cells; `None` if no length
    /// remains.
    #[serde(rename = "rest_thin")]
    thin_share_of_rest: Option<f64>,
    /// Maximum distance from points of the outlines to the sides of the cells, in beads; `None` if
    /// it is beyond 16.
    #[serde(rename = "outline_off")]
    max_outline_distance: Option<f64>,
}

pub(super) fn measure(cases: &[Case], bar: &ProgressBar) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for case in cases {
        if case.is_new_shape {
            rows.push(row(case)?);
        }
        bar.inc(1);
    }
    Ok(rows)
}

fn row(Case { name, part, .. }: &Case) -> anyhow::Result<Row> {
    let control = control::cancellable(Threads::One)?;
    let frame = part.layers.frame;
    let bodies = &part.model.bodies;
    let count = part.layers.layers.len();
    let outlines_of_bodies: Vec<Vec<Outline>> = bodies
        .iter()
        .map(|body| cut(&body.mesh, &[], frame.layer_mm, count, &control))
        .collect::<Result<_, _>>()?;
    let mut max_cell_distance: f64 = 0.0;
    let mut of_outline = Vec::new();
    let mut thin = Vec::new();
    let (mut union_mm2, mut sum_mm2) = (0.0, 0.0);
    for (number, layer) in part.layers.layers.iter().enumerate() {
        control.check()?;
        let mut all = Outline::default();
        outlines_of_bodies.iter().for_each(|outlines| all.append(&outlines[number]));
        // Where bodies touch or overlap, the outline of neither is on the surface of the part, so
        // distances are measured to the outlines of the union.
        let polygons = all.polygons(FillRule::NonZero);
        let union: Vec<&[[f64; 2]]> = polygons
            .iter()
            .flat_map(|polygon| std::iter::once(&polygon.outer).chain(&polygon.holes))
            .map(Vec::as_slice)
            .collect();
        union_mm2 += union.iter().map(|corners| area_mm2(corners)).sum::<f64>();
        sum_mm2 += all.area_mm2();
        let Some(layer) = layer else { continue };
        let distances = Distances::measure(layer, &union, &frame);
        max_cell_distance = distances.of_cells.into_iter().fold(max_cell_distance, f64::max);
        of_outline.extend(distances.of_outline);
        thin.extend(distances.thin);
    }
    let near = of_outline.iter().filter(|&&distance| distance <= HALF).count();
    let max_outline_distance = of_outline.iter().copied().fold(0.0, f64::max);
    let meshes_mm3: f64 = bodies.iter().map(|body| body.mesh.volume_mm3()).sum();
    let overlap = (sum_mm2 - union_mm2) / union_mm2 > 1e-3;
    Ok(Row {
        part: name,
        solid_mm3: if overlap { union_mm2 * frame.layer_mm } else { meshes_mm3 },
        overlap,
        voxels_mm3: part.layers.voxels().volume_mm3(),
        max_cell_distance,
        outline_share_near: near as f64 / of_outline.len() as f64,
        thin_share_of_rest: (!thin.is_empty())
            .then(|| thin.iter().filter(|&&thin| thin).count() as f64 / thin.len() as f64),
        max_outline_distance: max_outline_distance.is_finite().then_some(max_outline_distance),
    })
}

/// Area of a polygon: positive if its corners are in counterclockwise order, else negative.
fn area_mm2(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) / 2.0).sum()
}

pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "\nCells and surfaces; distances in beads along the axes of the grid, on the planes of \
         the cuts:\n\n\
         | part | solid mm³ | voxels mm³ | ratio | cells to surface, maximum \
         | surface within half a bead of the cells \
         | of the rest, where part or gap is thinner than a cell's diagonal | maximum |\n\
         |---|---|---|---|---|---|---|---|"
    )?;
    for row in rows {
        writeln!(
            text,
            "| {} | {:.1}{} | {:.1} | {:.4} | {:.3} | {:.2} % | {} | {} |",
            row.part,
            row.solid_mm3,
            if row.overlap { " (from outlines: bodies overlap)" } else { "" },
            row.voxels_mm3,
            row.voxels_mm3 / row.solid_mm3,
            row.max_cell_distance,
            100.0 * row.outline_share_near,
            row.thin_share_of_rest
                .map_or_else(|| "-".to_owned(), |thin| format!("{:.1} %", 100.0 * thin)),
            row.max_outline_distance
                .map_or_else(|| "beyond 16".to_owned(), |distance| format!("{distance:.3}"))
        )?;
    }
    Ok(())
}
