//! Position of the cells on the printer's bed.

/// Position and size of the cell grid that all layers of a part share, in the printer's
/// coordinates: x to the right, y to the back, z up, in mm.
///
/// Row 0 lies at the back, so that a layer drawn row by row looks as it does from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// x of the left side of column 0 in mm.
    pub left_mm: f64,
    /// y of the back side of row 0 in mm: the maximum y of the grid.
    pub back_mm: f64,
    /// Side of a cell in mm, which is the width of a bead.
    /// More than 0.
    pub cell_mm: f64,
    /// Height of a layer in mm.
    /// More than 0.
    pub layer_mm: f64,
    /// Width of the grid in cells.
    pub width: u32,
    /// Height of the grid in cells.
    pub height: u32,
}

impl Frame {
    /// Centre of the cell in column `x` and row `y`: x and y in mm.
    pub fn centre(&self, x: u32, y: u32) -> [f64; 2] {
        let offset = |count: u32| (f64::from(count) + 0.5) * self.cell_mm;
        [self.left_mm + offset(x), self.back_mm - offset(y)]
    }

    /// Column and row of the cell at a point, in mm; whole numbers that may lie beyond the grid.
    pub(crate) fn column_and_row(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x - self.left_mm, self.back_mm - y].map(|mm| (mm / self.cell_mm).floor())
    }

    /// Sides of the grid in mm: left, front, right and back.
    pub fn sides_mm(&self) -> [f64; 4] {
        let length = |count: u32| f64::from(count) * self.cell_mm;
        [
            self.left_mm,
            self.back_mm - length(self.height),
            self.left_mm + length(self.width),
            self.back_mm,
        ]
    }

    /// Top of a layer in mm, where layers are numbered from 0: z of the nozzle while it is printed.
    pub fn top_mm(&self, layer: usize) -> f64 {
        (layer + 1) as f64 * self.layer_mm
    }

    /// Volume of a cell in mm³.
    pub fn cell_mm3(&self) -> f64 {
        self.cell_mm * self.cell_mm * self.layer_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "halves and quarters are exact")]
    fn rows_run_from_the_back_to_the_front() {
        let frame = Frame {
            left_mm: 10.0,
            back_mm: 20.0,
            cell_mm: 0.5,
            layer_mm: 0.25,
            width: 4,
            height: 4,
        };
        assert_eq!(frame.centre(0, 0), [10.25, 19.75]);
        assert_eq!(frame.centre(3, 1), [11.75, 19.25]);
        assert_eq!(frame.sides_mm(), [10.0, 18.0, 12.0, 20.0]);
        assert_eq!((frame.top_mm(0), frame.top_mm(3)), (0.25, 1.0));
    }
}
