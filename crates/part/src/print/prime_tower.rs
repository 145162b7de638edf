//! The prime tower, which holds the material that tool changes purge.
//!
//! Seen from above, the tower is an outline of one bead around rows of cells, which run along x and
//! are counted from the front:
//!
//! ```text
//!   back    +-----------------------+
//!   row 4   | |     |     |     |   |   sparse columns, one every SPACING cells
//!   row 3   | |     |     |     |   |
//!   row 2   |=======================|   solid rows of the second change
//!   row 1   |=======================|
//!   row 0   |=======================|   solid row of the first change
//!   front   +-----------------------+
//! ```
//!
//! Each tool change of a layer fills as many whole rows as its purge volume needs; these rows are
//! solid and are assigned from the front to the back.
//! The rows that the layer does not need are filled with sparse columns, so that whatever the next
//! layer purges has something to rest on.
//! The first layer is solid everywhere, to stick to the bed.
//!
//! The tower has the same number of rows in every layer up to the last one that purges: the number
//! that the layer with the most purging needs.
//!
//! Corners of beads are in units of half a cell, as in [`toolpath`]; (0, 0) is the front left
//! corner of row 0.

use super::layer::toolpath;
use super::settings::{PrimeTower, Settings};
use super::settings_error::SettingsError;
use crate::Frame;

/// Cells from one sparse column to the next: a distance that a bead bridges without sagging.
const SPACING: i32 = 5;

/// Relative rounding error that is tolerated, so that it neither adds a row nor costs a column.
const TOLERANCE: f64 = 1e-9;

/// Position and size of the prime tower of a print.
#[derive(Clone, Debug)]
pub(super) struct PrimeTowerPlan {
    /// x of the left side of the outline.
    left_mm: f64,
    /// y of the front of the outline.
    front_mm: f64,
    cell_mm: f64,
    /// Cells in a row; the outline lies outside them.
    columns: i32,
    /// Number of rows.
    rows: i32,
    /// Number of the last layer that has the tower.
    pub(super) last_layer: usize,
    /// Volume of a row, in mm³.
    row_mm3: f64,
}

