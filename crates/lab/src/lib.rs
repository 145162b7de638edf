//! For researchers: evaluations beside the figures of the papers, and benchmarks.
//!
//! - [`eval`]: tables of searches, parts and simulations, beside the papers' figures; interrupted
//!   evaluations resume.
//! - [`bench`]: rates, ratios and growth on the machine at hand.
//!
//! Both are commands of the binary `beadwork`.

#![allow(clippy::print_stderr, reason = "a command line talks to its terminal")]
#![allow(
    clippy::doc_markdown,
    reason = "the comments on flags are their help, where backticks are noise"
)]

mod args;
pub mod bench;
pub mod eval;
mod heat_parts;
mod paper;
mod statistics;
