//! Accuracy of the thermal solver as a flag.

use beadwork_thermal::simulation::Accuracy;
use clap::ValueEnum;

/// Value of `--accuracy`.
#[derive(Clone, Copy, ValueEnum)]
pub enum AccuracyName {
    /// To compare many orders: accurate only at the end of each layer.
    Draft,
    /// More accurate than the explicit scheme, in a fraction of its time.
    Standard,
    /// Errors several times smaller.
    High,
}

impl From<AccuracyName> for Accuracy {
    fn from(name: AccuracyName) -> Self {
        match name {
            AccuracyName::Draft => Self::Draft,
            AccuracyName::Standard => Self::Standard,
            AccuracyName::High => Self::High,
        }
    }
}
