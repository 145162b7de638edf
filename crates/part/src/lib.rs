//! Parts as layers: meshes sliced into cells, deposition patterns, planned layers as checked
//! programs, and pictures.
//!
//! - [`mod@slice`]: meshes cut into layers of cells, and voxels.
//! - [`Pattern`]: the 38 named deposition orders, each on any region; [`pattern_sheet`] draws them
//!   all.
//! - [`print`]: planned layers as the program of a printer, and the check of such a program.
//! - [`Picture`]: a PNG picture as a layer; each pixel is a cell, each colour a zone, transparent
//!   pixels lie outside.
//! - [`svg()`]: layers drawn side by side, with zones in colours, paths on top and crossings in
//!   red.
//!
//! Meshes come from `beadwork-mesh`; programs are `beadwork-gcode`'s.
//! Input and output are bytes or text: reading and writing files is up to the caller.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Layout, LayoutSpec, Region, Start};
//! use beadwork_part::{Panel, Picture, svg};
//!
//! let region = Region::rectangle(20, 10)?;
//! let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0)?;
//! let picture = Picture { region, zones, colours: vec![[200, 0, 0], [0, 200, 0], [0, 0, 200]] };
//! let back = Picture::from_png(&picture.to_png())?;
//! assert_eq!(back, picture);
//!
//! let path = Start::RowZigzag.path(&back.region, &Control::default())?;
//! let panel = Panel { title: "row zigzag", region: &back.region, zones: &back.zones, path: Some(&path), links: &[] };
//! assert!(svg(&[panel], Some(&back.colours)).starts_with("<svg"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![cfg_attr(
    test,
    allow(clippy::float_cmp, reason = "numbers that are exact in binary are compared as such")
)]

mod frame;
mod pattern;
mod picture;
pub mod print;
pub mod slice;
mod svg;

pub use frame::Frame;
pub use pattern::{Pattern, UnknownPattern, pattern_sheet};
pub use picture::{Picture, PictureError};
pub use svg::{Panel, svg};
