//! The moves that a search records.

use beadwork_grid::{Path, PlacedVariant, Switch};

/// One move of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// A variant of Aali et al., which needs exactly its links in its window.
    Variant(PlacedVariant),
    /// Any two switches.
    Pair([Switch; 2]),
}

impl Move {
    /// The switches it stands for, in the order in which they apply, in a plane so many cells wide.
    pub fn switches(self, width: u32) -> [Switch; 2] {
        match self {
            Self::Variant(placed) => placed.switches(width),
            Self::Pair(switches) => switches,
        }
    }

    /// Applies it; where it does not apply it changes nothing and gives false.
    pub fn apply(self, path: &mut Path) -> bool {
        match self {
            Self::Variant(placed) => path.apply_variant(placed),
            Self::Pair(switches) => path.apply(&switches),
        }
    }
}
