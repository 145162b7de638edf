//! Rectangles of cells: the part of a grid that a body reaches.

use std::ops::Range;

use crate::frame::Frame;

/// A rectangle of cells of a layer's grid, row by row.
pub(super) struct Rectangle {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Rectangle {
    /// The cells that a figure with these corners, in mm, reaches, and one more on every side
    /// because positions are rounded; `None` if the grid has none of them.
    pub(super) fn around(corners: impl Iterator<Item = [f64; 2]>, frame: &Frame) -> Option<Self> {
        let mut min = [f64::INFINITY; 2];
        let mut max = [f64::NEG_INFINITY; 2];
        for corner in corners {
            let cell = frame.column_and_row(corner);
            min = [0, 1].map(|axis| cell[axis].min(min[axis]));
            max = [0, 1].map(|axis| cell[axis].max(max[axis]));
        }
        let range = |axis: usize, count: u32| {
            let bound = |cell: f64| cell.clamp(0.0, f64::from(count)) as usize;
            bound(min[axis] - 1.0)..bound(max[axis] + 2.0)
        };
        let (columns, rows) = (range(0, frame.width), range(1, frame.height));
        (!columns.is_empty() && !rows.is_empty()).then_some(Self { columns, rows })
    }

    pub(super) fn contains(&self, column: f64, row: f64) -> bool {
        (self.columns.start as f64..self.columns.end as f64).contains(&column)
            && (self.rows.start as f64..self.rows.end as f64).contains(&row)
    }

    /// Index of a cell within the rectangle.
    pub(super) fn index(&self, column: usize, row: usize) -> usize {
        (row - self.rows.start) * self.columns.len() + column - self.columns.start
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Column and row, in the layer, of an index within the rectangle.
    pub(super) fn column_and_row(&self, index: usize) -> (usize, usize) {
        let width = self.columns.len();
        (self.columns.start + index % width, self.rows.start + index / width)
    }
}
