//! Joins closed loops and open chains of an island into as few beads as the geometry allows.
//!
//! The insets of an island are nested loops, a bead's width apart; its infill consists of open
//! chains that end near the innermost inset.
//! A short extruded step from one to the next saves a lift: the nozzle prints a loop once around,
//! steps inwards, prints the next loop, and so on, and continues with the infill.
//!
//! # Model
//! A bead is a sequence of loops and chains.
//! A loop ends where it begins, at any point of it; a chain has two fixed ends.
//! Between two consecutive ones the nozzle takes a straight step of at most
//! [`Settings::max_step_mm`] that properly crosses neither the outline nor a loop.
//! So a loop between two chains needs one point near an end of each.
//!
//! # Method
//! 1. Loops that are within reach of each other all along are joined to sequences, nearest first;
//!    nested insets are of this kind.
//!    Where such a sequence begins is still open.
//! 2. Ends of chains are matched with these sequences: a maximum bipartite matching by augmenting
//!    paths, because one sequence may be within reach of several chains.
//! 3. What can still be joined is joined greedily, nearest first: the other ends of the sequences,
//!    and loops that come within reach of each other only in some part.
//!
//! The [`Outcome::bound`] is the number of connected components of the graph of all elements with
//! points within reach of each other: no step leads from one component to another.
//! It does not consider what lies between these points, such as an outline.
//!
//! # Example
//! ```
//! use beadwork_search::join::{self, Input, Settings};
//!
//! let square = |side: f64| [[-side, -side], [side, -side], [side, side], [-side, side]];
//! let (outline, outer, inner) = (square(5.0), square(4.75), square(4.25));
//! // Infill: one chain that begins near the inner loop.
//! let chain = [[-3.7, -3.7], [3.7, 3.7]];
//! let input = Input { loops: &[&outer, &inner], chains: &[chain], outline: &[&outline] };
//! let joined = join::solve(&input, &Settings::default());
//! assert_eq!((joined.beads.len(), joined.bound), (1, 1));
//! ```

mod bead;
mod geometry;
mod matching;
mod merge;
mod solve;
mod surroundings;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod twin;

pub use bead::{Bead, OnLoop, Part};
pub use solve::{Attachment, Input, Loops, Outcome, Settings, solve};
