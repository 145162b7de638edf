//! Costs of changes between zones or between tools.

mod crossing;
mod matrix;

pub(crate) use crossing::CrossingCosts;
pub use matrix::{CostMatrix, CostMatrixError};
