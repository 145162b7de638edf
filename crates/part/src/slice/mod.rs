//! Slicing: a model is cut at the centre height of every layer, and each cross-section is filled
//! with square cells one bead wide.
//!
//! [`slice()`] does all of it.
//! Its two halves are available separately: [`Cut::new`] computes the [`Outline`] of every body in
//! every layer, which is the expensive part and does not depend on the cell grid; [`Cut::layers`]
//! fills the outlines with cells, and can be repeated with other bead widths and grid phases.
//! [`cut()`] is the cut of a single mesh.
//!
//! A cell belongs to a layer if its centre lies inside a body.
//! [`Layers::voxels`] returns all layers as one array.

mod areas;
mod body_cut;
mod colour_areas;
mod coverage;
mod cut;
mod fill;
mod grid_fit;
mod layers;
mod nearest_seed;
mod outline;
mod overhang;
mod plane_sweep;
mod raster;
mod rectangle;
mod settings;
mod surface_colours;
mod surface_columns;
mod voxels;
mod work;

pub use areas::{LayerAreas, MaterialArea};
pub use coverage::Coverage;
pub use cut::{Cut, slice};
pub use layers::{Layer, Layers};
pub use outline::{FillRule, Outline, Polygon};
pub use overhang::overhangs_mm2;
pub use plane_sweep::cut;
pub use settings::{Settings, SliceError};
pub use voxels::Voxels;
