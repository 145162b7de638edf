//! Checks a program from its text alone.
//!
//! Apart from the validation of its input, the check shares no code with the writer.
//! It follows the motions of the program, as a printer would, and compares them with the layers
//! that were to be printed:
//!
//! - `checker`: retraction, volume, speed and height of every motion;
//! - `cells`: which cells each motion prints, and in which order;
//! - `purge`: the prime tower, and the volumes that tool changes purge into it;
//! - `heat`: temperatures of bed and nozzles;
//! - `modes`: whether all printers interpret the extrusion modes alike.

mod cells;
mod checker;
mod error;
mod heat;
mod modes;
mod purge;
#[cfg(test)]
mod tests;
mod tolerance;

pub use checker::{Report, check};
pub use error::{CellPosition, CheckError};
