//! Checks a program from its text alone.
//!
//! Apart from the validation of its input, the check shares no code with the writer.
//! It follows the motions of the program, as a printer would, and compares them with the layers
//! that were to be printed:
//!
//! - `checker`: what does not depend on the part: retraction, height of every motion;
//! - `cells`: which cells each motion prints, and in which order;
//! - `beads`: which move of a bead each motion prints, and whether it stays within the outlines;
//!   `planned` lists the expected motions, `edge_index` finds the edges of outlines near a motion,
//!   and `fill` adds up areas;
//! - `rates`: speed and volume;
//! - `wipe`: motions that retract;
//! - `purge`: the prime tower, and the volumes that tool changes purge into it;
//! - `heat`: temperatures of bed and nozzles;
//! - `modes`: whether all printers interpret the extrusion modes alike.

#[cfg(test)]
mod bead_cases;
#[cfg(test)]
mod bead_faults;
#[cfg(test)]
mod bead_tests;
mod beads;
mod cells;
mod checker;
mod edge_index;
mod error;
mod fill;
mod heat;
mod modes;
mod planned;
mod purge;
mod rates;
#[cfg(test)]
mod tests;
mod tolerance;
mod wipe;

pub use beads::{BeadLimits, BeadReport, check_beads};
pub use cells::{Report, check};
pub use error::{CellPosition, CheckError};
pub use fill::{LayerFill, ToolFill};
