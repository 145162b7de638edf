//! What comes in and what goes out: zone pictures to regions and zones, layers and their paths to drawings.
//!
//! - [`Picture`]: a PNG picture as a layer; each pixel is a cell, each colour a zone, transparent pixels lie outside.
//! - [`svg()`]: layers drawn side by side, with zones in colours, paths on top and crossings in red.
//! - [`gcode`]: planned layers as the program of a printer, and such programs read, followed, timed and checked.
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

mod frame;
pub mod gcode;
mod picture;
mod svg;

pub use frame::Frame;
pub use picture::{Picture, PictureError};
pub use svg::{Panel, svg};
