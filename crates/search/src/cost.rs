//! The objective that a search minimises.

use beadwork_grid::{Cell, Crossings, Path, Switch};

/// A cost of paths that is a sum over their links.
///
/// A search then knows how a move changes the cost from the links that the move removes and adds,
/// without looking at the rest of the path.
pub trait Cost {
    /// Cost of a whole path.
    fn total(&self, path: &Path) -> i64;

    /// Change of the cost if two switches, which the path must allow, are applied one after the
    /// other.
    fn change(&self, switches: [Switch; 2]) -> i64;

    /// Whether a single switch in the unit cell at `corner` can change the cost.
    /// Searches look for moves near such unit cells.
    ///
    /// The neighbours of `corner` to the right, below and diagonally below must lie in the grid,
    /// whose width is given in cells.
    fn is_sensitive(&self, corner: Cell, width: u32) -> bool;
}

/// The number of zone crossings.
impl Cost for Crossings {
    fn total(&self, path: &Path) -> i64 {
        i64::from(self.count(path))
    }

    #[inline]
    fn change(&self, [first, second]: [Switch; 2]) -> i64 {
        i64::from(Self::change(self, first) + Self::change(self, second))
    }

    fn is_sensitive(&self, corner: Cell, width: u32) -> bool {
        self.right(corner)
            || self.right(corner + width)
            || self.below(corner)
            || self.below(corner + 1)
    }
}
