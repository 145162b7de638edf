//! G-code: planned layers to the program of a printer, and programs of any origin back to motions.
//!
//! - [`Program`]: the lines of a file.
//!   [`Program::parse`] reads real files, [`Program::emit`] writes them; numbers are exact
//!   ([`Number`]), so that reading what was written gives the same program.
//! - [`Program::trace`]: what the head does, one [`Event`] after the other, whichever slicer wrote
//!   the program: motions, changes of tool, heat, pauses.
//! - [`Program::print_seconds`]: how long that takes, with acceleration and corners;
//!   [`Program::paced`]: how long each motion does.
//! - [`Print::new`]: the program of planned [`Layer`]s, and its [`Totals`].
//! - [`Program::check`]: whether a program, from its text alone, prints the layers it is to print.
//!
//! # Words
//! A **stroke** is a motion that extrudes.
//! A tool's filament is **drawn back** before it travels and **pushed out** again before the next
//! bead.
//! To **purge** is to extrude what is left of the old material, into a **tower** beside the part.
//!
//! # Units and axes
//! As in files: x right, y to the back, z up, all in mm; filament as a length in mm.
//! [`Frame`](crate::Frame) says where cells lie.
//! Speeds are in mm/s everywhere but in commands, which have mm/min.
//!
//! # Example
//! ```
//! use beadwork_grid::{Layout, LayoutSpec, Region, cover};
//! use beadwork_part::Frame;
//! use beadwork_part::gcode::{Layer, Print, Program, Purge, Settings, Title, Tool, Tower};
//!
//! let region = Region::rectangle(20, 10)?;
//! let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0)?;
//! let path = cover(&region);
//! let layer = |number| Layer { number, region: &region, zones: &zones, path: &path };
//! let layers = [layer(0), layer(1)];
//!
//! let frame = Frame { left_mm: 100.0, back_mm: 100.0, cell_mm: 0.45, layer_mm: 0.2, width: 20, height: 10 };
//! let tower = Tower { left_mm: 120.0, front_mm: 50.0, width_mm: 30.0, depth_mm: 60.0 };
//! let purge = Some(Purge::uniform(2, 10.0, Some(tower)));
//! let settings = Settings { tools: vec![Tool::default(); 2], purge, ..Settings::default() };
//!
//! let print = Print::new(Title { part: "plate", version: "0.1.0" }, &layers, &frame, &settings)?;
//! assert_eq!(print.totals.tool_changes, 20);
//!
//! let read = Program::parse(&print.program.emit())?;
//! assert_eq!(read, print.program);
//! assert_eq!(read.check(&layers, &frame, &settings)?.cells, 400);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! Programs of plastic printers in mm; no inches, no planes but that of x and y, no macros: what a
//! macro does is not seen by anything here.
//! Travel goes straight, over printed parts too.
//! A change of tools is one `T` command; how the printer performs it is its own business.

mod arc;
mod check;
mod command;
mod feature;
mod header;
mod layer;
mod number;
mod pace;
mod parse;
mod print;
mod program;
mod settings;
mod time;
mod totals;
mod tower;
mod trace;

pub use check::{CheckError, Place, Report};
pub use command::{Arc, Command, Move, Verbatim, VerbatimError, Wait};
pub use feature::Feature;
pub use layer::Layer;
pub use number::{Number, NumberError};
pub use pace::{Pace, Paced};
pub use parse::{ParseError, ParseFault};
pub use print::{Print, Title};
pub use program::{CommentError, Line, Program};
pub use settings::{
    CrossSection, Flavour, Nozzles, Printer, Process, Purge, Settings, SettingsError, Tool, Tower,
};
pub use time::{Limits, Stopwatch};
pub use totals::{ToolUse, Totals};
pub use trace::{Event, Heater, Motion, Trace, TraceError};
