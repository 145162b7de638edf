//! Batches of examples, streamed from a dataset.
//!
//! An example is a state of a recorded search, the moves before it, and the needed move that
//! followed, all transformed by one of the eight symmetries of the grid.
//! [`Batches`] reads trajectories in random order, draws some examples of each into a shuffle
//! buffer for each canvas, and draws batches from these buffers.
//! The batches depend on the dataset, the settings and the epoch alone.
//!
//! A [`Batch`] holds `ndarray` arrays, so that other frameworks can train on it too; its examples
//! are in the same order in all arrays.

mod batch;
mod split;
mod stream;

pub use self::batch::{Batch, Negatives, Targets};
pub use self::split::Split;
pub use self::stream::{Batches, SampleError, Settings};
