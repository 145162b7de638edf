//! Links infill lines to few beads.
//!
//! Each bead ends with a lift, which takes time and leaves a weak point, so a layer should have few
//! beads.
//! This module takes the lines of an infill and the links by which the nozzle may go from one to
//! another while it extrudes, and finds the **fewest beads** that contain each line once.
//! *ORNL toolpath RL* reduces their number by better starts of nearest neighbour
//! ([`Method::BreakPoints`]); [`Method::Cover`] minimises it, with a proven lower bound.
//!
//! Points are plain `[f64; 2]` in mm, so another slicer can call it with its own lines.
//!
//! # Terms
//! - A **line** is an open polyline that is extruded whole, in either direction: an infill line,
//!   usually of two points.
//!   It has two **ends** ([`End`]).
//! - A **link** ([`Link`]) is a step by extrusion between ends of two lines.
//!   Which links are permitted is a value, [`Links`], made by geometry ([`Rule`]), by a caller's
//!   predicate ([`Links::by_predicate`]) or from a list ([`Links::new`]).
//! - Two links that cross are a **conflict**: only one of them may be used.
//! - A **bead** ([`Bead`]) is a sequence of lines, each with a direction, and of the links between
//!   them.
//! - A **lift** separates two beads.
//!
//! # Example
//! Lines at a spacing of 2 mm in a square with a square hole:
//! ```
//! use beadwork_base::Control;
//! use beadwork_search::link::{self, Method, Rule, Settings};
//!
//! let square = |min: f64, max: f64| vec![[min, min], [max, min], [max, max], [min, max]];
//! let rings = [square(0.0, 20.0), square(6.0, 14.0)];
//! let mut lines = Vec::new();
//! for y in (1..20).step_by(2).map(f64::from) {
//!     if (6.0..14.0).contains(&y) {
//!         lines.push([[0.0, y], [6.0, y]]);
//!         lines.push([[14.0, y], [20.0, y]]);
//!     } else {
//!         lines.push([[0.0, y], [20.0, y]]);
//!     }
//! }
//! let links = Rule::default().links(&lines, &rings, 2.0)?;
//!
//! let outcome = link::solve(&links, &Settings::default(), &Control::default());
//! assert_eq!(outcome.beads.len(), 2);
//! assert!(outcome.is_optimal());
//! let points = outcome.beads[0].points(&lines, &links);
//! assert!(points.len() >= 2 * outcome.beads[0].lines.len());
//!
//! // Nearest neighbour, as most slicers do it, and the better starts of the paper.
//! let nearest = Settings { method: Method::Nearest, ..Settings::default() };
//! let nearest = link::solve(&links, &nearest, &Control::default());
//! let break_points = Settings { method: Method::BreakPoints, ..Settings::default() };
//! let break_points = link::solve(&links, &break_points, &Control::default());
//! assert!(break_points.beads.len() <= nearest.beads.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bead;
mod cover;
mod end;
mod kd_tree;
mod links;
mod nearest;
mod region;
mod rule;
mod settings;
mod solve;
mod straight;

pub use bead::{Bead, BeadsError, DirectedLine, verify};
pub use end::{End, Link, Point};
pub use links::{Links, LinksError};
pub use rule::Rule;
pub use settings::{Method, Outcome, Settings, Work};
pub use solve::solve;
