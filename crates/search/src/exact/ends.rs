//! Where a path has to begin and end.

use beadwork_grid::{Cell, Region};

use crate::matching::Node;

/// Where a path has to begin or end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Terminal {
    /// Anywhere.
    #[default]
    Any,
    /// At this cell.
    Cell(Cell),
    /// At a cell of this side of the region.
    Side(Side),
}

/// A side of a region: its cells in the outermost column or row that has any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Those of least x.
    Left,
    /// Those of least y.
    Top,
    /// Those of greatest x.
    Right,
    /// Those of greatest y.
    Bottom,
}

impl Terminal {
    /// The cells it allows; none for [`Terminal::Any`].
    pub(super) fn cells(self, region: &Region) -> Vec<Cell> {
        let side = match self {
            Self::Any => return Vec::new(),
            Self::Cell(cell) => return vec![cell],
            Self::Side(side) => side,
        };
        let place = |cell: Cell| {
            let (x, y) = region.xy(cell);
            match side {
                Side::Left => x,
                Side::Top => y,
                Side::Right => region.width() - 1 - x,
                Side::Bottom => region.height() - 1 - y,
            }
        };
        let outermost = region.cells().map(place).min();
        region.cells().filter(|&cell| Some(place(cell)) == outermost).collect()
    }
}

/// The cells of one connected part at which the path may begin and end.
#[derive(Clone, Debug, Default)]
pub(super) struct Ends {
    /// Cells at which the first piece may begin; empty if it is free, or begins in another part.
    pub(super) first: Vec<Node>,
    /// Cells at which the last piece may end.
    pub(super) last: Vec<Node>,
    /// Whether the first and the last piece must not be one, for there are other parts between
    /// them.
    pub(super) apart: bool,
}
