//! Plans of parts in beads: insets, skeletons and infill in printing order.
//!
//! [`solve`] takes the islands of every layer ([`beadwork_part::toolpath::islands`]) and decides
//!
//! - which infill lines are linked to one bead ([`crate::link`]),
//! - whether the insets and the infill of an island are joined to one bead ([`crate::join`]),
//! - in which order the tools of each layer are used ([`crate::plan::order`]),
//! - in which order and direction the beads of a tool are printed ([`crate::travel`]),
//! - where closed loops begin ([`Seam`]).
//!
//! The result are [`BeadLayer`](beadwork_part::BeadLayer)s, which [`beadwork_part::print`] writes
//! as G-code, and proven lower bounds on the number of beads, on tool changes and on travel.

mod infill;
mod island;
mod layer;
mod outcome;
mod rectangle;
mod seam;
mod settings;
mod solve;
mod strand;
#[cfg(test)]
mod tests;

pub use outcome::{BeadPlan, Counts};
pub use settings::{Seam, Settings};
pub use solve::{BeadError, solve};
