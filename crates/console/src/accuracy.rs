//! How exact the thermal solver is, as typed.

use beadwork_thermal::Accuracy;
use clap::ValueEnum;

/// The accuracies by their names.
#[derive(Clone, Copy, ValueEnum)]
pub enum AccuracyName {
    Standard,
    High,
}

impl From<AccuracyName> for Accuracy {
    fn from(name: AccuracyName) -> Self {
        match name {
            AccuracyName::Standard => Self::Standard,
            AccuracyName::High => Self::High,
        }
    }
}
