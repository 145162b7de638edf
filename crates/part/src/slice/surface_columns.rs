//! Colours of the surface above and below the cells of a body.
//!
//! Outlines show the colours of walls only.
//! The colours of top and bottom faces are found where vertical lines through the centres of the
//! cells cross the surface.

use beadwork_mesh::Mesh;

use super::outline::{FillRule, Outline};
use super::raster::for_each_run;
use super::rectangle::Rectangle;
use crate::frame::Frame;

/// For each column of cells, where its vertical centre line crosses the surface of a body.
pub(super) struct SurfaceColumns {
    /// The cells that the body reaches; `None` if there are none.
    rectangle: Option<Rectangle>,
    /// `crossings[starts[cell]..starts[cell + 1]]` are those of the column of a cell of the
    /// rectangle.
    starts: Vec<u32>,
    crossings: Vec<Crossing>,
}

/// A point of the surface on the centre line of a column.
#[derive(Clone, Copy)]
struct Crossing {
    z_mm: f32,
    colour: u8,
}

impl SurfaceColumns {
    /// Intersects the columns of a grid with a surface that has one colour for each triangle.
    ///
    /// O(t + n log n) for t triangles and n crossings.
    pub(super) fn new(mesh: &Mesh, colours: &[u8], frame: &Frame) -> Self {
        let used = mesh.triangles().iter().flatten();
        let corners = used.map(|&vertex| mesh.vertices()[vertex as usize]);
        let rectangle = Rectangle::around(corners.map(|[x, y, _]| [x, y]), frame);
        let Some(rectangle) = rectangle else {
            return Self { rectangle: None, starts: Vec::new(), crossings: Vec::new() };
        };
        let mut found: Vec<(usize, Crossing)> = Vec::new();
        for (&triangle, &colour) in mesh.triangles().iter().zip(colours) {
            let corners = mesh.corners(triangle);
            let mut projected = Outline::default();
            corners.iter().for_each(|&[x, y, _]| projected.push([x, y], None));
            projected.close();
            let Some(plane) = Plane::through(corners) else { continue };
            for_each_run(&projected, FillRule::NonZero, frame, |row, first, end| {
                for column in first..end {
                    let z_mm = plane.height_mm(frame.centre(column, row)) as f32;
                    let cell = rectangle.index(column as usize, row as usize);
                    found.push((cell, Crossing { z_mm, colour }));
                }
            });
        }
        found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.z_mm.total_cmp(&b.1.z_mm)));
        let cells = rectangle.len();
        let mut starts = vec![0; cells + 1];
        found.iter().for_each(|&(cell, _)| starts[cell + 1] += 1);
        (0..cells).for_each(|cell| starts[cell + 1] += starts[cell]);
        let crossings = found.into_iter().map(|(_, crossing)| crossing).collect();
        Self { rectangle: Some(rectangle), starts, crossings }
    }

    /// The nearest crossing above or below a height on the centre line of a column and row of the
    /// grid: its distance in mm and its colour.
    pub(super) fn nearest(&self, column: usize, row: usize, z_mm: f64) -> Option<(f64, u8)> {
        let rectangle = self.rectangle.as_ref()?;
        if !rectangle.contains(column as f64, row as f64) {
            return None;
        }
        let cell = rectangle.index(column, row);
        let crossings = &self.crossings[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        let above = crossings.partition_point(|crossing| f64::from(crossing.z_mm) <= z_mm);
        let near = &crossings[above.saturating_sub(1)..crossings.len().min(above + 1)];
        let distance = |crossing: &Crossing| (f64::from(crossing.z_mm) - z_mm).abs();
        near.iter()
            .map(|crossing| (distance(crossing), crossing.colour))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// The plane of a triangle, as a height above each point.
struct Plane {
    corner: [f64; 3],
    /// Change of the height with x and with y.
    slope: [f64; 2],
}

impl Plane {
    /// `None` if the triangle is vertical.
    fn through([a, b, c]: [[f64; 3]; 3]) -> Option<Self> {
        let [u, v] = [b, c].map(|to| [0, 1, 2].map(|axis| to[axis] - a[axis]));
        let area = u[0] * v[1] - u[1] * v[0];
        let slope = [(u[2] * v[1] - v[2] * u[1]) / area, (u[0] * v[2] - v[0] * u[2]) / area];
        slope.iter().all(|value| value.is_finite()).then_some(Self { corner: a, slope })
    }

    fn height_mm(&self, [x, y]: [f64; 2]) -> f64 {
        self.corner[2] + self.slope[0] * (x - self.corner[0]) + self.slope[1] * (y - self.corner[1])
    }
}

#[cfg(test)]
mod tests {
    use beadwork_mesh::Solid;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 200,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        /// Compared with the formula of a sphere: a column crosses it twice, or not at all.
        #[test]
        fn a_sphere_is_crossed_twice(radius_mm in 2.0..5.0_f64, x in 0.0..1.0_f64, up: bool) {
            let mut mesh = Solid::Sphere { radius_mm, steps: 60 }.mesh();
            mesh.map_vertices(|at| [at[0] + x, at[1] + 6.0 - x, at[2] + 6.0], false);
            let colours = vec![3; mesh.triangles().len()];
            let frame = Frame {
                left_mm: -6.0,
                back_mm: 13.0,
                cell_mm: 0.5,
                layer_mm: 0.2,
                width: 26,
                height: 26,
            };
            let columns = SurfaceColumns::new(&mesh, &colours, &frame);
            for row in 0..frame.height {
                for column in 0..frame.width {
                    let [cx, cy] = frame.centre(column, row);
                    let squared = radius_mm.powi(2) - (cx - x).powi(2) - (cy - 6.0 + x).powi(2);
                    let from_mm = if up { 6.1 } else { 5.9 };
                    let nearest = columns.nearest(column as usize, row as usize, from_mm);
                    // The mesh is a little smaller than the sphere.
                    if squared > 1.0 {
                        let (distance_mm, colour) = nearest.unwrap();
                        prop_assert_eq!(colour, 3);
                        prop_assert!((distance_mm - squared.sqrt() + 0.1).abs() < 0.05);
                    } else if squared < 0.0 {
                        prop_assert!(nearest.is_none());
                    }
                }
            }
            let counts = columns.starts.windows(2).map(|pair| pair[1] - pair[0]);
            prop_assert!(counts.into_iter().all(|count| count == 0 || count == 2));
        }
    }
}
