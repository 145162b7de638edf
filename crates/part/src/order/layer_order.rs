//! Patterns and orders of lines under one type.

use std::fmt;
use std::str::FromStr;

use beadwork_grid::{Cell, Region};
use thiserror::Error;

use super::line_order::{LineOrder, LineOrderError};
use crate::pattern::{Pattern, UnknownPattern};

/// A named order in which the cells of a layer may be deposited: a [`Pattern`] or a [`LineOrder`].
///
/// Planners take their candidates as values of this type.
///
/// ```
/// use beadwork_grid::Region;
/// use beadwork_part::{LineOrder, Order, Pattern};
///
/// let sequence = "scattered-7".parse()?;
/// let lines = LineOrder::all_of(sequence).map(Order::from);
/// let candidates: Vec<Order> = Pattern::ALL.map(Order::from).into_iter().chain(lines).collect();
/// assert_eq!(candidates.len(), 46);
///
/// let region = Region::rectangle(12, 8)?;
/// for candidate in candidates {
///     assert_eq!(candidate.order(&region).len(), 96);
///     assert_eq!(candidate.to_string().parse(), Ok(candidate));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Order {
    /// One of the 38 patterns.
    Pattern(Pattern),
    /// An order of whole lines.
    Lines(LineOrder),
}

/// The error of parsing a name that no [`Order`] has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnknownOrder {
    /// The name does not begin with `lines`, and no pattern has it.
    #[error("{0}, or lines such as lines-x-scattered-7-0")]
    Pattern(UnknownPattern),
    /// The name begins with `lines`, but no order of lines has it.
    #[error(transparent)]
    Lines(#[from] LineOrderError),
}

impl Order {
    /// The order [`Pattern::CONVENTIONAL`].
    pub const CONVENTIONAL: Self = Self::Pattern(Pattern::CONVENTIONAL);

    /// Returns every cell of the region once, in the order of deposition.
    ///
    /// Takes O(n) for a grid of n cells; O(n log n) for patterns with outlines.
    pub fn order(self, region: &Region) -> Vec<Cell> {
        match self {
            Self::Pattern(pattern) => pattern.order(region),
            Self::Lines(lines) => lines.order(region),
        }
    }
}

impl From<Pattern> for Order {
    fn from(pattern: Pattern) -> Self {
        Self::Pattern(pattern)
    }
}

impl From<LineOrder> for Order {
    fn from(lines: LineOrder) -> Self {
        Self::Lines(lines)
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pattern(pattern) => pattern.fmt(f),
            Self::Lines(lines) => lines.fmt(f),
        }
    }
}

impl FromStr for Order {
    type Err = UnknownOrder;

    fn from_str(name: &str) -> Result<Self, UnknownOrder> {
        if name == "lines" || name.starts_with("lines-") {
            return Ok(Self::Lines(name.parse()?));
        }
        name.parse().map(Self::Pattern).map_err(UnknownOrder::Pattern)
    }
}
