//! Repairs the surface of a body: closes it and turns it outwards.
//!
//! # Why holes can always be closed
//! The boundary of each triangle is a closed loop of three directed edges (*half-edges*).
//! Where two triangles share an edge and face the same side, they use it in opposite directions.
//! Remove such pairs of half-edges from the boundaries of all triangles: at every vertex, as many
//! of the remaining half-edges arrive as leave, so they form closed loops, the holes.
//! A fan of triangles fills each of them, and the result is closed, whatever the input was.
//!
//! # Steps
//! [`cleanup`] merges vertices, [`edges`] finds the triangles at each edge, [`components`] makes
//! neighbours face the same side, [`holes`] fills holes, and [`orientation`] turns the surface
//! outwards.

mod cleanup;
mod components;
mod edges;
mod holes;
mod orientation;
mod ray_tree;
mod report;

use beadwork_base::Control;

use self::components::Components;
use self::edges::Edges;
pub use self::report::{RepairError, RepairReport};
use crate::model::Body;
use crate::work::Work;

/// Times that the triangles are visited, for the progress.
const PASSES: usize = 6;

/// A body has a volume if it is thicker than this, averaged over a square of the size of its
/// diagonal, in mm.
const MIN_THICKNESS_MM: f64 = 1e-6;

impl Body {
    /// Closes the surface and turns it outwards.
    ///
    /// 1. Merges vertices with the same coordinates, and drops triangles that then have two equal
    ///    corners.
    /// 2. Makes neighbouring triangles face the same side: in each connected component, the
    ///    minority is flipped.
    /// 3. Fills holes that are flat, or small: with a perimeter of at most the diagonal of the
    ///    body.
    /// 4. Flips the body if it is inside out, and every connected component that is inside out
    ///    unless it lies inside another one: such a component is a cavity.
    ///    If thousands of components are inside out and lie above each other, some may be left as
    ///    they are.
    ///
    /// Nearly linear in the triangles; takes about as much memory again as the mesh.
    /// Progress counts triangles, each of them six times.
    ///
    /// After an error the mesh is still valid, but only some of the steps are done.
    pub fn repair(&mut self, control: &Control<'_>) -> Result<RepairReport, RepairError> {
        let mut report = RepairReport::default();
        let triangles = self.mesh.triangles().len();
        let mut work = Work::new(control, PASSES, triangles);
        report.merged_vertices = cleanup::merge_vertices(&mut self.mesh, &mut work)?;
        report.dropped_triangles = cleanup::drop_degenerate_triangles(self);
        work.end_pass();
        if self.mesh.triangles().is_empty() {
            return Err(RepairError::NoArea(triangles));
        }

        let mut edges = Edges::new(&self.mesh, &mut work)?;
        work.end_pass();
        let mut components = Components::new(&self.mesh, &edges, &mut work)?;
        work.end_pass();
        report.flipped_triangles = components.flip_minorities(&mut self.mesh);
        if report.flipped_triangles > 0 {
            edges = Edges::new(&self.mesh, &mut work)?;
        }
        work.end_pass();

        components.join_all(&edges, &mut work)?;
        report.closed_holes = holes::close(self, &edges, &mut components, &mut work)?;
        drop(edges);
        work.end_pass();
        report.flipped_triangles +=
            orientation::turn_outwards(&mut self.mesh, &mut components, &mut work)?;
        let volume = self.mesh.volume_mm3().abs();
        // It is NaN if the coordinates are so large that the volume overflows.
        let min_volume = MIN_THICKNESS_MM * self.mesh.bounds().diagonal_mm().powi(2);
        if volume.is_nan() || volume < min_volume {
            return Err(RepairError::NoVolume(triangles));
        }
        work.end_pass();
        Ok(report)
    }
}

#[cfg(test)]
mod tests;
