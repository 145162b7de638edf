//! Reads, repairs and places triangle meshes for 3D printing.
//!
//! - [`Model::read`] reads the bytes of an STL, 3MF or OBJ file.
//! - [`Body::repair`] closes the surface of a body, turns it outwards, and reports what it changed.
//! - [`Placement::apply`] scales, rotates and places a model on the print bed.
//! - [`Solid`] and [`Example`] create meshes without a file.
//!
//! # Terms
//! - A **mesh** is a list of vertices and a list of triangles that refer to them by number.
//! - A **body** is a mesh and what is inside: one **material**, or **paint**, a material for each
//!   triangle of its surface.
//! - A **model** is the content of one or more files: bodies and materials.
//! - An **object** is a group of bodies that belong together.
//!   Most bodies are **solid**; a **negative** body is subtracted from its object, and a
//!   **modifier** changes the material of its object where they overlap.
//!
//! # Units and axes
//! Lengths are in mm; z points up.
//! Vertices, triangles, bodies and materials are numbered from 0. Seen from outside, the vertices
//! of a triangle run counter-clockwise.
//!
//! # Example
//! ```
//! use std::fmt::Write;
//!
//! use beadwork_base::Control;
//! use beadwork_mesh::{Format, Model, Placement, ReadLimits, RepairSettings, Solid};
//!
//! // An STL file of a box with one missing triangle.
//! let solid = Solid::Cuboid { size_mm: [40.0, 30.0, 20.0] }.mesh();
//! let mut stl = String::from("solid box\n");
//! for &triangle in &solid.triangles()[1..] {
//!     stl += "facet normal 0 0 0\nouter loop\n";
//!     for [x, y, z] in solid.corners(triangle) {
//!         writeln!(stl, "vertex {x} {y} {z}")?;
//!     }
//!     stl += "endloop\nendfacet\n";
//! }
//! stl += "endsolid box\n";
//!
//! let control = Control::default();
//! let format = Format::from_file_name("box.stl").expect("the extension is known");
//! let mut model = Model::read(format, stl.as_bytes(), &ReadLimits::default(), &control)?;
//! let report = model.bodies[0].repair(&RepairSettings::default(), &control)?;
//! assert_eq!((report.closed_holes, report.flipped_triangles), (1, 0));
//! assert!((model.bodies[0].mesh.volume_mm3() - 24_000.0).abs() < 1e-6);
//!
//! // Stand it on its right side, in the centre of the bed.
//! Placement { rotation_degrees: [0.0, 90.0, 0.0], ..Placement::default() }.apply(&mut model)?;
//! assert_eq!(model.bounds().min, [115.0, 90.0, 0.0]);
//! assert_eq!(model.bounds().max, [135.0, 120.0, 40.0]);
//!
//! // Vertices and triangles as arrays.
//! let mesh = &model.bodies[0].mesh;
//! assert_eq!(mesh.vertex_array().dim(), (8, 3));
//! assert_eq!(mesh.triangle_array().dim(), (12, 3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is read
//! - STL, binary and text: each `solid` is a body.
//! - 3MF: all objects of the build with their transforms, units, components (also those in other
//!   documents of the archive), materials and colours, of whole objects and of triangles.
//!   A composite material is its largest constituent, multiproperties are the colour that covers
//!   them, and of a gradient the first corner of each triangle counts.
//! - Projects of PrusaSlicer, Bambu Studio and Orca Slicer in 3MF files: painted facets, filaments
//!   of objects and parts, negative volumes, modifiers that change the filament, filament colours,
//!   and purge volumes; of several plates, the first one.
//!
//! [`Model::warnings`] lists what a file contains and the model does not.
//! - OBJ: polygons, objects and materials.
//!   Colours (`.mtl` files), texture coordinates, normals and curved surfaces are ignored.
//!
//! # What is refused
//! Files that are malformed, with the line or the byte at fault; coordinates that are not finite;
//! files without triangles; files beyond the [`ReadLimits`], by default 32 million triangles or an
//! archive that unpacks to 1 GiB; more than 256 materials in one file.
//! Of 3MF files also those with an empty build, those that require extensions other than materials
//! and production, and objects whose shape is defined by another extension, such as beam lattices
//! and boolean operations.
//! A repair refuses bodies that enclose no volume, and holes that are neither small nor flat: they
//! are damage that a mesh editor has to fix.
//!
//! # Guarantees and limits
//! - A repaired body is closed: every edge is used as often in one direction as in the other.
//!   It may still intersect itself or other bodies, and more than two triangles may meet at an
//!   edge.
//! - Readers merge only vertices with equal coordinates.
//!   A repair also merges nearly equal ones, but only along open edges, so closed regions keep
//!   every detail.
//! - Readers take any bytes without a panic, in time and memory nearly linear in the bytes, or for
//!   3MF in the unpacked bytes and the triangles of all instances.
//! - Long calls take a [`Control`](beadwork_base::Control) and run on the calling thread.
//!   They can be cancelled within a fraction of a second, except that this may take seconds for a
//!   body of tens of millions of triangles of which some components are inside out.
//!
//! # Why not use an existing reader
//! The readers of this crate report the location of an error and lose no content.
//! The common STL reader stops at the first `endsolid`; the common 3MF reader reads malformed
//! numbers as 0 and panics if a transform is too short; neither reports a location.
//! Archives and XML are read by libraries.
#![cfg_attr(
    test,
    allow(clippy::float_cmp, reason = "numbers that are exact in binary are compared exactly")
)]

mod bounds;
mod example;
mod materials;
mod mesh;
mod model;
mod placement;
mod read;
mod repair;
mod solid;
mod stray_vertex;
mod transform;
mod vector;
mod warning;
mod weld;
mod work;

pub use bounds::Bounds;
pub use example::Example;
pub use materials::MaterialRule;
pub use mesh::{Mesh, MeshError};
pub use model::{Body, Material, Model, Role, TooManyMaterials};
pub use placement::{Placement, PlacementError};
pub use read::{Format, ReadError, ReadLimits};
pub use repair::{RepairError, RepairReport, RepairSettings};
pub use solid::Solid;
pub use stray_vertex::StrayVertex;
pub use transform::Transform;
pub use warning::ReadWarning;
