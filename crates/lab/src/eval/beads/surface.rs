//! How close the outermost insets come to the outlines of the cut mesh.

use std::fmt::Write;

use beadwork_base::Control;
use beadwork_part::Ring;
use beadwork_part::toolpath::Island;
use serde::Serialize;

use super::cases::Case;

/// Deviation in mm within which a surface counts as exact.
const EXACT_MM: f64 = 0.02;

/// Maximum distance between measured points of an inset, in mm.
const STEP_MM: f64 = 0.5;

/// The surface of one part.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    part: String,
    /// Length of the outermost insets of all layers, in m.
    length_m: f64,
    /// Share of this length where the outer edge of the bead is within [`EXACT_MM`] of the outline.
    exact_share: f64,
    /// Maximum distance by which the outer edge lies beyond the outline, in mm.
    max_beyond_mm: f64,
    /// Maximum distance by which it lies inside: where an inset turns back before a wall that is
    /// too thin for it, which a skeleton fills.
    max_inside_mm: f64,
}

/// Lengths and deviations in mm.
#[derive(Clone, Copy, Default)]
struct Deviations {
    length: f64,
    exact: f64,
    beyond: f64,
    inside: f64,
}

/// Measures the insets of a case.
pub(super) fn row(case: &Case, control: &Control<'_>) -> anyhow::Result<Row> {
    let bead_mm = case.toolpath.bead_mm;
    let of_layer = |islands: &Vec<Island>| {
        let islands = islands.iter().map(|island| deviations(island, bead_mm));
        islands.fold(Deviations::default(), Deviations::and)
    };
    let layers = control.threads.map(&case.layers, of_layer);
    control.check()?;
    let all = layers.into_iter().fold(Deviations::default(), Deviations::and);
    Ok(Row {
        part: case.name.clone(),
        length_m: all.length / 1e3,
        exact_share: if all.length > 0.0 { all.exact / all.length } else { 1.0 },
        max_beyond_mm: all.beyond,
        max_inside_mm: all.inside,
    })
}

impl Deviations {
    fn and(self, other: Self) -> Self {
        Self {
            length: self.length + other.length,
            exact: self.exact + other.exact,
            beyond: self.beyond.max(other.beyond),
            inside: self.inside.max(other.inside),
        }
    }
}

/// Compares points along the outermost insets with the outline.
/// O(n²) for n corners.
fn deviations(island: &Island, bead_mm: f64) -> Deviations {
    let outline: Vec<&Ring> = island.outline.rings().collect();
    let mut all = Deviations::default();
    for inset in island.insets.iter().filter(|inset| inset.depth == 0) {
        for (from, to) in edges(&inset.ring) {
            let length_mm = distance(from, to);
            let count = (length_mm / STEP_MM).ceil().max(1.0);
            for number in 0..count as u32 {
                let part = (f64::from(number) + 0.5) / count;
                let point = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                let lines = outline.iter().flat_map(|ring| edges(ring));
                let nearest =
                    lines.map(|(a, b)| to_line(point, a, b)).fold(f64::INFINITY, f64::min);
                let inside_mm = nearest - 0.5 * bead_mm;
                let step_mm = length_mm / count;
                all.length += step_mm;
                all.exact += if inside_mm.abs() <= EXACT_MM { step_mm } else { 0.0 };
                all.beyond = all.beyond.max(-inside_mm);
                all.inside = all.inside.max(inside_mm);
            }
        }
    }
    all
}

fn edges(ring: &Ring) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance from a point to a line between two others.
fn to_line(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    let squared = x * x + y * y;
    let along = (point[0] - a[0]) * x + (point[1] - a[1]) * y;
    let part = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    distance(point, [a[0] + part * x, a[1] + part * y])
}

/// Appends the table.
pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "| part | outermost insets, m | within {EXACT_MM} mm of the outline, % \
         | maximum beyond it, mm | inside, where walls become thin, mm |"
    )?;
    writeln!(text, "|---|---|---|---|---|")?;
    for Row { part, length_m, exact_share, max_beyond_mm, max_inside_mm } in rows {
        writeln!(
            text,
            "| {part} | {length_m:.2} | {:.2} | {max_beyond_mm:.4} | {max_inside_mm:.3} |",
            100.0 * exact_share
        )?;
    }
    writeln!(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::beads::cases::Source;
    use crate::eval::beads::shapes::Shape;

    #[test]
    fn insets_of_shapes_follow_their_outlines() {
        let control = Control::default();
        for shape in [Shape::Pacman, Shape::FiveHoles, Shape::Manifold] {
            let source = Source::shape(shape, &control).unwrap();
            let row = row(&Case::new(&source, 0.0, &control).unwrap(), &control).unwrap();
            assert!(row.exact_share > 0.999 && row.max_beyond_mm < 0.02, "{row:?}");
        }
    }
}
