//! The tower that takes up what is purged when tools change.
//!
//! It is an outline of one bead and rows of beads within, counted from the front.
//! A layer purges into the first rows, solid, one change after the other, and fills the rest with
//! sparse lines across the rows, so that whatever the next layer purges rests on something.
//! The first layer is solid all over, to hold on the bed.

use super::layer::corners;
use super::{Layer, PrimeTower, Settings, SettingsError};
use crate::Frame;

/// Cells from one sparse line to the next: what a bead bridges without hanging through.
const SPACING: i32 = 5;

/// Where the tower goes, and how much of it each layer takes.
#[derive(Clone, Debug)]
pub(super) struct PrimeTowerPlan {
    left_mm: f64,
    front_mm: f64,
    cell_mm: f64,
    /// Cells of a row, within the outline.
    columns: i32,
    rows: i32,
    /// Number of the last layer that has the tower.
    pub(super) last_layer: usize,
    /// Volume of a row, in mm³.
    row_mm3: f64,
}

/// Half a row's rounding: a volume of whole rows takes no row more.
const SLACK: f64 = 1e-9;

impl PrimeTowerPlan {
    /// The tower of a print; `None` if nothing is purged into one.
    pub(super) fn new(
        layers: &[Layer<'_>],
        frame: &Frame,
        settings: &Settings,
    ) -> Result<Option<Self>, SettingsError> {
        let Some(purge) = &settings.purge else { return Ok(None) };
        let Some(PrimeTower { left_mm, front_mm, width_mm, depth_mm }) = purge.tower else {
            return Ok(None);
        };
        let cell_mm = frame.cell_mm;
        let columns = (width_mm / cell_mm + SLACK).floor() - 2.0;
        let row_mm3 = columns * cell_mm * settings.process.bead_mm2(frame);
        let mut most = 0.0;
        let mut last_layer = None;
        let mut tool = None;
        for layer in layers {
            let mut rows = 0.0;
            for run in layer.runs() {
                let before = tool.replace(run.zone).unwrap_or(run.zone);
                let volume = purge.prime_tower_mm3(before, run.zone);
                if volume > 0.0 {
                    rows += rows_of(volume, row_mm3);
                    last_layer = Some(layer.number);
                }
            }
            most = f64::max(most, rows);
        }
        let Some(last_layer) = last_layer else { return Ok(None) };
        if columns < 1.0 {
            return Err(SettingsError::PrimeTowerWidth { width_mm, needed_mm: 3.0 * cell_mm });
        }
        let needed_mm = (most + 2.0) * cell_mm;
        if needed_mm > depth_mm * (1.0 + SLACK) {
            return Err(SettingsError::PrimeTowerDepth { depth_mm, needed_mm });
        }
        let (columns, rows) = (columns as i32, most as i32);
        Ok(Some(Self { left_mm, front_mm, cell_mm, columns, rows, last_layer, row_mm3 }))
    }

    /// How many rows a volume takes, in mm³.
    pub(super) fn rows_of(&self, volume_mm3: f64) -> i32 {
        rows_of(volume_mm3, self.row_mm3) as i32
    }

    /// The place of corners that are given in halves of a cell, in mm.
    pub(super) fn place(&self, corner: [i32; 2]) -> [f64; 2] {
        // The outline takes the first cell of either side.
        let along = |from: f64, halves: i32| from + (1.0 + f64::from(halves) / 2.0) * self.cell_mm;
        [along(self.left_mm, corner[0]), along(self.front_mm, corner[1])]
    }

    /// Once around it, from the front left corner.
    pub(super) fn outline(&self) -> [[i32; 2]; 5] {
        let (right, back) = (2 * self.columns + 1, 2 * self.rows + 1);
        [[-1, -1], [right, -1], [right, back], [-1, back], [-1, -1]]
    }

    /// Solid rows from `begin` on, back and forth.
    pub(super) fn solid(&self, begin: i32, rows: i32) -> Vec<[i32; 2]> {
        let columns = self.columns;
        let cells = (begin..begin + rows).flat_map(|row| {
            let leftwards = (row - begin) % 2 == 1;
            (0..columns)
                .map(move |column| [if leftwards { columns - 1 - column } else { column }, row])
        });
        corners(None, cells, None)
    }

    /// Sparse lines across the rows from `begin` to the last: one bead, back and forth.
    /// Empty if there are no such rows.
    pub(super) fn sparse(&self, begin: i32) -> Vec<[i32; 2]> {
        let (columns, end) = (self.columns, self.rows);
        if begin >= end {
            return Vec::new();
        }
        let cells =
            (0..columns).step_by(SPACING as usize).enumerate().flat_map(|(line, column)| {
                let inwards = line % 2 == 1;
                let across = (begin..end)
                    .map(move |row| [column, if inwards { begin + end - 1 - row } else { row }]);
                // To the next line along the row where this one ends, unless it is the last.
                let edge = if inwards { begin } else { end - 1 };
                let next = column + SPACING;
                let along = (column + 1..next)
                    .filter(move |_| next < columns)
                    .map(move |column| [column, edge]);
                across.chain(along)
            });
        corners(None, cells, None)
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> i32 {
        self.rows
    }
}

fn rows_of(volume_mm3: f64, row_mm3: f64) -> f64 {
    (volume_mm3 / row_mm3 - SLACK).ceil().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(columns: i32, rows: i32) -> PrimeTowerPlan {
        let (left_mm, front_mm, cell_mm, row_mm3) = (10.0, 20.0, 0.5, 1.0);
        PrimeTowerPlan { left_mm, front_mm, cell_mm, columns, rows, last_layer: 0, row_mm3 }
    }

    /// The cells a bead goes through, in halves of a cell, each as often as it has half a cell of
    /// it.
    fn halves(corners: &[[i32; 2]]) -> Vec<[i32; 2]> {
        let mut found = Vec::new();
        for pair in corners.windows(2) {
            let [dx, dy] = [(pair[1][0] - pair[0][0]).signum(), (pair[1][1] - pair[0][1]).signum()];
            assert!(dx == 0 || dy == 0, "askew");
            let mut at = pair[0];
            while at != pair[1] {
                // Between an edge and a middle, one of each coordinate is odd at one end.
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
    fn sparse_lines_bear_every_row() {
        for (columns, rows, begin) in [(1, 1, 0), (11, 6, 2), (23, 9, 8), (6, 4, 0), (5, 30, 7)] {
            let tower = plan(columns, rows);
            let mut found = halves(&tower.sparse(begin));
            found.sort_unstable();
            assert!(found.chunk_by(|a, b| a == b).all(|cell| cell.len() == 2), "each cell once");
            assert!(
                found.iter().all(|&[x, y]| (0..columns).contains(&x) && (begin..rows).contains(&y))
            );
            for row in begin..rows {
                let on_it: Vec<_> =
                    found.iter().filter(|cell| cell[1] == row).map(|cell| cell[0]).collect();
                assert!(
                    on_it.contains(&0) && on_it.windows(2).all(|pair| pair[1] - pair[0] <= SPACING)
                );
            }
        }
        assert!(plan(5, 5).sparse(5).is_empty());
    }

    #[test]
    fn places_and_volumes() {
        let tower = plan(4, 2);
        let outline = tower.outline().map(|corner| tower.place(corner));
        let near =
            |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9;
        assert!(near(outline[0], [10.25, 20.25]) && near(outline[2], [12.75, 21.75]));
        assert!(near(tower.place([0, 1]), [10.5, 20.75]));
        let rows = [0.0, 0.5, 1.0, 1.000_000_000_1, 1.1, 3.0].map(|volume| tower.rows_of(volume));
        assert_eq!(rows, [0, 1, 1, 1, 2, 3]);
    }
}
