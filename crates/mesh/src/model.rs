//! Models: bodies and their materials.

use ndarray::Array2;
use thiserror::Error;

use crate::bounds::Bounds;
use crate::mesh::Mesh;
use crate::warning::ReadWarning;

/// Bodies in one coordinate system, and the materials they are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The bodies; those of one object follow each other.
    /// Where two solid bodies overlap, the later one counts.
    pub bodies: Vec<Body>,
    /// The materials; empty if the file names none.
    /// Files have at most [`Model::MAX_MATERIALS`]; [`Model::assign_materials`] may create more.
    pub materials: Vec<Material>,
    /// Volumes in mm³ that are purged when one material follows another, `[from, to]`, if the file
    /// states them for all materials.
    pub purge_mm3: Option<Array2<f64>>,
    /// What the file contains that the model does not, or not exactly.
    pub warnings: Vec<ReadWarning>,
}

/// A surface and the material inside it.
///
/// Construct it with `..Body::default()`: fields may be added.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// What the body is for.
    pub role: Role,
    /// The number of the object that the body is a part of.
    /// Negative bodies and modifiers affect only the solid bodies of their own object.
    pub object: usize,
    /// Bodies with the same number are copies of one mesh of the file; `None` if there are no
    /// copies.
    pub copy_of: Option<usize>,
}

/// What a body is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// It is printed.
    #[default]
    Solid,
    /// It is subtracted from the solid bodies of its object.
    Negative,
    /// The solid bodies of its object have its material where it overlaps them.
    Modifier,
}

/// A material as a file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Material {
    /// The name; may be empty.
    pub name: String,
    /// Red, green and blue, if the file states a colour.
    pub colour: Option<[u8; 3]>,
}

impl Material {
    /// A material that is known by its colour only, which is also its name: `#RRGGBB`.
    pub(crate) fn of_colour(colour: [u8; 3]) -> Self {
        let [red, green, blue] = colour;
        Self { name: format!("#{red:02X}{green:02X}{blue:02X}"), colour: Some(colour) }
    }
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
    ///
    /// Purge volumes are kept only if one of the models has no materials: those between the
    /// materials of two files are unknown.
    /// If they are dropped, a warning is added.
    pub fn append(&mut self, other: Self) -> Result<(), TooManyMaterials> {
        let before = self.materials.len();
        let count = before + other.materials.len();
        if count > Self::MAX_MATERIALS {
            return Err(TooManyMaterials { count });
        }
        self.warnings.extend(other.warnings);
        if before == 0 {
            self.purge_mm3 = other.purge_mm3;
        } else if !other.materials.is_empty() && self.purge_mm3.take().or(other.purge_mm3).is_some()
        {
            self.warnings.push(ReadWarning::Ignored {
                what: "the purge volumes of one of several files".into(),
            });
        }
        let next = |number: Option<usize>| number.map_or(0, |number| number + 1);
        let objects = next(self.bodies.iter().map(|body| body.object).max());
        let meshes = next(self.bodies.iter().filter_map(|body| body.copy_of).max());
        self.materials.extend(other.materials);
        self.bodies.extend(other.bodies.into_iter().map(|mut body| {
            body.material = body.material.map(|material| material + before);
            body.paint.iter_mut().for_each(|material| *material += before as u8);
            body.object += objects;
            body.copy_of = body.copy_of.map(|mesh| mesh + meshes);
            body
        }));
        Ok(())
    }

    /// The smallest box around all solid bodies.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        self.solid_bodies().for_each(|body| bounds.merge(&body.mesh.bounds()));
        bounds
    }

    /// The bodies that are printed.
    pub fn solid_bodies(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.role == Role::Solid)
    }

    /// Number of triangles of all bodies.
    pub fn triangle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.mesh.triangles().len()).sum()
    }
}
