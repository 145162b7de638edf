//! The Hamiltonian core: what a layer is, how a path visits it, and the moves that change a path
//! without breaking it.
//!
//! # Words
//! A layer is a plane of **cells**, squares one bead wide.
//! The [`Region`] is the set of cells to print, the [`Zones`] give each of them a material.
//! A [`Path`] visits every cell of a region once in unit steps; a region that no single path can
//! cover is visited in several **pieces**.
//! A **crossing** is a step of the path between two zones ([`Crossings`]).
//! A [`Switch`] takes two parallel links of a unit cell (a square of 2 x 2 cells) out of the path
//! and puts the other two in; the [`Variant`]s are the twelve moves of Aali et al., each of them
//! two switches.
//!
//! # Axes and numbering
//! x points right, y down, both from 0. Cells are numbered row by row, x fastest:
//! `cell = y * width + x` ([`Cell`]).
//! The **position** of a cell is its place on the path, from 0. A unit cell is named by its
//! top-left cell, its **corner**.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, PlacedVariant, Region, Start, Variant};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0)?;
//! let crossings = Crossings::new(&region, &zones);
//! let mut path = Start::RowZigzag.path(&region, &Control::default())?;
//! assert_eq!(crossings.count(&path), 30);
//!
//! // A turn at the right edge widens by one row: both ends of it move one column inwards.
//! let wider = PlacedVariant { variant: Variant::Sr, x: 27, y: 0 };
//! assert!(path.apply_variant(wider));
//! assert_eq!(path.pieces(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guarantees
//! A [`Path`] is correct by construction: its constructors check the order they are given, and
//! every move either keeps all cells once and in unit steps or is refused and changes nothing.
//! [`verify`](verify()) checks an order from scratch, sharing no code with the moves.
//! Nothing here does I/O or depends on the machine; layouts are drawn with ChaCha8.
//!
//! # Limits
//! At most [`Region::MAX_SIDE`] cells a side and [`Zones::MAX`] zones.
//! A move keeps the first and the last cell of all and the two cells of every jump between pieces;
//! it cannot change the number of pieces.

mod components;
mod cover;
mod crossings;
mod layout;
mod links;
mod matching;
mod orders;
mod path;
mod region;
mod region_shape;
mod splice;
mod start;
mod switch;
mod symmetry;
mod variant;
mod verify;
mod zones;

pub use components::{Components, region_components, zone_components};
pub use cover::{cover, piece_bound};
pub use crossings::Crossings;
pub use layout::{Layout, LayoutError, LayoutSpec};
pub use links::Links;
pub use path::{Path, PathError};
pub use region::{Cell, Region, RegionError};
pub use region_shape::RegionShape;
pub use splice::Cuts;
pub use start::{Start, StartError};
pub use switch::{Sides, Switch};
pub use symmetry::Symmetry;
pub use variant::{PlacedVariant, Variant, VariantKind};
pub use verify::{VerifyError, verify};
pub use zones::{Zones, ZonesError};
