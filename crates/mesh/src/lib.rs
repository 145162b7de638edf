//! Meshes: what they are, how they are read from files, repaired and put on the bed.
//!
//! A [`Model`] is what one or more files hold: **bodies**, closed surfaces of triangles, each of a
//! **material** or painted with several.
//! [`Model::read`] takes the bytes of an STL, 3MF or OBJ file; [`repair`](Body::repair) makes a
//! surface closed and turned outwards and says what it changed; a [`Placement`] turns, scales and
//! puts a model on the bed.
//!
//! The readers are written here rather than taken from a library because an answer must name the
//! place of what is wrong and lose nothing: the known STL reader stops at the first `endsolid`, the
//! known 3MF reader takes a broken number for 0 and panics on a short transform, and neither can
//! say where.
//! Archives and XML are read by libraries.

mod example;
mod model;
mod obj;
mod package;
mod placement;
mod repair;
mod shapes;
mod stl;
mod surface;
mod threemf;

pub use example::Example;
pub use model::{Body, Format, Material, MaterialRule, Model, ReadError, ReadLimits};
pub use placement::{Placement, PlacementError, Transform};
pub use repair::{RepairError, RepairReport};
pub use shapes::Solid;
pub use surface::{Bounds, Mesh, MeshError};
