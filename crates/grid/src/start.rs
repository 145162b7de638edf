//! Start paths: the paths from which a search starts.

use beadwork_base::{Control, Interrupted};
use thiserror::Error;

use crate::orders::{column_zigzag, first_jump, row_zigzag, spiral};
use crate::{Path, Region, cover};

/// A start path: a way to visit a region that does not depend on its zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Start {
    /// Rows from top to bottom, alternately from left to right and back.
    RowZigzag,
    /// Columns from left to right, alternately from top to bottom and back.
    ColumnZigzag,
    /// A clockwise spiral inwards, from the top-left cell.
    Spiral,
    /// The path of [`cover()`], which exists on every region and may have several pieces.
    Cover,
}

/// Why [`Start::path`] returned no path.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum StartError {
    /// The start is not a path of one piece on this region: two consecutive cells are not
    /// neighbours.
    #[error(
        "{start} start jumps from ({}, {}) to ({}, {}) on this region; \
         the cover start exists on every region",
        from.0, from.1, to.0, to.1
    )]
    Jump {
        /// The requested start.
        start: Start,
        /// Column and row of the cell before the first jump.
        from: (u32, u32),
        /// Column and row of the cell after it.
        to: (u32, u32),
    },
    /// The call was cancelled or reached its time limit.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

beadwork_base::named_enum! {
    Start, "start":
    RowZigzag = "row_zigzag",
    ColumnZigzag = "column_zigzag",
    Spiral = "spiral",
    Cover = "cover",
}

impl Start {
    /// Makes the path of this start on a region, in one piece except for [`Start::Cover`].
    ///
    /// The same region always gives the same path.
    /// Linear in the grid's cells, except for the cover: see [`cover()`] for its cost and its
    /// progress report.
    /// The other starts are fast; they neither report progress nor can they be interrupted.
    pub fn path(self, region: &Region, control: &Control<'_>) -> Result<Path, StartError> {
        let order = match self {
            Self::RowZigzag => row_zigzag(region),
            Self::ColumnZigzag => column_zigzag(region),
            Self::Spiral => spiral(region),
            Self::Cover => return Ok(cover(region, control)?),
        };
        if let Some((from, to)) = first_jump(region, &order) {
            let (from, to) = (region.xy(from), region.xy(to));
            return Err(StartError::Jump { start: self, from, to });
        }
        Ok(Path::hamiltonian(region, order).expect("all cells of the region, in unit steps"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rectangle_has_every_start() {
        for width in 1..8 {
            for height in 1..8 {
                let region = Region::rectangle(width, height).unwrap();
                for start in Start::ALL {
                    let path = start.path(&region, &Control::default()).unwrap();
                    assert_eq!(path.order()[0], 0, "{start} on {width} x {height}");
                    assert_eq!(path.pieces(), 1, "{start} on {width} x {height}");
                }
            }
        }
    }

    #[test]
    fn orders_of_a_small_rectangle() {
        let region = Region::rectangle(3, 3).unwrap();
        let order =
            |start: Start| start.path(&region, &Control::default()).unwrap().order().to_vec();
        assert_eq!(order(Start::RowZigzag), [0, 1, 2, 5, 4, 3, 6, 7, 8]);
        assert_eq!(order(Start::ColumnZigzag), [0, 3, 6, 7, 4, 1, 2, 5, 8]);
        assert_eq!(order(Start::Spiral), [0, 1, 2, 5, 8, 7, 6, 3, 4]);
    }

    #[test]
    fn error_says_where_the_path_would_jump() {
        let ring = Region::from_mask(3, 3, (0..9).map(|cell| cell != 4).collect()).unwrap();
        let error = Start::RowZigzag.path(&ring, &Control::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "row_zigzag start jumps from (2, 1) to (0, 1) on this region; \
             the cover start exists on every region"
        );
        assert_eq!(Start::Spiral.path(&ring, &Control::default()).unwrap().pieces(), 1);
        assert_eq!(Start::Cover.path(&ring, &Control::default()).unwrap().pieces(), 1);
    }

    #[test]
    fn names_round_trip() {
        for start in Start::ALL {
            assert_eq!(start.name().parse(), Ok(start));
        }
        assert_eq!(
            "zigzag".parse::<Start>().unwrap_err().to_string(),
            "unknown start 'zigzag': expected row_zigzag, column_zigzag, spiral or cover"
        );
    }
}
