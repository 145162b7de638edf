//! The simulation of a print: how it is set up, run, read and written.

mod deposit;
mod field;
mod setup;

pub use self::deposit::DepositError;
pub use self::field::FieldError;
pub use self::setup::{SetupError, Simulation};
pub use crate::fast::Accuracy;
pub use crate::method::Method;
