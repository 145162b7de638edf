//! The simulation of a print: how it is set up, run, read and written.

mod deposit;
mod field;
mod setup;
mod trials;

pub use self::deposit::DepositError;
pub use self::field::FieldError;
pub use self::setup::{SetupError, Simulation};
pub use self::trials::{BestTrial, Trials};
pub use crate::fast::Accuracy;
pub use crate::method::Method;
