//! The table of shapes.

use std::fmt::Write;

use beadwork_base::{Control, Interrupted, Threads};
use beadwork_console::{control, machine, output};
use beadwork_mesh::{Model, Role};
use beadwork_part::slice::{FillRule, cut};
use beadwork_part::{Area, Ring};
use serde::Serialize;
use serde_json::json;

use super::shapes::{LAYER_MM, Shape};

/// Width of an inset in mm, and the number of insets along each ring.
const INSET_MM: f64 = 0.5;
const INSETS: u32 = 2;

/// Size in mm² up to which a ring is not printed.
const MIN_RING_MM2: f64 = 1e-3;

/// One shape.
#[derive(Debug, Serialize)]
struct Row {
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

/// Cuts all shapes and prints the table.
pub(super) fn run(as_json: bool) -> anyhow::Result<()> {
    let rows = control::quiet(Threads::One, |control| {
        Shape::ALL.into_iter().map(|shape| row(shape, control)).collect::<Result<Vec<_>, _>>()
    })??;
    if as_json {
        return output::json(&json!({ "machine": machine::facts(), "shapes": rows }));
    }
    let mut text = "| shape | layers | islands | rings | inset beads | volume, mm³ |\n\
                    |---|---|---|---|---|---|\n"
        .to_owned();
    for row in &rows {
        let Row { shape, layers, islands, rings, inset_beads, volume_mm3 } = row;
        writeln!(
            text,
            "| {shape} | {layers} | {islands} | {rings} | {inset_beads} | {volume_mm3:.0} |"
        )?;
    }
    output::text(&text)
}

fn row(shape: Shape, control: &Control<'_>) -> Result<Row, Interrupted> {
    let areas = areas(&shape.model(), shape.layers(), control)?;
    let rings = |areas: &[Area]| areas.iter().map(|area| area.rings().count()).sum::<usize>();
    let mut inset_beads = 0;
    for inset in 0..INSETS {
        control.check()?;
        let depth_mm = (f64::from(inset) + 0.5) * INSET_MM;
        let insets: Vec<Area> =
            areas.iter().map(|area| area.offset(-depth_mm).without_slivers(MIN_RING_MM2)).collect();
        inset_beads += rings(&insets);
    }
    Ok(Row {
        shape: shape.name(),
        layers: areas.iter().filter(|area| !area.is_empty()).count(),
        islands: areas.iter().map(|area| area.components().len()).sum(),
        rings: rings(&areas),
        inset_beads,
        volume_mm3: areas.iter().map(Area::size_mm2).sum::<f64>() * LAYER_MM,
    })
}

/// The areas of a model of one object and one material, layer by layer: the union of its solid
/// bodies without its negative ones.
fn areas(model: &Model, layers: usize, control: &Control<'_>) -> Result<Vec<Area>, Interrupted> {
    let mut areas: [Vec<Vec<Ring>>; 2] = [vec![Vec::new(); layers], vec![Vec::new(); layers]];
    for body in &model.bodies {
        let of_role = &mut areas[usize::from(body.role == Role::Negative)];
        for (rings, outline) in
            of_role.iter_mut().zip(cut(&body.mesh, &[], LAYER_MM, layers, control)?)
        {
            rings.extend(outline.loops().map(<[_]>::to_vec));
        }
    }
    let [solid, negative] = areas.map(|layers| {
        layers
            .into_iter()
            .map(|rings| Area::from_rings(&rings, FillRule::NonZero))
            .collect::<Vec<_>>()
    });
    Ok(solid.iter().zip(&negative).map(|(solid, negative)| solid.difference(negative)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        Shape::ALL.map(|shape| row(shape, &Control::default()).expect("not interrupted")).into()
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
