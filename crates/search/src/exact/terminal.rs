//! Constraints on where a path begins and ends.

use beadwork_grid::{Cell, Region};

use crate::matching::Node;

/// A constraint on the first or the last cell of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Terminal {
    /// Any cell.
    #[default]
    Any,
    /// This cell.
    Cell(Cell),
    /// Any cell of this side of the region.
    Side(Side),
}

/// A side of a region: the cells in its outermost non-empty column or row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The cells with the minimum x.
    Left,
    /// The cells with the minimum y.
    Top,
    /// The cells with the maximum x.
    Right,
    /// The cells with the maximum y.
    Bottom,
}

impl Terminal {
    /// The cells it allows, in ascending order; empty for [`Terminal::Any`].
    pub(super) fn cells(self, region: &Region) -> Vec<Cell> {
        let side = match self {
            Self::Any => return Vec::new(),
            Self::Cell(cell) => return vec![cell],
            Self::Side(side) => side,
        };
        let distance_from_side = |cell: Cell| {
            let (x, y) = region.xy(cell);
            match side {
                Side::Left => x,
                Side::Top => y,
                Side::Right => region.width() - 1 - x,
                Side::Bottom => region.height() - 1 - y,
            }
        };
        let outermost = region.cells().map(distance_from_side).min();
        region.cells().filter(|&cell| Some(distance_from_side(cell)) == outermost).collect()
    }
}

/// The cells of one component at which the path may begin and end.
#[derive(Clone, Debug, Default)]
pub(super) struct EndCells {
    /// Cells at which the first piece may begin; empty if it may begin anywhere, or begins in
    /// another component.
    pub(super) first: Vec<Node>,
    /// Cells at which the last piece may end; empty if it may end anywhere, or ends in another
    /// component.
    pub(super) last: Vec<Node>,
    /// Whether the first and the last piece must differ, because pieces of other components come
    /// between them.
    pub(super) in_different_pieces: bool,
}