impl PrimeTowerPlan {
    /// Plans the tower of a print, given the tools of each layer in printing order; returns `None`
    /// if nothing is purged into a tower.
    ///
    /// # Errors
    /// If the settings' width leaves no room for a column, or their depth none for the rows of the
    /// layer that purges most.
    pub(super) fn new(
        layers: &[Vec<u8>],
        frame: &Frame,
        settings: &Settings,
    ) -> Result<Option<Self>, SettingsError> {
        let Some(purge) = &settings.purge else { return Ok(None) };
        let Some(PrimeTower { left_mm, front_mm, width_mm, depth_mm }) = purge.tower else {
            return Ok(None);
        };
        let cell_mm = frame.cell_mm;
        let columns = (width_mm / cell_mm + TOLERANCE).floor() - 2.0;
        let row_mm3 = columns * cell_mm * settings.process.bead_mm2(frame);
        let mut max_rows = 0.0;
        let mut last_layer = None;
        let mut tool = None;
        for (number, tools) in layers.iter().enumerate() {
            let mut rows = 0.0;
            for &next in tools {
                let before = tool.replace(next).unwrap_or(next);
                let volume = purge.prime_tower_mm3(before, next);
                if volume > 0.0 {
                    rows += rows_for(volume, row_mm3);
                    last_layer = Some(number);
                }
            }
            max_rows = f64::max(max_rows, rows);
        }
        let Some(last_layer) = last_layer else { return Ok(None) };
        if columns < 1.0 {
            return Err(SettingsError::PrimeTowerWidth { width_mm, needed_mm: 3.0 * cell_mm });
        }
        let needed_mm = (max_rows + 2.0) * cell_mm;
        if needed_mm > depth_mm * (1.0 + TOLERANCE) {
            return Err(SettingsError::PrimeTowerDepth { depth_mm, needed_mm });
        }
        let (columns, rows) = (columns as i32, max_rows as i32);
        Ok(Some(Self { left_mm, front_mm, cell_mm, columns, rows, last_layer, row_mm3 }))
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> i32 {
        self.rows
    }

    /// Number of whole rows that a purge volume needs.
    pub(super) fn rows_for(&self, volume_mm3: f64) -> i32 {
        rows_for(volume_mm3, self.row_mm3) as i32
    }

    /// x and y of a corner on the bed, in mm.
    pub(super) fn position_mm(&self, corner: [i32; 2]) -> [f64; 2] {
        // The outline is one cell wide, and the rows begin behind it.
        let along = |from: f64, halves: i32| from + (1.0 + f64::from(halves) / 2.0) * self.cell_mm;
        [along(self.left_mm, corner[0]), along(self.front_mm, corner[1])]
    }

    /// Corners of the outline, once around from the front left.
    pub(super) fn outline(&self) -> [[i32; 2]; 5] {
        let (right, back) = (2 * self.columns + 1, 2 * self.rows + 1);
        [[-1, -1], [right, -1], [right, back], [-1, back], [-1, -1]]
    }

    /// Corners of a bead that fills `rows` rows from row `begin` on, back and forth along x.
    pub(super) fn solid(&self, begin: i32, rows: i32) -> Vec<[i32; 2]> {
        let columns = self.columns;
        let cells = (begin..begin + rows).flat_map(|row| {
            let is_leftwards = (row - begin) % 2 == 1;
            (0..columns)
                .map(move |column| [if is_leftwards { columns - 1 - column } else { column }, row])
        });
        toolpath(None, cells, None)
    }

    /// Corners of a bead along sparse columns, back and forth along y, from row `begin` to the last
    /// row; empty if there are no such rows.
    pub(super) fn sparse(&self, begin: i32) -> Vec<[i32; 2]> {
        let (columns, end) = (self.columns, self.rows);
        if begin >= end {
            return Vec::new();
        }
        let cells =
            (0..columns).step_by(SPACING as usize).enumerate().flat_map(|(line, column)| {
                let to_front = line % 2 == 1;
                let across = (begin..end)
                    .map(move |row| [column, if to_front { begin + end - 1 - row } else { row }]);
                // Along the row where this column ends to the next column, if there is one.
                let edge = if to_front { begin } else { end - 1 };
                let next = column + SPACING;
                let along = (column + 1..next)
                    .filter(move |_| next < columns)
                    .map(move |column| [column, edge]);
                across.chain(along)
            });
        toolpath(None, cells, None)
    }
}

/// Number of whole rows that a volume needs; a float, because the number may not fit an integer.
fn rows_for(volume_mm3: f64, row_mm3: f64) -> f64 {
    (volume_mm3 / row_mm3 - TOLERANCE).ceil().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(columns: i32, rows: i32) -> PrimeTowerPlan {
        let (left_mm, front_mm, cell_mm, row_mm3) = (10.0, 20.0, 0.5, 1.0);
        PrimeTowerPlan { left_mm, front_mm, cell_mm, columns, rows, last_layer: 0, row_mm3 }
    }

    /// The cells that a bead passes through, one entry for each half cell that it fills.
    fn halves(corners: &[[i32; 2]]) -> Vec<[i32; 2]> {
        let mut found = Vec::new();
        for pair in corners.windows(2) {
            let [dx, dy] = [(pair[1][0] - pair[0][0]).signum(), (pair[1][1] - pair[0][1]).signum()];
            assert!(dx == 0 || dy == 0, "diagonal");
            let mut at = pair[0];
            while at != pair[1] {
                // From an edge to a centre or back: the cell is that of the lower coordinates.
                let to = [at[0] + dx, at[1] + dy];
                found.push([(at[0].min(to[0])).div_euclid(2), (at[1].min(to[1])).div_euclid(2)]);
                at = to;
            }
        }
        found
    }

    #[test]
    fn rows_are_filled_once() {
        for (columns, rows) in [(1, 1), (7, 1), (4, 5), (1, 6)] {
            let tower = plan(columns, rows);
            let mut found = halves(&tower.solid(0, rows));
            found.sort_unstable();
            let expected: Vec<_> =
                (0..columns).flat_map(|x| (0..rows).flat_map(move |y| [[x, y]; 2])).collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn sparse_columns_support_every_row() {
        for (columns, rows, begin) in [(1, 1, 0), (11, 6, 2), (23, 9, 8), (6, 4, 0), (5, 30, 7)] {
            let tower = plan(columns, rows);
            let mut found = halves(&tower.sparse(begin));
            found.sort_unstable();
            assert!(found.chunk_by(|a, b| a == b).all(|cell| cell.len() == 2), "each cell once");
            assert!(
                found.iter().all(|&[x, y]| (0..columns).contains(&x) && (begin..rows).contains(&y))
            );
            for row in begin..rows {
                let columns_of_row: Vec<_> =
                    found.iter().filter(|cell| cell[1] == row).map(|cell| cell[0]).collect();
                assert!(
                    columns_of_row.contains(&0)
                        && columns_of_row.windows(2).all(|pair| pair[1] - pair[0] <= SPACING)
                );
            }
        }
        assert!(plan(5, 5).sparse(5).is_empty());
    }

    #[test]
    fn positions_and_volumes() {
        let tower = plan(4, 2);
        let outline = tower.outline().map(|corner| tower.position_mm(corner));
        let near =
            |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9;
        assert!(near(outline[0], [10.25, 20.25]) && near(outline[2], [12.75, 21.75]));
        assert!(near(tower.position_mm([0, 1]), [10.5, 20.75]));
        let rows = [0.0, 0.5, 1.0, 1.000_000_000_1, 1.1, 3.0].map(|volume| tower.rows_for(volume));
        assert_eq!(rows, [0, 1, 1, 1, 2, 3]);
    }
}
