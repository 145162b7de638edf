//! Reads files of meshes.
//!
//! [`stl`], [`obj`] and [`threemf`] each read one format; [`format`] chooses among them.

mod error;
mod format;
mod obj;
mod stl;
mod text;
mod threemf;

pub use error::{ReadError, ReadLimits};
pub use format::Format;
