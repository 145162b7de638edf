//! What properties of materials and processes may be.

use thiserror::Error;

/// 0 °C in kelvin.
pub(crate) const ZERO_CELSIUS_K: f64 = 273.15;

/// A property that no material and no process has.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PropertyError {
    /// Must be more than 0.
    #[error("{property} is {value}: it must be more than 0")]
    NotPositive {
        /// Which, with its unit.
        property: &'static str,
        /// What it is.
        value: f64,
    },
    /// Must lie in a range.
    #[error("{property} is {value}: it must be from {least} to {most}")]
    OutOfRange {
        /// Which, with its unit.
        property: &'static str,
        /// What it is.
        value: f64,
        /// The least it may be.
        least: f64,
        /// The most it may be.
        most: f64,
    },
}

pub(crate) fn positive(property: &'static str, value: f64) -> Result<(), PropertyError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(PropertyError::NotPositive { property, value })
}

pub(crate) fn within(
    property: &'static str,
    value: f64,
    least: f64,
    most: f64,
) -> Result<(), PropertyError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(PropertyError::OutOfRange { property, value, least, most })
}

/// °C, from absolute zero to where no thermoplastic is left.
pub(crate) fn temperature(property: &'static str, value: f64) -> Result<(), PropertyError> {
    within(property, value, -ZERO_CELSIUS_K, 1000.0)
}
