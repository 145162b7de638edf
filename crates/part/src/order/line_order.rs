//! Named orders of the lines of a layer.

use std::fmt;
use std::str::FromStr;

use beadwork_base::named_enum;
use beadwork_grid::{Cell, Region};
use thiserror::Error;

use super::lines::{Ends, Lines};
use super::sequence::{Sequence, SequenceError};
use crate::pattern::view::View;

/// An order of whole lines: a [`Sequence`] of the rows of a layer, or of its columns, from a
/// corner.
///
/// Its name is `lines`, axis, sequence and corner, such as `lines-x-scattered-7-0` and
/// `lines-y-golden-3`.
/// Corners have the numbers that they have in the names of patterns.
///
/// Rows are numbered from the corner; rows without cells are not counted.
/// Each row is printed as a whole, across its holes and gaps, from the end nearer to the nozzle
/// ([`Ends::Nearest`]), so that consecutive rows alternate in direction where that saves travel.
/// The first row begins at the end towards the corner.
/// On a rectangle, `lines-x-sequential-0` is the pattern `zigzag-x-0`.
///
/// Orders from other corners are mirror images of those from corner 0, and orders along y are
/// transpositions of those along x.
///
/// # Example
/// ```
/// use beadwork_grid::Region;
/// use beadwork_part::{Axis, Corner, LineOrder, Sequence, Stride};
///
/// let region = Region::rectangle(3, 4)?;
/// let order: LineOrder = "lines-x-interleaved-2-0".parse()?;
/// assert_eq!(order.order(&region), [0, 1, 2, 8, 7, 6, 3, 4, 5, 11, 10, 9]);
/// let sequence = Sequence::Interleaved(Stride::new(2)?);
/// assert_eq!(order, LineOrder { sequence, axis: Axis::X, corner: Corner::MinXMinY });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A search starts from a named order and permutes its lines:
/// ```
/// use beadwork_grid::Region;
/// use beadwork_part::{Ends, LineOrder};
///
/// let region = Region::rectangle(5, 9)?;
/// let order: LineOrder = "lines-x-golden-0".parse()?;
/// let (lines, ends) = (order.lines(&region), Ends::Nearest { from: None });
/// let mut permutation = lines.permutation(order.sequence, ends);
/// assert_eq!(lines.order(&permutation, ends)?, order.order(&region));
/// permutation.swap(7, 8);
/// assert_ne!(lines.order(&permutation, ends)?, order.order(&region));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LineOrder {
    /// Order of the rows, or of the columns if the lines run along y.
    pub sequence: Sequence,
    /// Axis along which the lines run.
    pub axis: Axis,
    /// Corner from which rows and their cells are numbered.
    pub corner: Corner,
}

/// Axis along which lines run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axis {
    /// Lines are parts of rows.
    X,
    /// Lines are parts of columns.
    Y,
}

named_enum! {
    Axis, "axis":
    X = "x",
    Y = "y",
}

/// A corner of the grid; its name is its number, 0 to 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Corner {
    /// Corner 0.
    MinXMinY,
    /// Corner 1.
    MaxXMinY,
    /// Corner 2.
    MinXMaxY,
    /// Corner 3.
    MaxXMaxY,
}

named_enum! {
    Corner, "corner":
    MinXMinY = "0",
    MaxXMinY = "1",
    MinXMaxY = "2",
    MaxXMaxY = "3",
}

/// The error of parsing a name that no [`LineOrder`] has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum LineOrderError {
    /// The name does not consist of `lines`, axis, sequence and corner.
    #[error(
        "unknown order of lines '{0}': expected lines, axis, sequence and corner (0 to 3), such \
         as lines-x-scattered-7-0 or lines-y-golden-3"
    )]
    Unknown(String),
    /// The name's sequence is unknown or incomplete.
    #[error("order of lines '{name}': {source}")]
    Sequence {
        /// The whole name.
        name: String,
        /// The error of the sequence.
        source: SequenceError,
    },
}

impl LineOrder {
    /// The orders of a sequence along both axes and from all corners: x before y, sorted by corner.
    pub fn all_of(sequence: Sequence) -> [Self; 8] {
        std::array::from_fn(|at| Self {
            sequence,
            axis: Axis::ALL[at / 4],
            corner: Corner::ALL[at % 4],
        })
    }

    /// The lines of a region, numbered from the corner.
    ///
    /// Takes O(n) for a grid of n cells.
    pub fn lines(self, region: &Region) -> Lines {
        Lines::new(region, &View::new(region, self.axis == Axis::Y, self.corner as u8))
    }

    /// Returns every cell of the region once, in the order of deposition.
    ///
    /// Takes O(n) for a grid of n cells, and what [`Sequence::order`] takes for its rows.
    pub fn order(self, region: &Region) -> Vec<Cell> {
        let (lines, ends) = (self.lines(region), Ends::Nearest { from: None });
        lines.flatten(&lines.permutation(self.sequence, ends), ends)
    }
}

impl fmt::Display for LineOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sequence, axis, corner } = self;
        f.pad(&format!("lines-{axis}-{sequence}-{corner}"))
    }
}

impl FromStr for LineOrder {
    type Err = LineOrderError;

    fn from_str(name: &str) -> Result<Self, LineOrderError> {
        let unknown = || LineOrderError::Unknown(name.to_owned());
        let rest = name.strip_prefix("lines-").ok_or_else(unknown)?;
        let (axis, rest) = rest.split_once('-').ok_or_else(unknown)?;
        let (sequence, corner) = rest.rsplit_once('-').ok_or_else(unknown)?;
        let axis = axis.parse().map_err(|_| unknown())?;
        let corner = corner.parse().map_err(|_| unknown())?;
        let sequence = sequence
            .parse()
            .map_err(|source| LineOrderError::Sequence { name: name.to_owned(), source })?;
        Ok(Self { sequence, axis, corner })
    }
}
