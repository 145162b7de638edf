//! Orders and reverses beads and closed loops for little travel of the nozzle.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_search::travel::{Item, Settings, solve};
//!
//! let square = [[10.0, 0.0], [20.0, 0.0], [20.0, 10.0], [10.0, 10.0]];
//! let items = [Item::bead([5.0, 0.0], [0.0, 0.0]), Item::closed(&square)];
//! let settings = Settings { from: Some([0.0, 0.0]), ..Settings::default() };
//! let route = solve(&items, &settings, &Control::default())?;
//! assert_eq!(route.travel_mm, 5.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod entries;
mod exchange;
mod item;
mod kd_tree;
mod kicks;
mod local_search;
mod nearest;
mod neighbours;
mod problem;
mod route;
mod settings;
mod solve;
#[cfg(test)]
mod tests;
mod tour;

pub use item::{Item, MAX_COORDINATE_MM, MAX_ITEMS, Shape, TravelError, Way};
pub use route::{Route, Visit, is_allowed, travel_mm};
pub use settings::{Order, Settings};
pub use solve::{nearest_neighbour, solve};

/// Maximum number of items for which a bound is computed.
pub const MAX_BOUNDED: usize = 1500;
