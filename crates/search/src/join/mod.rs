//! Joins closed loops and open chains of an island into as few beads as the geometry allows.
//!
//! The insets of an island are nested loops, a bead's width apart; its infill consists of open
//! chains that pass and end near the innermost inset.
//! A short extruded step from one to the next saves a lift.
//!
//! # Model
//! A bead is a sequence of pieces of loops and chains ([`Bead`]).
//! Between two consecutive ones the nozzle takes a straight step of at most
//! [`Settings::max_step_mm`] that properly crosses neither the outline nor a loop, a chain or
//! another step.
//! There are two kinds of joins:
//!
//! - **End to end**: one step leads from an end of a chain or a loop to that of the next one.
//!   A loop is printed once around, from any of its points; so a loop between two chains needs one
//!   point near an end of each.
//! - **Splice**: a loop is inserted where another line passes.
//!   A slit of a bead's width is cut out of both, and two steps side by side connect the sides of
//!   the slits, so that the nozzle leaves the line, prints the loop, and returns.
//!   The steps fill what the slits leave open.
//!
//! ```text
//!    inset     ────────┐   ┌────────
//!                      │   │          two steps, a bead's width apart
//!    infill    ────────┘   └────────
//! ```
//!
//! A splice takes no end of a chain, so it removes any loop that something passes: what remains are
//! the open chains that are not joined end to end.
//! The idea is that of merging cycles of a Hamiltonian cycle problem, and of connected Fermat
//! spirals (Zhao et al., *Connected Fermat spirals for layered fabrication*, 2016), applied to
//! insets and infill together.
//!
//! # Method
//! 1. Loops that are within reach of each other all along are joined to sequences, nearest first;
//!    nested insets are of this kind.
//!    Where such a sequence begins is still open.
//! 2. Ends of chains are matched with these sequences: a maximum bipartite matching by augmenting
//!    paths, because one sequence may be within reach of several chains.
//! 3. What can still be joined end to end is joined greedily, nearest first: the other ends of the
//!    sequences, and loops that come within reach of each other only in some part.
//!    If that leaves more beads than the bound, chains are also joined to each other first, with a
//!    single loop in between, and the better result counts.
//! 4. Sequences that consist of loops alone, and that something else passes, are taken apart.
//!    Their loops are spliced in the order of the quality of the splices, as in Kruskal's method
//!    for spanning trees: short and even steps, straight lines on both sides, near the seams.
//!    Two curves are joined if at least one of them is closed.
//!    A sequence that does not become part of one other bead stays as it was, so there are never
//!    more beads than after the third step.
//!
//! # Bound
//! [`Outcome::bound`] holds for all beads that consist of joins of the two kinds, for these loops
//! and chains.
//! No step leads from one connected component of lines within reach of each other to another one,
//! and a loop that is joined end to end takes at most two ends of chains.
//! So if a maximum matching of ends of chains with sides of loops leaves `n` ends of a component
//! without a side, it has at least `n / 2` beads, and at least one.
//! Ends of chains that another chain is within reach of are not counted.
//! The bound does not consider what lies between lines, such as an outline.
//!
//! # Example
//! ```
//! use beadwork_search::join::{self, Input, Settings};
//!
//! let square = |side: f64| [[-side, -side], [side, -side], [side, side], [-side, side]];
//! let (outline, outer, inner) = (square(5.0), square(4.75), square(4.25));
//! let (hole, around) = (square(0.5), square(0.75));
//! // Infill: one chain that begins near the inner loop, and passes the one around the hole.
//! let chain = [[-3.7, -3.7], [-3.7, 1.3], [3.7, 1.3]];
//! let input = Input {
//!     loops: &[&outer, &inner, &around],
//!     chains: &[&chain],
//!     outline: &[&outline, &hole],
//!     seams: &[],
//! };
//! let joined = join::solve(&input, &Settings::default());
//! assert_eq!((joined.beads.len(), joined.bound), (1, 1));
//! // Three lines, and one more piece of the chain after the splice.
//! assert!(joined.beads[0].ways[0].len() >= 4);
//! ```

mod bead;
mod bound;
mod candidates;
mod curves;
mod ends;
mod geometry;
mod matching;
mod merge;
mod path;
mod sequence;
mod slits;
mod solve;
mod splice;
mod steps;
mod surroundings;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod twin;

pub use bead::{Bead, Line, Piece, Position};
pub use candidates::Attachment;
pub use solve::{Input, Loops, Outcome, Settings, solve};
