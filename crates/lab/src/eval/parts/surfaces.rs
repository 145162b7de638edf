//! Cells against the surface that they fill.

use std::collections::HashMap;
use std::fmt::Write;

use beadwork_base::Control;
use beadwork_console::progress::ProgressBar;
use beadwork_part::Frame;
use beadwork_part::slice::{FillRule, Layer, Outline, cut};
use serde::Serialize;

use super::Case;

/// One part.
#[derive(Serialize)]
pub(super) struct Row {
    part: &'static str,
    /// Of the meshes; of the outlines where bodies overlap.
    solid_mm3: f64,
    overlap: bool,
    voxels_mm3: f64,
    /// From the sides of the cells to the outlines, in beads: the greatest distance.
    cells_off: f64,
    /// Share of the outlines' length that has a side of a cell within half a bead.
    outline_met: f64,
    /// Of the rest, the share where the part, or the gap before it, is thinner than the diagonal of
    /// a cell: it can lie between the middles of cells.
    /// `None` if there is no rest.
    rest_thin: Option<f64>,
    /// From points of the outlines to the sides of the cells, in beads: the greatest distance,
    /// `None` beyond 16.
    outline_off: Option<f64>,
}

pub(super) fn measure(cases: &[Case], bar: &ProgressBar) -> Vec<Row> {
    let mut rows = Vec::new();
    for Case { name, part, .. } in cases.iter().filter(|case| case.is_new_shape) {
        let frame = part.layers.frame;
        let count = part.layers.layers.len();
        let bodies = &part.model.bodies;
        let control = Control::default();
        let outlines: Vec<Vec<Outline>> = bodies
            .iter()
            .map(|body| cut(&body.mesh, &[], frame.layer_mm, count, &control))
            .collect::<Result<_, _>>()
            .expect("nothing interrupts it");
        let mut cells_off: f64 = 0.0;
        let mut outline_off = Vec::new();
        let mut rest_thin: Vec<bool> = Vec::new();
        let (mut united_mm2, mut apart_mm2) = (0.0, 0.0);
        for (number, layer) in part.layers.layers.iter().enumerate() {
            let mut all = Outline::default();
            outlines.iter().for_each(|outlines| all.append(&outlines[number]));
            // Where bodies touch or overlap, neither's outline is a border of the part.
            let polygons = all.polygons(FillRule::NonZero);
            let borders: Vec<&[[f64; 2]]> = polygons
                .iter()
                .flat_map(|polygon| std::iter::once(&polygon.outer).chain(&polygon.holes))
                .map(Vec::as_slice)
                .collect();
            united_mm2 += borders.iter().map(|border| area_mm2(border)).sum::<f64>();
            apart_mm2 += all.area_mm2();
            let Some(layer) = layer else { continue };
            let Distances { of_cells, of_outline, thin } = distances(layer, &borders, &frame);
            cells_off = of_cells.into_iter().fold(cells_off, f64::max);
            outline_off.extend(of_outline);
            rest_thin.extend(thin);
        }
        let met = outline_off.iter().filter(|&&off| off <= HALF).count();
        let greatest = outline_off.iter().copied().fold(0.0, f64::max);
        let meshes_mm3: f64 = bodies.iter().map(|body| body.mesh.volume_mm3()).sum();
        let overlap = (apart_mm2 - united_mm2) / united_mm2 > 1e-3;
        rows.push(Row {
            part: name,
            solid_mm3: if overlap { united_mm2 * frame.layer_mm } else { meshes_mm3 },
            overlap,
            voxels_mm3: part.layers.voxels().volume_mm3(),
            cells_off,
            outline_met: met as f64 / outline_off.len() as f64,
            rest_thin: (!rest_thin.is_empty()).then(|| {
                rest_thin.iter().filter(|&&thin| thin).count() as f64 / rest_thin.len() as f64
            }),
            outline_off: greatest.is_finite().then_some(greatest),
        });
        bar.inc(1);
    }
    rows
}

fn area_mm2(border: &[[f64; 2]]) -> f64 {
    let next = border.iter().cycle().skip(1);
    border.iter().zip(next).map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) / 2.0).sum()
}

/// Half a bead, and what rounding takes.
const HALF: f64 = 0.5 + 1e-9;

