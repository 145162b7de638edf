//! Orders and reverses beads and closed loops for little travel of the nozzle, with a proven lower
//! bound.
//!
//! It takes plain points in mm and needs no other type of this workspace, so that any slicer can
//! import it.
//!
//! # Terms
//! - An **item** is an open bead, which may be reversed unless stated otherwise, or a closed loop
//!   with the points at which it can begin, its **entries**.
//! - A **route** visits each item once; it may begin at a given position, and ends anywhere.
//! - Its **travel** is the sum of the straight distances between successive items.
//! - A **group** is a set of items that can be kept together, such as an island, and a **stage**
//!   orders the items within a group, such as loops before infill: see [`Order`].
//!
//! # Method
//! 1. Go to the nearest item that may follow, found by a k-d tree.
//! 2. Exchange two or three links at a time, between ends that are near each other, while this
//!    shortens the route; it includes reversals and shifts of sequences of any length.
//!    Whole groups are exchanged in the same way.
//! 3. Choose the entries of all loops together by dynamic programming along the route.
//! 4. Kick: change the order of three short sequences, repair it by local search, and undo both if
//!    the route becomes longer.
//!
//! Few items are ordered exactly, by dynamic programming over their subsets.
//! The bound is that of Held and Karp; [`Route::bound_mm`] holds for the order that was chosen, and
//! a bound for [`Order::Free`] holds for all orders.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_search::travel::{Item, Order, Settings, Way, is_allowed, solve};
//!
//! // Two islands, each a loop and a bead of infill.
//! let squares = [0.0, 30.0].map(|x| [[x, 0.0], [x + 20.0, 0.0], [x + 20.0, 20.0], [x, 20.0]]);
//! let mut items = Vec::new();
//! for (island, square) in squares.iter().enumerate() {
//!     let [x, y] = square[0];
//!     items.push(Item::closed(square).within(island as u32, 0));
//!     items.push(Item::bead([x + 1.0, y + 1.0], [x + 19.0, y + 1.0]).within(island as u32, 1));
//! }
//! let settings = Settings {
//!     order: Order::Stages,
//!     from: Some([0.0, 0.0]),
//!     bound_iterations: 50,
//!     ..Settings::default()
//! };
//! let route = solve(&items, &settings, &Control::default())?;
//! assert!(is_allowed(&items, &route.visits, settings.order));
//! assert_eq!(route.visits[0].item, 0);
//! assert_eq!(route.visits[0].way, Way::Entry(0));
//! assert_eq!(route.visits[1].way, Way::Forward);
//! assert!(route.bound_mm.is_some_and(|bound| bound <= route.travel_mm));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! - Travel is straight: walls on the way do not count.
//! - Loops count in the bound with the shortest distance of any two entries, so the bound is weak
//!   where loops are large compared with the distances between them.

mod bound;
mod entries;
mod exact;
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

pub use bound::MAX_BOUNDED;
pub use item::{Item, MAX_COORDINATE_MM, MAX_ITEMS, Shape, TravelError, Way};
pub use route::{Route, Visit, is_allowed, travel_mm};
pub use settings::{Order, Retraction, Settings};
pub use solve::{lower_bound_mm, nearest_neighbour, solve};
