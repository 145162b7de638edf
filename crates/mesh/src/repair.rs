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
//! [`cleanup`] merges equal vertices, [`edges`] finds the triangles at each edge, [`near_vertices`]
//! merges nearly equal vertices where the surface is open, [`t_junctions`] splits triangles at
//! vertices on their edges, [`components`] makes neighbours face the same side, [`holes`] fills
//! holes, and [`orientation`] turns the surface outwards.

mod cleanup;
mod components;
mod edges;
mod holes;
mod near_vertices;
mod orientation;
mod ray_tree;
mod report;
mod settings;
pub(crate) mod shells;
mod t_junctions;

use beadwork_base::Control;

use self::components::Components;
use self::edges::Edges;
pub use self::report::{RepairError, RepairReport};
pub use self::settings::RepairSettings;
use crate::model::Body;
use crate::stray_vertex::StrayVertex;
use crate::work::Work;

/// Times that the triangles are visited, for the progress.
const PASSES: usize = 7;

/// A body has a volume if its mean thickness, twice its volume divided by its surface, is at least
/// this, in mm.
const MIN_THICKNESS_MM: f64 = 1e-6;

impl Body {
    /// Closes the surface and turns it outwards.
    ///
    /// 1. Merges vertices with the same coordinates.
    ///    Where the surface is open, merges nearly equal vertices too, with the smallest tolerance
    ///    that closes it.
    ///    Drops triangles that then have two equal corners.
    ///    Splits triangles at vertices that lie on their open edges (T-junctions).
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
    /// Progress counts triangles, each of them seven times.
    ///
    /// After an error the mesh is still valid, but only some of the steps are done.
    pub fn repair(
        &mut self,
        settings: &RepairSettings,
        control: &Control<'_>,
    ) -> Result<RepairReport, RepairError> {
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
        let max_merge_mm = settings.max_merge_mm(&self.mesh.bounds());
        let mut odd = edges.odd(&mut work)?;
        if !odd.is_empty() {
            let merged = near_vertices::merge(&mut self.mesh, &odd, max_merge_mm, &mut work)?;
            if merged.vertices > 0 {
                (report.near_vertices, report.merge_mm) = (merged.vertices, merged.tolerance_mm);
                report.dropped_triangles += cleanup::drop_degenerate_triangles(self);
                if self.mesh.triangles().is_empty() {
                    return Err(RepairError::NoArea(triangles));
                }
                edges = Edges::new(&self.mesh, &mut work)?;
                odd = edges.odd(&mut work)?;
            }
            report.closed_t_junctions = t_junctions::close(self, &odd, max_merge_mm, &mut work)?;
            if report.closed_t_junctions > 0 {
                // A vertex may lie on two edges of a triangle without area.
                report.dropped_triangles += cleanup::drop_degenerate_triangles(self);
                edges = Edges::new(&self.mesh, &mut work)?;
            }
        }
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
        let min_volume = MIN_THICKNESS_MM * self.mesh.surface_mm2() / 2.0;
        if volume.is_nan() || volume <= 0.0 || volume < min_volume {
            let stray = StrayVertex::find(&std::iter::once(&*self));
            let closed_holes = report.closed_holes;
            return Err(RepairError::NoVolume { triangles, closed_holes, max_merge_mm, stray });
        }
        work.end_pass();
        Ok(report)
    }
}

#[cfg(test)]
mod tests;
