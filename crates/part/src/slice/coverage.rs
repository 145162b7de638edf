//! How much of each body the cells of a sliced part represent.
//!
//! Cells cannot represent what is thinner than a bead: thin walls and small bodies vanish.

use beadwork_base::{Control, Interrupted};
use beadwork_mesh::Role;

use super::body_cut::BodyCut;
use super::cut::Cut;
use super::layers::{Layer, Layers};
use super::raster::for_each_run;
use super::settings::Settings;
use super::work::Work;
use crate::frame::Frame;

/// What became of a body; of a body that is not solid, only the number of cells is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Number of cells of the grid with their centre inside the body, in all layers.
    pub cells: u64,
    /// Number of these that have a material of the body: later bodies may have taken the others.
    pub own_cells: u64,
    /// Length of its outlines in all layers, in mm.
    pub outline_mm: f64,
    /// Length of those stretches that are farther than a cell from any cell of the part.
    pub lost_mm: f64,
}

impl Cut {
    /// What became of each body of the model, in its order, in layers that [`Cut::layers`] returned
    /// for these settings.
    ///
    /// Progress counts layers.
    /// Takes about as long as [`Cut::layers`].
    pub fn coverage(
        &self,
        layers: &Layers,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Vec<Coverage>, Interrupted> {
        let work = Work::new(control, layers.layers.len());
        let bodies = self.bodies();
        let of_layers = control.threads.map_numbers(layers.layers.len(), |number| {
            work.unit(|| {
                let layer = layers.layers[number].as_ref();
                let of_body = |(at, body): (usize, &BodyCut)| {
                    (at, of_layer(body, number, layer, settings, &layers.frame))
                };
                let all = bodies.iter().enumerate();
                let reached = all.filter(|(_, body)| body.layer(number).is_some());
                reached.map(of_body).collect::<Vec<_>>()
            })
        });
        let mut sums = vec![Coverage::default(); bodies.len()];
        for of_layer in of_layers {
            for (body, coverage) in of_layer? {
                let sum = &mut sums[body];
                sum.cells += coverage.cells;
                sum.own_cells += coverage.own_cells;
                sum.outline_mm += coverage.outline_mm;
                sum.lost_mm += coverage.lost_mm;
            }
        }
        Ok(sums)
    }
}

fn of_layer(
    body: &BodyCut,
    number: usize,
    layer: Option<&Layer>,
    settings: &Settings,
    frame: &Frame,
) -> Coverage {
    let mut coverage = Coverage::default();
    let Some(outline) = body.layer(number) else { return coverage };
    if body.role != Role::Solid {
        for_each_run(outline, settings.fill_rule, frame, |_, first, end| {
            coverage.cells += u64::from(end - first);
        });
        return coverage;
    }
    let materials = layer.map(|layer| layer.zones.ids());
    let is_filled = |column: f64, row: f64| {
        let inside = (0.0..f64::from(frame.width)).contains(&column)
            && (0.0..f64::from(frame.height)).contains(&row);
        let index = || row as usize * frame.width as usize + column as usize;
        inside && layer.is_some_and(|layer| layer.region.contains(index() as u32))
    };
    for_each_run(outline, settings.fill_rule, frame, |row, first, end| {
        let Some(materials) = materials else { return };
        let row = row as usize * frame.width as usize;
        for &material in &materials[row + first as usize..row + end as usize] {
            coverage.cells += 1;
            coverage.own_cells += u64::from(body.may_have(material));
        }
    });
    for (from, to, _) in outline.lines() {
        let length_mm = (to[0] - from[0]).hypot(to[1] - from[1]);
        let steps = (length_mm / frame.cell_mm).ceil().max(1.0);
        coverage.outline_mm += length_mm;
        for step in 0..steps as u32 {
            let part = (f64::from(step) + 0.5) / steps;
            let sample = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
            let [column, row] = frame.column_and_row(sample);
            let near = [-1.0, 0.0, 1.0];
            let is_kept = near
                .iter()
                .any(|right| near.iter().any(|down| is_filled(column + right, row + down)));
            if !is_kept {
                coverage.lost_mm += length_mm / steps;
            }
        }
    }
    coverage
}

#[cfg(test)]
mod tests {
    use beadwork_mesh::{Body, Mesh, Model, Solid, Transform};

    use super::*;

    fn cuboid(min: [f64; 3], size_mm: [f64; 3]) -> Mesh {
        let mut mesh = Solid::Cuboid { size_mm }.mesh();
        Transform::translation(min).apply(&mut mesh);
        mesh
    }

    #[test]
    fn thin_and_hidden_bodies_are_found() {
        let boxes = [
            ([0.0, 0.0, 0.0], [10.0, 10.0, 1.0]),
            // Beyond the first one, and between two rows of cell centres.
            ([0.0, 20.3, 0.0], [10.0, 0.15, 1.0]),
            ([4.0, 4.0, 0.0], [2.0, 2.0, 1.0]),
            ([3.0, 3.0, 0.0], [4.0, 4.0, 1.0]),
        ];
        let body = |(number, (min, size_mm))| Body {
            mesh: cuboid(min, size_mm),
            material: Some(number),
            ..Body::default()
        };
        let bodies = boxes.into_iter().enumerate().map(body).collect();
        let model = Model { bodies, ..Model::default() };
        let (settings, control) = (Settings::default(), Control::default());
        let cut = Cut::new(&model, &settings, &control).unwrap();
        let layers = cut.layers(&settings, &control).unwrap();
        let [plate, wall, hidden, cover] = cut.coverage(&layers, &settings, &control).unwrap()[..]
        else {
            panic!("four bodies")
        };
        assert_eq!((plate.cells, plate.own_cells), (1600, 1600 - 256));
        assert_eq!((hidden.cells, hidden.own_cells), (64, 0));
        assert_eq!((cover.cells, cover.own_cells), (256, 256));
        assert_eq!((plate.lost_mm, hidden.lost_mm, cover.lost_mm), (0.0, 0.0, 0.0));
        assert!((plate.outline_mm - 160.0).abs() < 1e-9);
        assert_eq!((wall.cells, wall.own_cells), (0, 0));
        assert!((wall.lost_mm - wall.outline_mm).abs() < 1e-9);
    }
}
