//! Models: bodies and their materials.

use thiserror::Error;

use crate::bounds::Bounds;
use crate::mesh::Mesh;

/// Bodies in one coordinate system, and the materials they are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The bodies.
    /// Where two of them overlap, the later one counts.
    pub bodies: Vec<Body>,
    /// The materials; empty if the file names none.
    /// Files have at most [`Model::MAX_MATERIALS`]; [`Model::assign_materials`] may create more.
    pub materials: Vec<Material>,
}

/// A surface and the material inside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The name in the file; may be empty.
    pub name: String,
    /// The surface, in mm.
    pub mesh: Mesh,
    /// Index into [`Model::materials`]; `None` if the file does not state a material.
    /// Has no effect if the body is painted.
    pub material: Option<usize>,
    /// Painted bodies have a material for each triangle, as an index into [`Model::materials`];
    /// other bodies have an empty list.
    pub paint: Vec<u8>,
}

/// A material as a file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Material {
    /// The name; may be empty.
    pub name: String,
    /// Red, green and blue, if the file states a colour.
    pub colour: Option<[u8; 3]>,
}

/// A model has more materials than [`Model::MAX_MATERIALS`].
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("model would have {count} materials, maximum is {max}", max = Model::MAX_MATERIALS)]
pub struct TooManyMaterials {
    /// The number of materials.
    pub count: usize,
}

impl Model {
    /// Maximum number of materials that files may state: paint stores one byte per triangle.
    pub const MAX_MATERIALS: usize = 256;

    /// Adds the bodies and materials of another model in the same coordinate system.
    /// Does not merge materials; [`Model::assign_materials`] does.
    pub fn append(&mut self, other: Self) -> Result<(), TooManyMaterials> {
        let before = self.materials.len();
        let count = before + other.materials.len();
        if count > Self::MAX_MATERIALS {
            return Err(TooManyMaterials { count });
        }
        self.materials.extend(other.materials);
        self.bodies.extend(other.bodies.into_iter().map(|mut body| {
            body.material = body.material.map(|material| material + before);
            body.paint.iter_mut().for_each(|material| *material += before as u8);
            body
        }));
        Ok(())
    }

    /// The smallest box around all bodies.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        self.bodies.iter().for_each(|body| bounds.merge(&body.mesh.bounds()));
        bounds
    }

    /// Number of triangles of all bodies.
    pub fn triangle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.mesh.triangles().len()).sum()
    }
}
