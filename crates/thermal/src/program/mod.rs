//! G-code programs, and beads that are not part of one yet, as deposition events, or as the part
//! that they print.

mod bead;
mod events;
mod heights;
mod path;
mod poll;
mod rows;
mod temperatures;
mod visit;
mod voxels;

#[cfg(test)]
mod tests;

pub use self::events::{ProgramError, ProgramEvents, Settings, program_events};
pub use self::path::{PathVisit, path_visits};
pub use self::rows::{LayerFit, ProgramFit, bead_lengths, layer_heights, program_fit};
pub use self::temperatures::{ProgramTemperatures, TemperatureShare, program_temperatures};
pub use self::voxels::{VoxelsError, program_voxels};
