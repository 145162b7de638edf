//! Names of the orders of rows of beads.

use std::fmt;

use beadwork_part::{Sequence, Stride};

use super::super::OrderName;

/// Rows per strip that planners choose from.
const STRIP_ROWS: [u32; 5] = [1, 2, 3, 5, 8];

/// Strides of the interleaved and scattered orders of strips.
const STRIDES: std::ops::RangeInclusive<u32> = 2..=7;

/// An order of the beads of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RowOrder {
    /// As given: the conventional order, named `listed`.
    Listed,
    /// Everything that is not infill, then the infill in strips.
    Strips(Strips),
}

/// An order of the rows of a layer's infill: a [`Sequence`] of strips of consecutive rows.
///
/// The rows of a strip follow one another, so that they stay linked.
/// Its name is `rows`, sequence, and rows per strip if they are not 1, such as
/// `rows-scattered-7` and `rows-interleaved-2-by-5`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Strips {
    /// Order of the strips.
    pub sequence: Sequence,
    /// Rows per strip, at least 1.
    pub rows: u32,
    /// Whether rows are counted from the last one.
    pub is_descending: bool,
}

impl Strips {
    /// Returns each number from 0 to `count` - 1 once.
    pub(super) fn order(self, count: usize) -> Vec<usize> {
        let strip = self.rows.max(1) as usize;
        let strips = self.sequence.order(count.div_ceil(strip)).into_iter();
        let rows = strips.flat_map(|at| at * strip..((at + 1) * strip).min(count));
        if self.is_descending { rows.map(|row| count - 1 - row).collect() } else { rows.collect() }
    }
}

impl fmt::Display for RowOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Strips(Strips { sequence, rows, is_descending }) = self else {
            return f.pad("listed");
        };
        write!(f, "rows-{sequence}")?;
        if *rows != 1 {
            write!(f, "-by-{rows}")?;
        }
        f.write_str(if *is_descending { "-descending" } else { "" })
    }
}

impl OrderName for RowOrder {
    /// The listed order; then sequential, interleaved, scattered, golden and bit-reversed orders of
    /// strips of 1 to 8 rows, from both sides.
    fn all() -> Vec<Self> {
        let strides = STRIDES.filter_map(|k| Stride::new(k).ok());
        let sequences: Vec<Sequence> = strides
            .flat_map(|k| [Sequence::Interleaved(k), Sequence::Scattered(k)])
            .chain([Sequence::Golden, Sequence::BitReversed])
            .collect();
        let mut orders = vec![Self::Listed];
        let mut add = |sequence: Sequence, rows: u32| {
            orders.extend(
                [false, true]
                    .map(|is_descending| Self::Strips(Strips { sequence, rows, is_descending })),
            );
        };
        add(Sequence::Sequential, 1);
        for rows in STRIP_ROWS {
            sequences.iter().for_each(|&sequence| add(sequence, rows));
        }
        orders
    }
}
