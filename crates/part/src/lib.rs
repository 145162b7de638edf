//! What comes in and what goes out: zone pictures to regions and zones, layers and their paths to
//! drawings.
//!
//! - [`Picture`]: a PNG picture as a layer; each pixel is a cell, each colour a zone, transparent
//!   pixels lie outside.
//! - [`svg()`]: layers drawn side by side, with zones in colours, paths on top and crossings in
//!   red.
//! - [`mesh`]: STL, 3MF and OBJ files, repaired and put on the bed.
//! - [`mod@slice`]: meshes cut into layers of cells, and voxels.
//! - [`Pattern`]: the 38 named orders of deposition, each on any region; [`pattern_sheet`] draws
//!   them all.
//! - [`gcode`]: planned layers as the program of a printer, and such programs read, followed, timed
//!   and checked.
//!
//! Bytes come in, bytes or text go out: files are the caller's business.
//!
//! # Example
//! ```
//! use beadwork_grid::{Layout, LayoutSpec, Region, Start};
//! use beadwork_part::{Panel, Picture, svg};
//!
//! let region = Region::rectangle(20, 10)?;
//! let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0)?;
//! let picture = Picture { region, zones, colours: vec![[200, 0, 0], [0, 200, 0], [0, 0, 200]] };
//! let back = Picture::from_png(&picture.to_png())?;
//! assert_eq!(back, picture);
//!
//! let path = Start::RowZigzag.path(&back.region)?;
//! let panel = Panel { title: "row zigzag", region: &back.region, zones: &back.zones, path: Some(&path), links: &[] };
//! assert!(svg(&[panel], Some(&back.colours)).starts_with("<svg"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![cfg_attr(
    test,
    allow(clippy::float_cmp, reason = "numbers that are exact in binary are compared as such")
)]

mod frame;
pub mod gcode;
pub mod mesh;
mod pattern;
mod picture;
pub mod slice;
mod svg;

pub use frame::Frame;
pub use pattern::{Pattern, UnknownPattern, pattern_sheet};
pub use picture::{Picture, PictureError};
pub use svg::{Panel, svg};
