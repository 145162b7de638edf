//! Exact search for a path with the fewest pieces and, among those, the cheapest crossings, with a
//! proof of optimality.
//!
//! # Terms
//! A **link** joins two neighbouring cells that follow each other on a path.
//! A **cover** is a set of paths that together hold every cell once; its paths are its **pieces**.
//! A **2-matching** is a set of links with at most two at each cell.
//! It consists of paths and cycles, together called **strands**.
//!
//! # Method
//! A cover of n cells with p pieces has n - p links, at most two at each cell: it is a 2-matching.
//! So no cover costs less than the cheapest 2-matching with n - p links.
//! As the grid is bipartite, like a chessboard, the cheapest 2-matching is a minimum-cost flow, and
//! is found in nearly linear time.
//! It differs from a cover only in its cycles.
//! If it can be changed into a cover without raising the cost, that cover is proven optimal.
//!
//! An *attempt* has three steps:
//!
//! 1. Lay *ladders* inside the zones, which give nearly every cell two links, and complete them to
//!    the cheapest 2-matching by shortest alternating paths (module `matching`).
//! 2. Insert links, the cheapest first, between groups of zones that no link connects.
//! 3. Join cycles by switches of unit cells, and the remaining ones by exchanges along short
//!    alternating cycles.
//!
//! Attempts are repeated with other ladders and other random choices until the cost meets the lower
//! bound.
//! If the first attempt does not meet it, the bound may be too low, because a cover also has to be
//! connected: stronger bounds are computed one after the other ([`bound`](crate::bound)).
//!
//! `docs/exact.md` explains the method with pictures.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Layout, LayoutSpec, Region};
//! use beadwork_search::exact::{Settings, solve};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 3)?;
//! let outcome = solve(&region, &zones, &Settings::default(), &Control::default())?;
//! assert_eq!((outcome.pieces, outcome.piece_bound), (1, 1));
//! assert!(outcome.is_optimal(), "{} crossings, bound {}", outcome.crossings, outcome.bound);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(test)]
mod brute_force;
mod complete;
mod component;
mod connect;
mod cover;
mod exchange;
mod merge;
mod outcome;
mod settings;
mod solve;
mod strands;
mod terminal;
#[cfg(test)]
mod tests;

pub use outcome::{Outcome, SolveError};
pub use settings::{AttemptReport, Observers, Settings, Stage, StageObserver};
pub use solve::solve;
pub use terminal::{Side, Terminal};
