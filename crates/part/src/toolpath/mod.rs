//! Toolpaths of a part: insets along the outlines, infill, and what neither of them reaches.
//!
//! [`islands`] divides the areas of each layer ([`Cut::areas`](crate::slice::Cut::areas)) into
//! [`Island`]s, the connected areas of one material.
//! Each island has, from outside to inside:
//!
//! - **insets** ([`Inset`]): closed lines along its outline, which slicers call perimeters;
//! - **infill** ([`Infill`]): lines in a pattern within the rest, solid near the top and bottom of
//!   the part, sparse elsewhere;
//! - **skeletons** ([`Skeleton`]): beads of varying width along the residue, where walls are
//!   thinner, or gaps between insets narrower, than what these reach.
//!   [`skeletons`] cover it with beads of varying width.
//!
//! The terms are those of *ORNL toolpath RL*.
//! Nothing here decides in which order lines are printed, nor which of them are linked.
//!
//! # Example
//! A box of 20 x 10 mm with two insets and 20 % infill:
//! ```
//! use beadwork_base::Control;
//! use beadwork_mesh::{Body, Model, Solid};
//! use beadwork_part::{slice, toolpath};
//!
//! let mesh = Solid::Cuboid { size_mm: [20.0, 10.0, 5.0] }.mesh();
//! let body = Body { name: "box".into(), mesh, material: Some(0), ..Body::default() };
//! let model = Model { bodies: vec![body], ..Model::default() };
//!
//! let (settings, control) = (slice::Settings::default(), Control::default());
//! let areas = slice::Cut::new(&model, &settings, &control)?.areas(&settings, &control)?;
//! let settings = toolpath::Settings { density: 0.2, ..toolpath::Settings::default() };
//! let layers = toolpath::islands(&areas, &settings, &control)?;
//!
//! let island = &layers[10][0];
//! assert_eq!(island.insets.len(), 2);
//! assert_eq!(island.insets[0].ring.len(), 4);
//! assert!(!island.infill[0].is_solid && !island.infill[0].lines.is_empty());
//! assert!(layers[0][0].infill[0].is_solid);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod honeycomb;
mod infill;
mod insets;
mod island;
mod islands;
mod scan_lines;
mod settings;
mod skeleton;
mod solid;

pub use island::{Infill, Inset, Island};
pub use islands::islands;
pub use settings::{InfillPattern, Settings, ToolpathError};
pub use skeleton::{Skeleton, SkeletonSettings, skeletons};

#[cfg(test)]
mod tests;
