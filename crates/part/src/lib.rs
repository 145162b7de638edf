//! Parts as layers of cells: slicing, deposition patterns, printing, pictures.
//!
//! - [`mod@slice`]: cuts meshes into layers of cells; [`Voxels`](slice::Voxels) are all layers as
//!   an array.
//! - [`mod@toolpath`]: lays out insets and infill in the areas of each layer.
//! - [`Pattern`]: the 38 named deposition orders, for any region; [`pattern_sheet`] draws them all.
//! - [`LineOrder`]: named orders of the whole lines of a layer, and [`Lines`], which callers may
//!   permute; [`Sequence`]: the orders behind them, for beads or anything else that is numbered.
//! - [`BeadRows`]: the same orders for parallel beads, such as infill lines.
//! - [`Order`]: a pattern or an order of lines.
//! - [`mod@print`]: writes planned layers, of cells or of beads, as G-code for Marlin or Klipper,
//!   and checks such a program from its text.
//! - [`Picture`]: reads a PNG picture as a layer, and writes one.
//! - [`svg()`]: draws layers with zones, paths and crossings; [`bead_svg()`]: layers of beads.
//!
//! Meshes come from `beadwork-mesh`; G-code is read and emitted by `beadwork-gcode`.
//!
//! # Terms
//! A **cell** is a square one bead wide; a **layer** is a grid of cells of which some belong to the
//! part.
//! A **voxel** is a cell with the height of a layer.
//! A **bead** is a line of extruded material, printed without interruption.
//! A **material** is the number of the tool that prints it; within a layer, the cells of a material
//! are a **zone**.
//! The [`Frame`] is the position of the grid on the printer's bed.
//!
//! # Example
//! A mesh is sliced, and the order of each layer follows a pattern:
//! ```
//! use beadwork_base::Control;
//! use beadwork_mesh::{Body, Model, Solid};
//! use beadwork_part::Pattern;
//! use beadwork_part::slice::{self, slice};
//!
//! let mesh = Solid::Frustum { sides_mm: [8.0, 4.0], height_mm: 2.0 }.mesh();
//! let body = Body { name: "frustum".into(), mesh, material: Some(0), ..Body::default() };
//! let model = Model { bodies: vec![body], ..Model::default() };
//!
//! let settings = slice::Settings { cell_mm: 0.5, layer_mm: 0.25, ..slice::Settings::default() };
//! let layers = slice(&model, &settings, &Control::default())?;
//! assert_eq!(layers.voxels().materials().dim(), (8, 16, 16));
//!
//! let layer = layers.layers[7].as_ref().expect("the top layer has cells");
//! let order = Pattern::CONVENTIONAL.order(&layer.region);
//! assert_eq!(order.len(), layer.region.cell_count() as usize);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A layer is written as a picture and drawn with a path:
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Layout, LayoutSpec, Region, Start};
//! use beadwork_part::{Panel, Picture, svg};
//!
//! let region = Region::rectangle(20, 10)?;
//! let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0)?;
//! let colours = vec![[200, 0, 0], [0, 200, 0], [0, 0, 200]];
//! let picture = Picture { region, zones, colours };
//! assert_eq!(Picture::from_png(&picture.to_png())?, picture);
//!
//! let Picture { region, zones, colours } = &picture;
//! let path = Start::RowZigzag.path(region, &Control::default())?;
//! let panel = Panel { title: "row zigzag", region, zones, path: Some(&path), links: &[] };
//! assert!(svg(&[panel], Some(colours)).starts_with("<svg"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//! [`mod@print`] has an example of its own.
//!
//! # Guarantees
//! Nothing here does I/O, reads a clock or starts a thread: files are bytes or text.
//! Results do not depend on the number of threads, and texts not on the machine.
//! A program that passes [`print::check()`] prints each cell of its layers once, in the order of
//! the paths.
//! One that passes [`print::check_beads`] prints each move of its beads once, in order, within the
//! outlines.
//!
//! # Limits
//! Insets and infill of a part have one bead width.
//! Supports are not generated, and bridges are printed like other infill.
//! Parts thinner than a bead may have no cells.
//! [`Region::MAX_SIDE`](beadwork_grid::Region::MAX_SIDE) limits the cells of a side,
//! [`Zones::MAX`](beadwork_grid::Zones::MAX) the number of materials.
//!
//! # Features
//! None.
#![cfg_attr(
    test,
    allow(clippy::float_cmp, reason = "numbers that are exact in binary are compared as such")
)]

mod area;
mod bead;
mod bead_svg;
mod crossings;
mod frame;
mod measure;
mod offset;
mod order;
mod pattern;
mod picture;
pub mod print;
mod simplify;
pub mod slice;
mod svg;
pub mod toolpath;

pub use area::{Area, Ring};
pub use bead::{Bead, BeadLayer, ExtrusionMove};
pub use bead_svg::{BeadPanel, bead_svg};
pub use frame::Frame;
pub use order::{
    Axis, BeadRows, Corner, Ends, InvalidStride, LineOrder, LineOrderError, Lines, Order,
    PermutationError, Sequence, SequenceError, Stride, TurnedBead, UnknownOrder, turn_beads,
};
pub use pattern::{Pattern, UnknownPattern, pattern_sheet};
pub use picture::{Picture, PictureError};
pub use svg::{Panel, svg};
