//! Code shared by the commands of `beadwork-cli` and `beadwork-lab`.
//!
//! - The terminal: [`output`], [`progress`], [`cancel`] (Ctrl-C as a cancel token), [`control`]
//!   (threads and progress of long calls), [`text`].
//! - [`machine`]: facts about the machine, recorded with measured figures; [`memory`]: an allocator
//!   setting that keeps freed memory between training steps.
//! - [`chart`]: line charts and heat maps as SVG; [`temperature_map`]: temperatures on planes
//!   through a part, as SVG and PNG.
//! - [`part`] and [`printer`]: flags that name a part and a printer, and what they load;
//!   [`plan`]: planned layers as checked G-code; [`beads`] and [`bead_args`]: the same for beads;
//!   [`grid_choice`]: the cell grid that needs the
//!   fewest beads.
//! - [`search`]: runs any search method on one layer and reports the result as a row of a table.
//!
//! This crate writes to the terminal and reads and writes files; the compute crates do neither.

#![allow(clippy::print_stderr, reason = "a command line writes to its terminal")]
#![allow(
    clippy::doc_markdown,
    reason = "the comments on flags are their help, where backticks are noise"
)]

pub mod accuracy;
pub mod bead_args;
pub mod beads;
pub mod cancel;
pub mod chart;
pub mod control;
pub mod grid_choice;
#[cfg_attr(not(feature = "learn"), path = "unlearned.rs")]
pub mod learned;
pub mod machine;
pub mod memory;
pub mod output;
pub mod part;
pub mod plan;
pub mod printer;
pub mod progress;
pub mod remarks;
mod row;
pub mod search;
pub mod temperature_map;
pub mod text;
