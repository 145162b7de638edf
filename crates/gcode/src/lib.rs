//! Reads, traces, times and writes the G-code of FDM printers.
//!
//! - [`Program::parse`] reads the text of a file, whichever slicer wrote it; [`Program::emit`]
//!   writes it.
//!   Numbers are exact decimals ([`Number`]), so parsing emitted text returns the same program.
//! - [`Program::trace`] interprets a program and yields its [`Event`]s in order: motions, tool
//!   changes, heating, pauses.
//! - [`Program::print_seconds`] computes the printing time with acceleration and cornering;
//!   [`Program::timed_events`] the time of each motion, and [`SpeedProfile`] the time of each point
//!   on it.
//! - [`Program::unknown_commands`] lists commands whose effect is not known.
//! - [`Totals::measure`] sums up travel, extrusion, filament and time.
//!
//! # Terms
//! - A **program** is the list of **lines** of a file; a line holds a **command**, a comment, both
//!   or neither.
//! - A **verbatim command** is one that has no type here, such as a macro; its text is kept.
//! - A **motion** is a straight move of the nozzle, or filament that is extruded or retracted while
//!   the nozzle stands still.
//!   An arc is traced as several motions.
//! - An **extrusion move** is a motion that moves the nozzle and extrudes.
//! - A **feature** is what an extrusion move prints, such as an outer wall, according to the
//!   slicer's comments.
//!
//! # Units and axes
//! x points right, y to the back, z up, all in mm; filament is measured by its length in mm.
//! Speeds are in mm/s, except in commands, which hold mm/min as files do.
//! Lines are numbered from 1, layers and tools from 0.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_gcode::{Event, Filament, MotionLimits, Program, Totals};
//!
//! let control = Control::default();
//! let text = "G90\nM83\nG1 X10 Y0 F1200\nG1 X30 E1 ; a bead of 20 mm\n";
//! let program = Program::parse(text, &control)?;
//! assert_eq!(Program::parse(&program.emit(), &control)?, program);
//!
//! // Lengths of its beads.
//! let lengths: Vec<f64> = program
//!     .trace()
//!     .filter_map(|event| match event {
//!         Ok(Event::Motion(motion)) if motion.is_extrusion() => Some(motion.length_mm()),
//!         _ => None,
//!     })
//!     .collect();
//! assert_eq!(lengths, [20.0]);
//!
//! // Printing time: both moves are in line, so the nozzle does not slow down between them.
//! let limits =
//!     MotionLimits { acceleration_mm_s2: 1000.0, square_corner_mm_s: 5.0, max_speed_mm_s: 300.0 };
//! let seconds = program.print_seconds(limits, &control)?;
//! assert!((seconds - 1.52).abs() < 1e-9);
//!
//! // Sums over the whole program.
//! let pla = Filament { diameter_mm: 1.75, density_g_cm3: 1.24 };
//! let totals = Totals::measure(&program, limits, &[pla], &control)?;
//! assert_eq!((totals.travel_mm, totals.extrusion_mm), (10.0, 20.0));
//! assert_eq!(totals.tools[0].filament_mm, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is read and what is refused
//! Bytes are read as UTF-8 or UTF-16, with any line ends; binary G-code, archives, meshes and
//! pictures are refused by name ([`EncodingError`]).
//!
//! The parser accepts any case, missing or extra blanks, line numbers with checksums, comments
//! after `;` and in parentheses, and bytes that are not UTF-8.
//! It refuses only malformed numbers and words in commands that it types; everything else is kept
//! verbatim.
//!
//! The trace follows the dialects of Marlin, Klipper and RepRapFirmware:
//!
//! - several commands on a line (`G90 G21 M83`), from left to right,
//! - words without a command (`X10 E1`), which repeat the last motion command,
//! - tool changes with parameters (`T1 S1 L0 D0`), `M6 T1` and `ACTIVATE_EXTRUDER`,
//! - temperatures set by `M104`, `M109`, `G10 P S`, `M568` and `SET_HEATER_TEMPERATURE`,
//! - `M220 S`, `G53`, `G92.1`, `SAVE_GCODE_STATE` and `RESTORE_GCODE_STATE`.
//!
//! It refuses what changes motions in a way that it cannot follow, with the number of the line:
//! inches (`G20`), arcs outside the xy plane (`G18`, `G19`), impossible arcs and those of several
//! turns, curves (`G5`), probing (`G38`), other coordinate systems (`G55` to `G59`, `G10 L2`),
//! speeds and accelerations that are not positive, and lines that firmware reads differently, such
//! as `G1 X5 G91`.
//!
//! Commands that could matter but have no effect here, such as macros and pauses for the user, are
//! listed by [`Program::unknown_commands`].
//!
//! # Limits
//! - Macros, tool offsets and firmware retraction (`G10`, `G11`) are kept but have no effect in the
//!   trace: only the printer knows what they do.
//! - Times do not include heating, macros or tool changes; [`MotionLimits`] lists what else is left
//!   out.
//! - A number has at most six decimals and 13 digits before the point.
//! - A program takes about a hundred bytes per line and twice its text in memory.
#![cfg_attr(
    test,
    allow(clippy::float_cmp, reason = "numbers that are exact in binary are compared exactly")
)]

mod arc;
mod code;
mod command;
mod emit;
mod encoding;
mod event;
mod feature;
mod meaning;
mod number;
mod parse;
mod program;
mod speed_profile;
mod time;
mod timed_events;
mod totals;
mod trace;
mod unknown;
mod words;

pub use code::CodeName;
pub use command::{Arc, Command, LinearMove, Verbatim, VerbatimError, Wait};
pub use encoding::EncodingError;
pub use event::{Event, Heater, Motion, TraceError};
pub use feature::Feature;
pub use number::{Number, NumberError};
pub use parse::ParseError;
pub use program::{CommentError, Line, Program};
pub use speed_profile::SpeedProfile;
pub use time::{MotionLimits, Stopwatch};
pub use timed_events::TimedEvents;
pub use totals::{Filament, ToolUse, Totals};
pub use trace::Trace;
pub use unknown::UnknownCommand;
pub use words::ParseFault;
