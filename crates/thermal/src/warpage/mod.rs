//! How much a part is likely to warp: a number to rank plans by, not a prediction.

mod estimator;
mod locking;
mod membrane;
mod plate;

pub use self::estimator::{WarpageEstimate, WarpageEstimator};
