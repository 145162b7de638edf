//! Ranges of a configuration's fields.

use std::fmt::Display;

use thiserror::Error;

/// A field of a configuration that is outside its range.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{field} is {value}: expected {expected}")]
pub struct RangeError {
    /// The field's key.
    pub field: &'static str,
    /// Its value.
    pub value: String,
    /// Its range.
    pub expected: &'static str,
}

/// Returns an error unless the condition holds.
pub(super) fn require(
    holds: bool,
    field: &'static str,
    value: &dyn Display,
    expected: &'static str,
) -> Result<(), RangeError> {
    if holds { Ok(()) } else { Err(RangeError { field, value: value.to_string(), expected }) }
}
