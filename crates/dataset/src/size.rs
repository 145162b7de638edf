//! Sizes of grids in configurations.

use std::fmt;
use std::str::FromStr;

use beadwork_grid::Region;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Width and height of a grid in cells, written "30x100".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size {
    /// Width in cells.
    pub width: u32,
    /// Height in cells.
    pub height: u32,
}

/// A text is not a [`Size`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("invalid size '{0}': expected WIDTHxHEIGHT, each 1 to {max}", max = Region::MAX_SIDE)]
pub struct SizeError(pub String);

impl FromStr for Size {
    type Err = SizeError;

    fn from_str(text: &str) -> Result<Self, SizeError> {
        let side =
            |text: &str| text.parse().ok().filter(|side| (1..=Region::MAX_SIDE).contains(side));
        let size = text
            .split_once('x')
            .and_then(|(width, height)| Some(Self { width: side(width)?, height: side(height)? }));
        size.ok_or_else(|| SizeError(text.to_owned()))
    }
}

impl TryFrom<String> for Size {
    type Error = SizeError;

    fn try_from(text: String) -> Result<Self, SizeError> {
        text.parse()
    }
}

impl From<Size> for String {
    fn from(size: Size) -> Self {
        size.to_string()
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}
