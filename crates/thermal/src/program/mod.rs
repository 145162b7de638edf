//! G-code programs as deposition events, or as the part that they print.

mod bead;
mod events;
mod heights;
mod poll;
mod rows;
mod temperatures;
mod visit;
mod voxels;

#[cfg(test)]
mod tests;

pub use self::events::{ProgramError, ProgramEvents, Settings, program_events};
pub use self::rows::{LayerFit, ProgramFit, bead_lengths, layer_heights, program_fit};
pub use self::temperatures::{ProgramTemperatures, TemperatureShare, program_temperatures};
pub use self::voxels::{VoxelsError, program_voxels};
