//! Valid ranges of the properties of materials and processes.

use thiserror::Error;

/// 0 °C in kelvin.
pub(crate) const ZERO_CELSIUS_K: f64 = 273.15;

/// Valid temperatures, °C: from absolute zero to where no thermoplastic is left.
pub(crate) const TEMPERATURE_RANGE_C: [f64; 2] = [-ZERO_CELSIUS_K, 1000.0];

/// A property of a material or a process is out of range.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PropertyError {
    /// The property must be positive.
    #[error("{property} is {value}: it must be more than 0")]
    NotPositive {
        /// Name of the field, with its unit.
        property: &'static str,
        /// Its value.
        value: f64,
    },
    /// The property must lie in a range.
    #[error("{property} is {value}: it must be from {min} to {max}")]
    OutOfRange {
        /// Name of the field, with its unit.
        property: &'static str,
        /// Its value.
        value: f64,
        /// The smallest valid value.
        min: f64,
        /// The largest valid value.
        max: f64,
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
    min: f64,
    max: f64,
) -> Result<(), PropertyError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(PropertyError::OutOfRange { property, value, min, max })
}

pub(crate) fn temperature(property: &'static str, value: f64) -> Result<(), PropertyError> {
    let [min, max] = TEMPERATURE_RANGE_C;
    within(property, value, min, max)
}
