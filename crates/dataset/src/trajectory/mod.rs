//! The record of one search, from its start path to the best path it found.

mod arrays;
mod record;
mod replay;

pub use self::arrays::TrajectoryArrays;
pub use self::record::{DrawError, Instance, Moves, Step, Trajectory};
pub use self::replay::ReplayError;

#[cfg(test)]
mod tests;
