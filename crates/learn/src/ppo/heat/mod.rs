//! The environments of the paper on toolpaths for even temperature (Kim et al. 2026): a step prints
//! a layer.

mod environment;
mod policy;
mod random;
mod task;
mod view;

pub use self::environment::HeatEnvironment;
pub use self::policy::{HeatPolicy, HeatPolicyError, PolicyTask};
pub use self::random::{RandomHeatEnvironment, RandomHeatError, RandomHeatTask};
pub use self::task::{HeatError, HeatSettings, HeatTask, TimePrice};
