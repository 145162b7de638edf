//! G-code programs as deposition events, or as the part that they print.

mod bead;
mod events;
mod poll;
mod visit;
mod voxels;

#[cfg(test)]
mod tests;

pub use self::events::{ProgramError, ProgramEvents, Settings, program_events};
pub use self::voxels::{VoxelsError, program_voxels};
