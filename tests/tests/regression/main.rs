//! Traits of files from public bug reports, from the file to what the command line says.
//!
//! The report that a test is modelled on is named above it.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod gcode;
mod meshes;
mod projects;
