//! Regions, zones and paths on a grid of square cells, and the moves that change a path without
//! breaking it.
//!
//! A 3D printer fills a layer with beads of plastic.
//! Divide the layer into square cells one bead wide, and a bead becomes a path from cell to
//! neighbouring cell that visits each of them once: a Hamiltonian path of a grid graph.
//! If the layer consists of several materials, every step of the path from one material to another
//! costs a tool change, so a good path has few such steps.
//! This crate holds the layers, the paths, and fast moves between paths; searches for good paths
//! are built on it (`beadwork-search`).
//!
//! # Terms
//! - The **grid** of a layer is a rectangle of **cells**, squares one bead wide.
//! - A [`Region`] is the set of cells to print.
//!   It may have any shape; a connected piece of it is a **component** ([`region_components`]).
//! - [`Zones`] assign each cell of a region to a **zone**, usually a material.
//!   A [`LayoutSpec`] generates zones, a [`RegionShape`] generates regions.
//! - A **link** joins two cells that share a side.
//! - A [`Path`] visits every cell of a region once, along links.
//!   A region that no single path can cover is visited in several **pieces**, with a **jump** from
//!   the end of one to the start of the next.
//!   A [`Start`] is a simple path to start a search from, and [`cover()`] finds one in few pieces
//!   for any region.
//! - A **crossing** is a link of a path between two zones ([`Crossings`]).
//! - A **unit cell** is a square of 2 x 2 cells, named by its top-left cell, the **corner**.
//! - A [`Switch`] takes two parallel links of a unit cell out of a path and puts in the other two.
//!   It is the smallest change that keeps the number of links of every cell.
//! - A [`Variant`] is one of the twelve moves of Aali et al., each of which is two switches: a
//!   **flip** of unit cells side by side, or a **transpose** of unit cells that touch at a corner.
//!
//! # Axes and numbering
//! x points to the right and y down; both start at 0. A [`Cell`] is numbered row by row, x fastest:
//! `cell = y * width + x`.
//! Slices indexed by cell cover the whole grid, not only the region.
//! Arrays (`ndarray`) have the axes `[y, x]`.
//! The **position** of a cell is its index on the path, from 0.
//!
//! # Example: a path, its crossings and a move
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, PlacedVariant, Region, Start, Variant};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0)?;
//! let crossings = Crossings::new(&region, &zones);
//! let mut path = Start::RowZigzag.path(&region, &Control::default())?;
//! // Each of the 30 rows crosses from the left to the right half, or back.
//! assert_eq!(crossings.count(&path), 30);
//!
//! // The turn between rows 0 and 1 moves two columns to the left, and row 2 takes over the cells
//! // that it leaves: see the picture at `Variant::Sr`.
//! let wider = PlacedVariant { variant: Variant::Sr, x: 27, y: 0 };
//! assert!(path.apply_variant(wider));
//! assert_eq!(path.pieces(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Example: a layer from an array
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Region, Zones, cover, piece_bound, verify};
//! use ndarray::array;
//!
//! // 0 is outside; 1 and 2 are two materials.
//! let materials = array![[0, 1, 0], [1, 1, 2], [0, 2, 0]];
//! let region = Region::from_array(materials.map(|&material| material != 0).view())?;
//! let zones = Zones::from_array(&region, materials.map(|&m: &u8| m.saturating_sub(1)).view())?;
//! assert_eq!(zones.view(&region)[[1, 2]], 1);
//!
//! // No path can pass all four arms of a plus, so it is covered in three pieces.
//! let path = cover(&region, &Control::default())?;
//! assert_eq!(path.pieces(), 3);
//! assert_eq!(piece_bound(&region, &Control::default())?, 3);
//! assert_eq!(verify(&region, path.order()), Ok(3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Which type for which task
//! - [`Path`] knows the position of every cell.
//!   It decides in constant time whether two switches anywhere keep the path in one piece, and
//!   rewrites the positions between the cuts when they are applied.
//! - [`Links`] only know which cells are linked.
//!   They apply a variant in constant time, but no other pair of switches.
//! - [`Symmetry`] maps cells and variants to rotated and reflected grids.
//!
//! # Guarantees
//! - A [`Path`] is correct by construction: its constructors check the given order, and a move that
//!   would not keep the number of pieces is refused and changes nothing.
//!   [`verify()`] checks an order from scratch and shares no code with the moves.
//! - Nothing here does I/O, reads a clock or depends on the machine.
//!   Random layouts and shapes use ChaCha8, so a seed gives the same result everywhere.
//!
//! # Limits
//! - A grid has at most [`Region::MAX_SIDE`] cells a side, and a layer at most [`Zones::MAX`]
//!   zones.
//! - Moves do not change the number of pieces.
//!   They keep the first and the last cell of the whole path; jumps between pieces keep their two
//!   cells.
//! - [`cover()`] does not always find the minimum number of pieces.
//!
//! The crate has no cargo features.

mod bits;
mod components;
mod cover;
mod crossings;
mod cuts;
mod layout;
mod links;
mod matching;
mod orders;
mod path;
mod region;
mod region_shape;
mod rules;
mod splice;
mod splice_plan;
mod start;
mod switch;
mod symmetry;
mod variant;
mod verify;
mod zones;

pub use components::{Components, region_components, zone_components};
pub use cover::{cover, piece_bound};
pub use crossings::Crossings;
pub use cuts::Cuts;
pub use layout::{Layout, LayoutError, LayoutSpec};
pub use links::Links;
pub use path::{Path, PathError};
pub use region::{Cell, Region, RegionError};
pub use region_shape::RegionShape;
pub use start::{Start, StartError};
pub use switch::{Sides, Switch};
pub use symmetry::Symmetry;
pub use variant::{PlacedVariant, Variant, VariantKind};
pub use verify::{VerifyError, verify};
pub use zones::{Zones, ZonesError};
