//! The moves that searches make and record.

use beadwork_grid::{Path, PlacedVariant, Switch};

/// A move of a search: two switches of unit cells that together keep the number of pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// A variant of Aali et al.; it applies where the links in its window are those that the
    /// variant requires.
    Variant(PlacedVariant),
    /// Any two switches.
    Pair([Switch; 2]),
}

impl Move {
    /// Its two switches, in the order in which they apply; `width` is that of the grid in cells.
    pub fn switches(self, width: u32) -> [Switch; 2] {
        match self {
            Self::Variant(placed) => placed.switches(width),
            Self::Pair(switches) => switches,
        }
    }

    /// Applies the move and returns true, or returns false and leaves the path as it is if the move
    /// does not apply.
    pub fn apply(self, path: &mut Path) -> bool {
        match self {
            Self::Variant(placed) => path.apply_variant(placed),
            Self::Pair(switches) => path.apply(&switches),
        }
    }
}
