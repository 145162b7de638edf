//! Plans of whole parts with the minimum sum of tool changes and lifts.

mod error;
mod outcome;
mod settings;
mod solve;
#[cfg(test)]
mod tests;

pub use super::cover::LayerRef;
pub use error::PlanError;
pub use outcome::{FrontierPoint, LayerPlan, ToolPlan};
pub use settings::{Mode, Settings, Stacking};
pub use solve::solve;
