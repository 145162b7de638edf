//! A body cut into outlines.

use beadwork_grid::Zones;
use beadwork_mesh::{Mesh, Role};

use super::outline::Outline;

/// The outlines of one body in those layers that it reaches.
/// Of many small bodies, outlines in all layers would take more memory than all cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BodyCut {
    pub(super) role: Role,
    /// The object it is a part of.
    pub(super) object: usize,
    /// What its cells are made of.
    pub(super) material: BodyMaterial,
    /// The layer of the first outline.
    pub(super) first: usize,
    /// Outlines of consecutive layers.
    pub(super) outlines: Vec<Outline>,
    /// The surface and the colours of its triangles, if the body is painted.
    pub(super) painted: Option<(Mesh, Vec<u8>)>,
}

/// What the cells of a body are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyMaterial {
    /// One material.
    One(u8),
    /// None: the body is negative.
    None,
    /// The colours of the surface.
    FromSurface,
}

impl BodyCut {
    /// The outline in a layer; `None` if there is nothing.
    pub(super) fn layer(&self, number: usize) -> Option<&Outline> {
        self.outlines.get(number.checked_sub(self.first)?).filter(|outline| !outline.is_empty())
    }

    /// Whether cells of the body may have a material; outside is not a material.
    pub(super) fn may_have(&self, material: u8) -> bool {
        match self.material {
            BodyMaterial::One(own) => material == own,
            _ => material != Zones::OUTSIDE,
        }
    }
}
