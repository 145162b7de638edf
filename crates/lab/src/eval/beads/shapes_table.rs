//! The table of shapes.

use std::fmt::Write;

use beadwork_base::Control;
use serde::Serialize;

use super::cases::{Case, Source};
use super::shapes::{LAYER_MM, Shape};

/// One shape.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    shape: &'static str,
    layers: usize,
    /// Connected components of all layers.
    islands: usize,
    /// Rings of the outlines of all layers.
    rings: usize,
    /// Closed loops at 0.25 mm and 0.75 mm from the outlines, of all layers.
    inset_beads: usize,
    volume_mm3: f64,
}

/// Lays out a shape.
pub(super) fn row(shape: Shape, source: &Source, control: &Control<'_>) -> anyhow::Result<Row> {
    let case = Case::new(source, 0.0, control)?;
    let islands = || case.layers.iter().flatten();
    Ok(Row {
        shape: shape.name(),
        layers: case.layers.iter().filter(|islands| !islands.is_empty()).count(),
        islands: islands().count(),
        rings: islands().map(|island| island.outline.rings().count()).sum(),
        inset_beads: islands().map(|island| island.insets.len()).sum(),
        volume_mm3: islands().map(|island| island.outline.size_mm2()).sum::<f64>() * LAYER_MM,
    })
}

/// Appends the table.
pub(super) fn table(text: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(text, "| shape | layers | islands | rings | inset beads | volume, mm³ |")?;
    writeln!(text, "|---|---|---|---|---|---|")?;
    for row in rows {
        let Row { shape, layers, islands, rings, inset_beads, volume_mm3 } = row;
        writeln!(
            text,
            "| {shape} | {layers} | {islands} | {rings} | {inset_beads} | {volume_mm3:.0} |"
        )?;
    }
    writeln!(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        let control = Control::default();
        let row = |shape| row(shape, &Source::shape(shape, &control)?, &control);
        Shape::ALL.into_iter().map(row).collect::<anyhow::Result<_>>().expect("shapes are valid")
    }

    #[test]
    fn shapes_have_the_rings_that_their_names_promise() {
        let per_layer = [
            ("disc", 1, 1),
            ("pacman", 1, 1),
            ("one-hole", 1, 2),
            ("five-holes", 1, 6),
            ("pillars", 40, 40),
        ];
        for (row, (shape, islands, rings)) in rows().iter().zip(per_layer) {
            assert_eq!(row.shape, shape);
            assert_eq!(
                [row.layers, row.islands, row.rings],
                [2, 2 * islands, 2 * rings],
                "{shape}"
            );
            assert_eq!(row.inset_beads, 4 * rings, "{shape}");
        }
    }

    #[test]
    fn volumes_match_formulas() {
        let disc = |radius: f64| std::f64::consts::PI * radius * radius;
        let areas = [
            disc(20.0),
            disc(20.0) * 5.0 / 6.0,
            2400.0 - disc(10.0),
            3600.0 - 5.0 * disc(6.0),
            40.0 * 25.0,
        ];
        for (row, area) in rows().iter().zip(areas) {
            let share = row.volume_mm3 / (area * 2.0 * LAYER_MM);
            // Circles have 96 or 180 corners.
            assert!((share - 1.0).abs() < 1e-3, "{}: {share}", row.shape);
        }
    }

    /// The paper's manifold: 183 layers, about 1,098 inset beads.
    #[test]
    fn manifold_has_the_counts_of_the_paper() {
        let rows = rows();
        let manifold = rows.last().expect("there are shapes");
        assert_eq!([manifold.layers, manifold.rings, manifold.inset_beads], [183, 549, 1098]);
        // In two pipes in 60 layers, else in one piece.
        assert_eq!(manifold.islands, 183 + 60);
    }
}
