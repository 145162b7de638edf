//! Searches for a path of lower cost.
//!
//! A search takes a [`Path`](beadwork_grid::Path), a [`Cost`] and its settings, and gives back the
//! best path it found, its cost, a proven lower bound where the caller had one, and why it stopped.
//! It does no I/O, reads no clock and works on no threads but those of a pool that it is handed;
//! with the same seed it gives the same answer on every machine.
//!
//! - [`exact`]: the fewest pieces, then the fewest crossings, and a proof where the bound is met.
//! - [`anneal`](anneal()): simulated annealing, by the method of Aali et al. ([`Pooled`]) or a
//!   faster one ([`Free`]).
//! - [`genetic`]: the genetic algorithm of Aali et al. on the moves of many annealing runs, faster
//!   and with other crossovers.
//! - [`chains`]: few moves of the paper's for a lower cost, for those that learn from them.
//! - [`bound`]: what no path can beat.
//! - [`plan`]: what the layers of a part decide together; so far, the order of their tools.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::{Preset, Settings, anneal};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let outcome = anneal(start, &Crossings::new(&region, &zones), &Settings::preset(Preset::Paper, 7));
//! assert!(outcome.cost < outcome.initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod anneal;
pub mod bound;
pub mod chains;
mod cost;
mod costs;
mod disjoint_sets;
pub mod exact;
pub mod genetic;
mod matching;
mod moves;
mod parallel;
pub mod plan;
mod random;
mod stop;

pub use anneal::{
    Free, Method, Outcome, Pooled, Preset, Progress, Settings, UnknownPreset, anneal,
};
pub use cost::Cost;
pub use costs::{ZoneCosts, ZoneCostsError};
pub use moves::Move;
pub use stop::Stop;
