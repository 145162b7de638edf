//! What a search makes small.

use beadwork_grid::{Cell, Crossings, Path, Switch};

/// A cost of a path that is a sum over its links, so that its change by two switches can be told
/// without the path.
pub trait Cost {
    /// Cost of the whole path.
    fn total(&self, path: &Path) -> i64;

    /// By how much the cost changes if these two switches, which the path allows, are applied one
    /// after the other.
    fn change(&self, switches: [Switch; 2]) -> i64;

    /// Whether a switch in the unit cell at `corner` can change the cost by itself: where a search
    /// should look.
    ///
    /// The right neighbour, the one below and the one diagonally below must lie in the plane.
    fn is_sensitive(&self, corner: Cell, width: u32) -> bool;
}

/// The number of crossings.
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
