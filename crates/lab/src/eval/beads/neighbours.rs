//! Neighbours of the paper's plate with holes and of its manifold, whose number of holes and
//! density it does not state.

use std::fmt::Write;

use beadwork_base::Control;
use beadwork_mesh::Model;
use serde::Serialize;

use super::cases::{Case, Source};
use super::methods::Regions;
use super::shapes::Shape;
use super::starts::{self, Counts};

/// Numbers of holes of the plates.
const HOLES: [usize; 5] = [2, 3, 4, 5, 6];

/// Infill densities in per cent.
const DENSITIES: [f64; 4] = [15.0, 20.0, 25.0, 30.0];

/// A shape at one density.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    shape: &'static str,
    /// Number of holes of a plate; `None` for the manifold.
    holes: Option<usize>,
    /// Infill density in per cent.
    density: f64,
    #[serde(flatten)]
    counts: Counts,
}

/// Links the infill of all shapes at all densities.
pub(super) fn rows(control: &Control<'_>) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for holes in HOLES {
        add(&mut rows, "plate", Some(holes), &Shape::plate(holes), control)?;
    }
    add(&mut rows, "manifold", None, &Shape::Manifold.model(), control)?;
    Ok(rows)
}

fn add(
    rows: &mut Vec<Row>,
    shape: &'static str,
    holes: Option<usize>,
    model: &Model,
    control: &Control<'_>,
) -> anyhow::Result<()> {
    let source = Source::model(shape, model, control)?;
    for density in DENSITIES {
        let case = Case::new(&source, density, control)?;
        let regions = Regions::new(&case, control)?;
        let layers = if holes.is_some() { case.layers.len() } else { 1 };
        let counts = starts::counts(&regions, layers, control)?;
        rows.push(Row { shape, holes, density, counts });
    }
    Ok(())
}

/// Appends the table.
pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(
        text,
        "Plates of 60 x 60 mm with holes of 12 mm, and the manifold, at several densities: infill \
         beads as above.\n"
    )?;
    writeln!(
        text,
        "| shape | density, % | NN | break points | of means, % | repeated | of means, % \
         | all starts | cover |"
    )?;
    writeln!(text, "|{}", "---|".repeat(9))?;
    for Row { shape, holes, density, counts } in rows {
        let holes = holes.map_or(String::new(), |holes| format!(", {holes} holes"));
        let Counts { nearest, break_points, repeated, all_starts, cover } = counts;
        writeln!(
            text,
            "| {shape}{holes} | {density} | {nearest} | {break_points} | {:.1} | {repeated} \
             | {:.1} | {all_starts} | {} |",
            counts.percent(break_points.mean),
            counts.percent(repeated.mean),
            cover.mean
        )?;
    }
    writeln!(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_rounds_have_no_more_beads() {
        let control = Control::default();
        for holes in HOLES {
            let mut rows = Vec::new();
            add(&mut rows, "plate", Some(holes), &Shape::plate(holes), &control).unwrap();
            for Row { counts, density, .. } in rows {
                let Counts { nearest, break_points, repeated, all_starts, cover } = counts;
                let ranges = [&repeated, &break_points, &nearest];
                assert!(ranges.is_sorted_by(|a, b| a.min <= b.min && a.max <= b.max), "{density}");
                assert!(cover.mean <= all_starts && all_starts <= repeated.min, "{density}");
            }
        }
    }

    #[test]
    fn plates_have_their_number_of_holes() {
        let control = Control::default();
        for holes in HOLES {
            let source = Source::model("plate", &Shape::plate(holes), &control).unwrap();
            let case = Case::new(&source, 20.0, &control).unwrap();
            assert_eq!(case.layers[0].len(), 1);
            assert_eq!(case.layers[0][0].outline.rings().count(), holes + 1);
        }
    }
}
