//! What a route visits.

use thiserror::Error;

/// Largest absolute value of a coordinate, in mm.
///
/// Squares and sums of distances stay far from overflow and keep their precision.
pub const MAX_COORDINATE_MM: f64 = 1e9;

/// An open bead or a closed loop to print.
///
/// Items of one group (an island, say) can be kept together, and printed by ascending stage (loops
/// before infill, say): see [`Order`](super::Order).
/// Any numbers may serve as groups and stages; only their equality and their order count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item<'a> {
    /// Where the nozzle begins and ends.
    pub shape: Shape<'a>,
    /// Group that the item belongs to.
    pub group: u32,
    /// Stage within the group.
    pub stage: u32,
}

impl<'a> Item<'a> {
    /// A bead from `start` to `end` that may be reversed, in group 0 and stage 0.
    pub fn bead(start: [f64; 2], end: [f64; 2]) -> Self {
        Self { shape: Shape::Bead { start, end, reversible: true }, group: 0, stage: 0 }
    }

    /// A loop that can begin at any of `entries`, in group 0 and stage 0.
    pub fn closed(entries: &'a [[f64; 2]]) -> Self {
        Self { shape: Shape::Loop { entries }, group: 0, stage: 0 }
    }

    /// Returns this item in another group and stage.
    pub fn within(self, group: u32, stage: u32) -> Self {
        Self { group, stage, ..self }
    }
}

/// Where the nozzle can begin an item, and where it then ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<'a> {
    /// An open bead.
    Bead {
        /// First point, in mm.
        start: [f64; 2],
        /// Last point, in mm.
        end: [f64; 2],
        /// Whether the bead can also be printed from `end` to `start`.
        reversible: bool,
    },
    /// A closed loop, which ends where it begins.
    Loop {
        /// The points at which the loop can begin, in mm; a single one is a fixed seam.
        entries: &'a [[f64; 2]],
    },
}

/// How an item is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// A bead from its start to its end.
    Forward,
    /// A bead from its end to its start.
    Backward,
    /// A loop from the entry with this index.
    Entry(usize),
}

/// Reason why items cannot be ordered.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TravelError {
    /// A coordinate is infinite, not a number, or beyond [`MAX_COORDINATE_MM`].
    #[error("item {item}: coordinate is not a finite number within {MAX_COORDINATE_MM:e} mm")]
    Coordinate {
        /// Index of the item.
        item: usize,
    },
    /// A coordinate of the position of the nozzle is infinite, not a number, or beyond
    /// [`MAX_COORDINATE_MM`].
    #[error("nozzle position: coordinate is not a finite number within {MAX_COORDINATE_MM:e} mm")]
    From,
    /// A number of the cost of retractions is infinite, negative or not a number.
    #[error("cost of retractions is not a finite number of at least 0")]
    Retraction,
    /// A loop has no entry.
    #[error("item {item}: loop has no entry")]
    NoEntry {
        /// Index of the item.
        item: usize,
    },
    /// There are more than [`MAX_ITEMS`] items.
    #[error("{count} items are too many: at most {MAX_ITEMS}")]
    TooMany {
        /// Number of items.
        count: usize,
    },
}

/// Maximum number of items of a route.
pub const MAX_ITEMS: usize = 1 << 24;

/// Checks that all coordinates are usable and that each loop has an entry.
pub(super) fn check(items: &[Item<'_>], from: Option<[f64; 2]>) -> Result<(), TravelError> {
    let is_usable = |point: &[f64; 2]| point.iter().all(|c| c.abs() <= MAX_COORDINATE_MM);
    if items.len() > MAX_ITEMS {
        return Err(TravelError::TooMany { count: items.len() });
    }
    if !from.iter().all(is_usable) {
        return Err(TravelError::From);
    }
    for (item, Item { shape, .. }) in items.iter().enumerate() {
        let usable = match shape {
            Shape::Bead { start, end, .. } => is_usable(start) && is_usable(end),
            Shape::Loop { entries: [] } => return Err(TravelError::NoEntry { item }),
            Shape::Loop { entries } => entries.iter().all(is_usable),
        };
        if !usable {
            return Err(TravelError::Coordinate { item });
        }
    }
    Ok(())
}
