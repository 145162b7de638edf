//! Cells against the surface that they fill.

use std::collections::HashMap;
use std::fmt::Write;

use beadwork_part::Frame;
use beadwork_part::slice::{Layer, Outline, cut};
use indicatif::ProgressBar;
use serde::Serialize;

use super::Case;

/// One part.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    mesh_mm3: f64,
    voxels_mm3: f64,
    /// From the sides of the cells to the outlines, in beads: the greatest distance.
    cells_off: f64,
    /// From points of the outlines to the sides of the cells, in beads: that of 99 % of them, and the greatest.
    outline_off: [f64; 2],
}

pub(super) fn measure(cases: &[Case], bar: &ProgressBar) -> Vec<Row> {
    let mut rows = Vec::new();
    for Case { name, part, .. } in cases.iter().filter(|case| case.is_new_shape) {
        let frame = part.layers.frame;
        let count = part.layers.layers.len();
        let bodies = &part.model.bodies;
        let outlines: Vec<Vec<Outline>> =
            bodies.iter().map(|body| cut(&body.mesh, &[], frame.layer_mm, count, None)).collect();
        let mut cells_off: f64 = 0.0;
        let mut outline_off = Vec::new();
        // Where bodies touch or overlap, neither's outline is a border of the cells.
        let is_one = bodies.len() == 1;
        for (number, layer) in part.layers.layers.iter().enumerate() {
            let Some(layer) = layer.as_ref().filter(|_| is_one) else { continue };
            let outlines: Vec<&Outline> = outlines.iter().map(|outlines| &outlines[number]).collect();
            let (cells, outline) = distances(layer, &outlines, &frame);
            cells_off = cells.into_iter().fold(cells_off, f64::max);
            outline_off.extend(outline);
        }
        outline_off.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let last = outline_off.len().saturating_sub(1);
            outline_off.get((share * last as f64) as usize).copied().unwrap_or(f64::NAN)
        };
        rows.push(Row {
            part: name,
            mesh_mm3: bodies.iter().map(|body| body.mesh.volume_mm3()).sum(),
            voxels_mm3: part.layers.voxels().volume_mm3(),
            cells_off: if is_one { cells_off } else { f64::NAN },
            outline_off: [at(0.99), at(1.0)],
        });
        bar.inc(1);
    }
    rows
}

/// In beads: from the middle of each side of a cell to the outlines along its normal, and from points along the outlines to the nearest side.
fn distances(layer: &Layer, outlines: &[&Outline], frame: &Frame) -> (Vec<f64>, Vec<f64>) {
    // In units of cells, from the left and from the back.
    let place = |[x, y]: [f64; 2]| [(x - frame.left_mm) / frame.cell_mm, (frame.back_mm - y) / frame.cell_mm];
    let region = &layer.region;
    let inside = |x: i64, y: i64| {
        let (width, height) = (i64::from(region.width()), i64::from(region.height()));
        (0..width).contains(&x)
            && (0..height).contains(&y)
            && region.contains(region.cell(x as u32, y as u32))
    };
    // A side by the cell right of or below it, and whether it stands upright.
    let mut sides: HashMap<(i64, i64), Vec<bool>> = HashMap::new();
    for y in 0..=i64::from(region.height()) {
        for x in 0..=i64::from(region.width()) {
            if inside(x, y) != inside(x - 1, y) {
                sides.entry((x, y)).or_default().push(true);
            }
            if inside(x, y) != inside(x, y - 1) {
                sides.entry((x, y)).or_default().push(false);
            }
        }
    }
    let mut to_outline: HashMap<(i64, i64, bool), f64> = HashMap::new();
    let mut to_side = Vec::new();
    for outline in outlines {
        for corners in outline.loops() {
            for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                let (from, to) = (place(*from), place(*to));
                crossings(from, to, |x, y, upright, off| {
                    let nearest = to_outline.entry((x, y, upright)).or_insert(f64::INFINITY);
                    *nearest = nearest.min(off);
                });
                let length = (to[0] - from[0]).hypot(to[1] - from[1]);
                let steps = (5.0 * length).ceil().max(1.0);
                for step in 0..steps as u32 {
                    let part = f64::from(step) / steps;
                    to_side.push(nearest_side(
                        &sides,
                        [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis])),
                    ));
                }
            }
        }
    }
    let of_side = |(&(x, y), uprights): (&(i64, i64), &Vec<bool>)| {
        uprights
            .iter()
            .map(|&upright| to_outline.get(&(x, y, upright)).copied().unwrap_or(f64::INFINITY))
            .collect::<Vec<_>>()
    };
    (sides.iter().flat_map(of_side).collect(), to_side)
}

/// Where a line crosses the middle of a row or a column: tells the side nearest to it there and how far that is.
fn crossings(from: [f64; 2], to: [f64; 2], mut tell: impl FnMut(i64, i64, bool, f64)) {
    for axis in 0..2 {
        let (low, high) = if from[axis] <= to[axis] { (from, to) } else { (to, from) };
        let first = (low[axis] - 0.5).floor() as i64;
        let last = (high[axis] - 0.5).ceil() as i64;
        for line in first..=last {
            let middle = line as f64 + 0.5;
            // Both ends count: a line along a middle crosses it all the same.
            if middle < low[axis] || middle > high[axis] {
                continue;
            }
            let span = high[axis] - low[axis];
            let part = if span > 0.0 { (middle - low[axis]) / span } else { 0.0 };
            let across = low[1 - axis] + part * (high[1 - axis] - low[1 - axis]);
            let side = across.round() as i64;
            for side in [side - 1, side, side + 1] {
                let off = (across - side as f64).abs();
                // Along rows (y is fixed) sides stand upright.
                if axis == 1 { tell(side, line, true, off) } else { tell(line, side, false, off) }
            }
        }
    }
}

fn nearest_side(sides: &HashMap<(i64, i64), Vec<bool>>, [x, y]: [f64; 2]) -> f64 {
    let (column, row) = (x.floor() as i64, y.floor() as i64);
    let mut nearest = f64::INFINITY;
    for ring in 1..=16 {
        for cell_y in row - ring..=row + ring {
            for cell_x in column - ring..=column + ring {
                for &upright in sides.get(&(cell_x, cell_y)).into_iter().flatten() {
                    let begin = [cell_x as f64, cell_y as f64];
                    let end = if upright { [begin[0], begin[1] + 1.0] } else { [begin[0] + 1.0, begin[1]] };
                    let off = [x - x.clamp(begin[0], end[0]), y - y.clamp(begin[1], end[1])];
                    nearest = nearest.min(off[0].hypot(off[1]));
                }
            }
        }
        if nearest < ring as f64 {
            break;
        }
    }
    nearest
}

pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(text, "\nCells and surfaces; distances in beads, for parts of one body:\n")?;
    writeln!(
        text,
        "| part | mesh mm³ | voxels mm³ | ratio | cells to surface, greatest | surface to cells, 99 % of it | greatest |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|")?;
    let number = |value: f64| if value.is_nan() { "-".to_owned() } else { format!("{value:.3}") };
    for row in rows {
        writeln!(
            text,
            "| {} | {:.1} | {:.1} | {:.4} | {} | {} | {} |",
            row.part,
            row.mesh_mm3,
            row.voxels_mm3,
            row.voxels_mm3 / row.mesh_mm3,
            number(row.cells_off),
            number(row.outline_off[0]),
            number(row.outline_off[1])
        )?;
    }
    Ok(())
}