/// What one layer adds, in beads.
struct Distances {
    /// From the middle of each side of a cell to the outlines, along its normal.
    of_cells: Vec<f64>,
    /// From points along the outlines to the nearest side.
    of_outline: Vec<f64>,
    /// For each of those beyond half a bead, whether the part or the gap is thin there.
    thin: Vec<bool>,
}

fn distances(layer: &Layer, borders: &[&[[f64; 2]]], frame: &Frame) -> Distances {
    // In units of cells, from the left and from the back.
    let place = |[x, y]: [f64; 2]| {
        [(x - frame.left_mm) / frame.cell_mm, (frame.back_mm - y) / frame.cell_mm]
    };
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
    let mut of_outline = Vec::new();
    let mut thin = Vec::new();
    for corners in borders {
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
                let point = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                let off = nearest_side(&sides, point);
                of_outline.push(off);
                if off > HALF && length > 0.0 {
                    let normal = [(to[1] - from[1]) / length, (from[0] - to[0]) / length];
                    thin.push(is_thin(borders.iter().copied(), place, point, normal));
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
    Distances { of_cells: sides.iter().flat_map(of_side).collect(), of_outline, thin }
}

/// Where a line crosses the middle of a row or a column: tells the side nearest to it there and how
/// far that is.
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

/// Whether another line of the outlines lies within the diagonal of a cell of a point, along the
/// normal to either side.
fn is_thin<'a>(
    mut borders: impl Iterator<Item = &'a [[f64; 2]]>,
    place: impl Fn([f64; 2]) -> [f64; 2],
    point: [f64; 2],
    normal: [f64; 2],
) -> bool {
    let meets = |from: [f64; 2], to: [f64; 2]| {
        let [along, away] =
            [[to[0] - from[0], to[1] - from[1]], [from[0] - point[0], from[1] - point[1]]];
        let cross = normal[0] * along[1] - normal[1] * along[0];
        let on_ray = (away[0] * along[1] - away[1] * along[0]) / cross;
        let on_line = (away[0] * normal[1] - away[1] * normal[0]) / cross;
        cross != 0.0
            && (0.0..=1.0).contains(&on_line)
            && on_ray.abs() > 1e-6
            && on_ray.abs() < std::f64::consts::SQRT_2
    };
    borders.any(|corners| {
        corners
            .iter()
            .zip(corners.iter().cycle().skip(1))
            .any(|(from, to)| meets(place(*from), place(*to)))
    })
}

fn nearest_side(sides: &HashMap<(i64, i64), Vec<bool>>, [x, y]: [f64; 2]) -> f64 {
    let (column, row) = (x.floor() as i64, y.floor() as i64);
    let mut nearest = f64::INFINITY;
    for ring in 1..=16 {
        for cell_y in row - ring..=row + ring {
            for cell_x in column - ring..=column + ring {
                for &upright in sides.get(&(cell_x, cell_y)).into_iter().flatten() {
                    let begin = [cell_x as f64, cell_y as f64];
                    let end = if upright {
                        [begin[0], begin[1] + 1.0]
                    } else {
                        [begin[0] + 1.0, begin[1]]
                    };
                    let off = [x - x.clamp(begin[0], end[0]), y - y.clamp(begin[1], end[1])];
                    nearest = nearest.min(off[0].abs().max(off[1].abs()));
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
    writeln!(
        text,
        "\nCells and surfaces; distances in beads along the grid's axes, in the planes of the cuts:\n"
    )?;
    writeln!(
        text,
        "| part | solid mm³ | voxels mm³ | ratio | cells to surface, greatest | surface within half a bead of the cells | of the rest, where part or gap is thinner than a cell's diagonal | greatest |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|")?;
    for row in rows {
        writeln!(
            text,
            "| {} | {:.1}{} | {:.1} | {:.4} | {:.3} | {:.2} % | {} | {} |",
            row.part,
            row.solid_mm3,
            if row.overlap { " (from outlines: bodies overlap)" } else { "" },
            row.voxels_mm3,
            row.voxels_mm3 / row.solid_mm3,
            row.cells_off,
            100.0 * row.outline_met,
            row.rest_thin.map_or_else(|| "-".to_owned(), |thin| format!("{:.1} %", 100.0 * thin)),
            row.outline_off.map_or_else(|| "beyond 16".to_owned(), |off| format!("{off:.3}"))
        )?;
    }
    Ok(())
}
