//! Orders of whole lines, and what they have in common with patterns.

mod bead_rows;
mod layer_order;
mod line_order;
mod lines;
mod sequence;
#[cfg(test)]
mod tests;

pub use bead_rows::{BeadRows, TurnedBead, turn_beads};
pub use layer_order::{Order, UnknownOrder};
pub use line_order::{Axis, Corner, LineOrder, LineOrderError};
pub use lines::{Ends, Lines, PermutationError};
pub use sequence::{InvalidStride, Sequence, SequenceError, Stride};
