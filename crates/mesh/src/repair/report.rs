//! What a repair changed, and what it refuses.

use beadwork_base::Interrupted;
use thiserror::Error;

use crate::stray_vertex::StrayVertex;

/// What a repair changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RepairReport {
    /// Vertices that were merged into others at the same position.
    pub merged_vertices: usize,
    /// Vertices that were merged into others nearby because the surface was open there.
    pub near_vertices: usize,
    /// The tolerance with which they were merged, in mm.
    pub merge_mm: f64,
    /// Triangles that were dropped because two of their corners coincide.
    pub dropped_triangles: usize,
    /// Triangles that were flipped because they faced the wrong side.
    pub flipped_triangles: usize,
    /// Holes that were filled.
    pub closed_holes: usize,
    /// Edges that were split because a vertex of the neighbouring triangles lies on them.
    pub closed_t_junctions: usize,
}

impl RepairReport {
    /// Whether nothing but equal vertices and T-junctions was changed: many formats cannot express
    /// that triangles share vertices, and a T-junction does not change the volume.
    pub fn was_sound(&self) -> bool {
        let Self { near_vertices, dropped_triangles, flipped_triangles, closed_holes, .. } = *self;
        (near_vertices, dropped_triangles, flipped_triangles, closed_holes) == (0, 0, 0, 0)
    }
}

/// Why a body cannot be repaired.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RepairError {
    /// Each triangle has two corners at the same position.
    #[error("surface has no area: all {0} triangles have coinciding corners")]
    NoArea(usize),
    /// The surface encloses nothing.
    #[error(
        "surface encloses no volume: {triangles} triangles{}{}",
        holes_hint(*.closed_holes, *.max_merge_mm),
        .stray.as_ref().map_or_else(String::new, |stray| format!("; {stray}"))
    )]
    NoVolume {
        /// Number of triangles.
        triangles: usize,
        /// Number of holes that were filled.
        closed_holes: usize,
        /// Maximum distance of vertices that were merged, in mm.
        max_merge_mm: f64,
        /// A vertex that is far away from nearly all others, if there is one.
        stray: Option<StrayVertex>,
    },
    /// A hole is too large to be filled without knowing what is missing.
    #[error(
        "hole of {edges} edges, {length_mm:.2} mm around, at ({:.2}, {:.2}, {:.2}) \
        is too large to be filled: it is longer than the body and not flat",
        .at_mm[0], .at_mm[1], .at_mm[2]
    )]
    Hole {
        /// Number of edges around the hole.
        edges: usize,
        /// Perimeter in mm.
        length_mm: f64,
        /// One of its corners in mm.
        at_mm: [f64; 3],
    },
    /// The caller ended the call early.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// What helps if a surface was so open that filling its holes closed each triangle separately.
fn holes_hint(closed_holes: usize, max_merge_mm: f64) -> String {
    match closed_holes {
        0 => String::new(),
        holes => format!(
            "; {holes} holes were closed: if its triangles are more than {max_merge_mm} mm apart, \
             merge vertices over a larger distance"
        ),
    }
}
