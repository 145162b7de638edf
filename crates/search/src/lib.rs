//! Searches for paths of low cost, and plans of whole parts.
//!
//! A search takes a start path or a region, an objective and settings.
//! It returns the best result it found, its cost, and why it stopped, with a proven lower bound
//! where there is one.
//!
//! - [`exact`]: a path with the fewest pieces, and of those with the cheapest crossings, with a
//!   proof where the bound is met.
//! - [`anneal`]: simulated annealing, by the method of Aali et al. or a faster one.
//! - [`genetic`]: the genetic algorithm of Aali et al. on the moves of many annealing runs.
//! - [`chains`]: local search that lowers the cost in few moves, as examples for learning.
//! - [`bound`](mod@bound): lower bounds on the number of pieces and on crossings.
//! - [`join`]: joins nested insets and infill into few beads.
//! - [`link`]: infill lines linked to the fewest beads, by nearest neighbour, by break points, or
//!   with a proven bound; made for import by other slicers.
//! - [`plan`]: plans of whole parts: the order of the tools over the layers, and the beads of all
//!   layers for the minimum cost of tool changes and lifts.
//! - [`travel`]: orders and reverses beads and closed loops for little travel, with a bound.
//!
//! # Terms
//! - A **path** visits every cell of a region once; it consists of one or more **pieces**, and a
//!   **lift** separates two of them.
//! - A **crossing** is a step of a piece from one zone to another.
//! - A **switch** exchanges two parallel links of a unit cell (2 x 2 cells) for the other two; a
//!   [`Move`] is a pair of switches that together keep the number of pieces.
//! - A [`Cost`] is what a search minimises: usually the number of crossings.
//! - A [`CostMatrix`] holds the costs of changes between zones or tools.
//! - A **bound** is a proven lower bound.
//!   A result that reaches it is **optimal** ([`Stop::Optimal`]); one that reaches a target that
//!   the caller chose need not be ([`Stop::TargetReached`]).
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::anneal;
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let cost = Crossings::new(&region, &zones);
//! let settings = anneal::Settings::preset(anneal::Preset::Paper, 7);
//! let outcome = anneal::solve(&start, &cost, &settings, &Control::default());
//! assert!(outcome.cost < outcome.initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guarantees
//! - Nothing here does I/O or reads a clock, and only the threads of
//!   [`Control::threads`](beadwork_base::Control::threads) are used.
//! - The same seed gives the same result on every machine and with any number of threads, unless
//!   the call is interrupted.
//! - An interrupted search returns the best result so far, with [`Stop::Cancelled`] or
//!   [`Stop::TimeUp`].
//!
//! # Features
//! - `integer-program`: compiles tests that compare [`exact`] and [`link`] with integer programs;
//!   it needs cmake, a C++ compiler and libclang, and is not built in CI.

pub mod anneal;
pub mod bound;
pub mod chains;
mod cost;
mod costs;
mod disjoint_sets;
pub mod exact;
pub mod genetic;
pub mod join;
pub mod link;
mod lists;
mod matching;
mod moves;
pub mod plan;
mod random;
mod segment;
mod stop;
pub mod travel;

pub use cost::Cost;
pub use costs::{CostMatrix, CostMatrixError};
pub use moves::Move;
pub use stop::Stop;
