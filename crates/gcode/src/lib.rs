//! G-code: programs of any origin read, followed, timed and written.
//!
//! - [`Program`]: the lines of a file.
//!   [`Program::parse`] reads real files, [`Program::emit`] writes them.
//!   Numbers are exact ([`Number`]), so that parsing emitted text returns the same program.
//! - [`Program::trace`]: the [`Event`]s of a program in order, whichever slicer wrote it: motions,
//!   tool changes, heating, pauses.
//! - [`Program::print_seconds`]: the printing time, with acceleration and cornering;
//!   [`Program::paced`]: the time of each motion.
//! - [`Totals`]: travel, extrusion, filament and time of a whole program.
//!
//! # Units and axes
//! As in files: x right, y to the back, z up, all in mm; filament as a length in mm.
//! Speeds are in mm/s, except in commands, which hold mm/min.
//!
//! # Example
//! ```
//! use beadwork_gcode::{Event, Limits, Program};
//!
//! let program = Program::parse("G90\nM83\nG1 X10 Y0 F1200\nG1 X30 E1 ; a bead of 20 mm\n")?;
//! let lengths: Vec<f64> = program
//!     .trace()
//!     .filter_map(|event| match event {
//!         Ok(Event::Motion(motion)) if motion.is_stroke() => Some(motion.length_mm()),
//!         _ => None,
//!     })
//!     .collect();
//! assert_eq!(lengths, [20.0]);
//! assert_eq!(Program::parse(&program.emit())?, program);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! Programs of FDM printers in mm; inches and planes other than xy are refused.
//! The effect of a macro is unknown: nothing here follows one.
#![cfg_attr(
    test,
    allow(clippy::float_cmp, reason = "numbers that are exact in binary are compared as such")
)]

mod arc;
mod command;
mod feature;
mod number;
mod pace;
mod parse;
mod program;
mod time;
mod totals;
mod trace;

pub use command::{Arc, Command, Move, Verbatim, VerbatimError, Wait};
pub use feature::Feature;
pub use number::{Number, NumberError};
pub use pace::{Pace, Paced};
pub use parse::{ParseError, ParseFault};
pub use program::{CommentError, Line, Program};
pub use time::{Limits, Stopwatch};
pub use totals::{Filament, ToolUse, Totals};
pub use trace::{Event, Heater, Motion, Trace, TraceError};
