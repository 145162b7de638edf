//! Reads files of meshes.
//!
//! [`stl`], [`obj`] and [`threemf`] each read one format; [`format`] chooses among them.

mod error;
mod format;
mod obj;
mod polygon;
mod signature;
mod stl;
mod text;
mod threemf;
mod vertex_colours;

pub use error::{ReadError, ReadLimits};
pub use format::Format;
