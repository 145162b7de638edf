//! Writes planned layers as a G-code program, and checks such a program from its text.
//!
//! - [`Print::new`] writes planned [`Layer`]s of cells as a program, and returns it with its
//!   totals; [`Print::of_beads`] does so with layers of beads ([`BeadLayer`](crate::BeadLayer)).
//! - [`check()`] checks from the text alone that a program prints exactly these cells, and
//!   [`check_beads`] that it prints these beads, within the outlines of the part.
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
//! Layers of cells:
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
//! A layer of beads: a square wall with a line of infill in it.
//! ```
//! use beadwork_base::Control;
//! use beadwork_gcode::{Feature, Program};
//! use beadwork_part::print::{self, BeadLimits, Print, Process, Settings, Title, Tool};
//! use beadwork_part::slice::FillRule;
//! use beadwork_part::{Area, Bead, BeadLayer, ExtrusionMove, Frame};
//!
//! let bead = |feature, corners: &[[f64; 2]]| Bead {
//!     tool: 0,
//!     start_mm: corners[0],
//!     moves: corners[1..]
//!         .iter()
//!         .map(|&to_mm| ExtrusionMove { to_mm, width_mm: 0.45, feature })
//!         .collect(),
//! };
//! let (low, high) = (100.225, 109.775);
//! let wall = [[low, low], [high, low], [high, high], [low, high], [low, low]];
//! let wall = bead(Feature::OuterWall, &wall);
//! let infill = bead(Feature::Infill, &[[101.0, 101.0], [109.0, 109.0]]);
//! let layers = [BeadLayer { number: 0, beads: vec![wall, infill] }];
//!
//! let frame = Frame {
//!     left_mm: 100.0,
//!     back_mm: 110.0,
//!     cell_mm: 0.45,
//!     layer_mm: 0.2,
//!     width: 0,
//!     height: 0,
//! };
//! let process = Process { outer_wall_mm_s: Some(15.0), wipe_mm: 1.0, ..Process::default() };
//! let settings = Settings { tools: vec![Tool::default()], process, ..Settings::default() };
//! let title = Title { part: "square", version: "0.1.0" };
//! let control = Control::default();
//! let print = Print::of_beads(title, &layers, &frame, &settings, &control)?;
//!
//! let outline = vec![[100.0, 100.0], [110.0, 100.0], [110.0, 110.0], [100.0, 110.0]];
//! let outlines = [vec![(0, Area::from_rings(&[outline], FillRule::NonZero))]];
//! let program: Program = print.program.emit().parse()?;
//! let limits = BeadLimits::default();
//! let report =
//!     print::check_beads(&program, &layers, &outlines, &frame, &settings, &limits, &control)?;
//! assert_eq!((report.beads, report.motions), (2, 5));
//! assert!(report.fill[0].ratio().is_some_and(|ratio| ratio > 0.2));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! Travel is straight, also across what is printed.
//! A tool change is a single `T` command; what the printer does for it depends on its firmware's
//! configuration.

mod check;
mod header;
mod layer;
mod machine;
mod prime_tower;
mod process;
mod program;
mod settings;
mod settings_error;
mod text;
mod toolpath;
mod validate;
mod wipe;
mod writer;

pub use check::{
    BeadLimits, BeadReport, CellPosition, CheckError, LayerFill, Report, ToolFill, check,
    check_beads,
};
pub use header::Title;
pub use layer::Layer;
pub use process::{CrossSection, Process};
pub use program::{Print, PrintError};
pub use settings::{Flavour, Nozzles, PrimeTower, Printer, Purge, Settings, Tool};
pub use settings_error::SettingsError;
