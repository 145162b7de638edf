//! Writes planned layers as a G-code program, and checks such a program from its text.
//!
//! - [`Print::new`] writes planned [`Layer`]s as a program, and returns it with its totals.
//! - [`check()`] checks from the text alone that a program prints exactly these layers.
//! - [`Settings`] describe the printer, its tools, the process, and purging at tool changes.
//!
//! # Terms
//! Filament is **retracted** before travel and **unretracted** before the next bead.
//! A **z-hop** raises the nozzle during travel.
//! **Purging** flushes the previous material out of the nozzle into a **prime tower** beside the
//! part.
//! A **lift** is a break between two beads, followed by travel.
//!
//! # Units and axes
//! As in G-code files: x right, y to the back, z up, all in mm; filament as a length in mm.
//! [`Frame`](crate::Frame) maps cells to bed coordinates.
//! Speeds are in mm/s.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_gcode::Program;
//! use beadwork_grid::{Layout, LayoutSpec, Region, cover};
//! use beadwork_part::Frame;
//! use beadwork_part::print::{self, Layer, Print, Purge, Settings, Title, Tool, PrimeTower};
//!
//! let region = Region::rectangle(20, 10)?;
//! let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0)?;
//! let path = cover(&region, &Control::default())?;
//! let layer = |number| Layer { number, region: &region, zones: &zones, path: &path };
//! let layers = [layer(0), layer(1)];
//!
//! let frame = Frame {
//!     left_mm: 100.0,
//!     back_mm: 100.0,
//!     cell_mm: 0.45,
//!     layer_mm: 0.2,
//!     width: 20,
//!     height: 10,
//! };
//! let tower = PrimeTower { left_mm: 120.0, front_mm: 50.0, width_mm: 30.0, depth_mm: 60.0 };
//! let purge = Some(Purge::uniform(2, 10.0, Some(tower)));
//! let settings = Settings { tools: vec![Tool::default(); 2], purge, ..Settings::default() };
//!
//! let title = Title { part: "plate", version: "0.1.0" };
//! let control = Control::default();
//! let print = Print::new(title, &layers, &frame, &settings, &control)?;
//! assert_eq!(print.totals.tool_changes, 20);
//!
//! let program: Program = print.program.emit().parse()?;
//! assert_eq!(print::check(&program, &layers, &frame, &settings, &control)?.cells, 400);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! Travel is straight, also across printed cells.
//! A tool change is a single `T` command; what the printer does for it depends on its firmware's
//! configuration.

mod check;
mod header;
mod layer;
mod prime_tower;
mod program;
mod settings;
mod settings_error;
mod text;
mod validate;
mod writer;

pub use check::{CellPosition, CheckError, Report, check};
pub use header::Title;
pub use layer::Layer;
pub use program::{Print, PrintError};
pub use settings::{
    CrossSection, Flavour, Nozzles, PrimeTower, Printer, Process, Purge, Settings, Tool,
};
pub use settings_error::SettingsError;
