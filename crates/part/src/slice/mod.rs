//! Layers: a model cut at the middle of every layer's height, and filled with cells one bead wide.
//!
//! [`cut()`] makes the [`Outline`] of one body in each layer; [`slice()`] goes on to the cells:
//! which of them each layer has (their centre lies in a body) and of which material they are.
//! [`Layers::voxels`] are the same as one array.

mod cutter;
mod each;
mod layers;
mod outline;
mod paint;
mod raster;
mod voxels;

pub use cutter::cut;
pub use layers::{Layer, Layers, Progress, Settings, SliceError, slice};
pub use outline::{FillRule, Outline, Polygon};
pub use voxels::Voxels;
