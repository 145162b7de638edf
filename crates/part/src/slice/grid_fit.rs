//! Fits the cell grid around a part.

use beadwork_grid::Region;
use beadwork_mesh::Bounds;

use super::settings::{Settings, SliceError};
use crate::frame::Frame;

/// Memory of a layer besides its cells, counted in cells.
const MIN_LAYER_CELLS: f64 = 64.0;

/// Length, in cells, by which a part may be longer than a whole number of cells without getting one
/// more: one per cent of a bead.
///
/// Otherwise the noise of coordinates would add a row of cells.
/// In float32, the format of STL files, coordinates of 1,000 mm are multiples of 0.00006 mm; text
/// files often have six digits, 0.001 mm at that size.
const TOLERANCE: f64 = 0.01;

/// The frame of all layers of a part that stands on z = 0, and their number.
pub(super) fn fit(bounds: &Bounds, settings: &Settings) -> Result<(Frame, usize), SliceError> {
    let &Settings { cell_mm, layer_mm, phase, colour_depth_mm, max_cells, .. } = settings;
    for (what, value) in [("the bead width", cell_mm), ("the layer height", layer_mm)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(SliceError::Length { what, value });
        }
    }
    if colour_depth_mm.is_nan() || colour_depth_mm < 0.0 {
        return Err(SliceError::ColourDepth(colour_depth_mm));
    }
    for (axis, value) in ["x", "y"].into_iter().zip(phase) {
        if !(0.0..1.0).contains(&value) {
            return Err(SliceError::Phase { axis, value });
        }
    }
    let size = bounds.size_mm();
    if !size.iter().all(|&side| side > 0.0) {
        return Err(SliceError::NoCells { cell_mm, layer_mm, has_negative: false });
    }
    let [columns, rows] = [0, 1].map(|axis| GridAxis::fit(size[axis], cell_mm, phase[axis]));
    let (width, height) = (columns.count, rows.count);
    if width.max(height) > f64::from(Region::MAX_SIDE) {
        return Err(SliceError::Side { cell_mm, width, height });
    }
    // A layer exists if its centre height lies within the part.
    let layers = (bounds.max[2] / layer_mm - 0.5).ceil().max(0.0);
    if layers * (width * height).max(MIN_LAYER_CELLS) > max_cells as f64 {
        return Err(SliceError::Cells {
            layers,
            width: width as u32,
            height: height as u32,
            max: max_cells,
        });
    }
    let frame = Frame {
        left_mm: bounds.min[0] - columns.before_mm,
        back_mm: bounds.max[1] + rows.after_mm,
        cell_mm,
        layer_mm,
        width: width as u32,
        height: height as u32,
    };
    Ok((frame, layers as usize))
}

/// The cells of the grid along one axis.
struct GridAxis {
    /// Number of cells; a whole number, as a float because it is not yet known to be small.
    count: f64,
    /// How far the grid extends beyond the part at the low end of the axis, in mm.
    before_mm: f64,
    /// The same at the high end.
    after_mm: f64,
}

impl GridAxis {
    fn fit(size_mm: f64, cell_mm: f64, phase: f64) -> Self {
        let count = (size_mm / cell_mm - TOLERANCE).ceil().max(1.0);
        let margin_mm = (count * cell_mm - size_mm) / 2.0;
        let mut fitted = Self { count, before_mm: margin_mm, after_mm: margin_mm };
        if phase > 0.0 {
            fitted.shift(phase, cell_mm);
        }
        fitted
    }

    /// Moves the grid towards the high end by a fraction of a cell, and keeps it the smallest grid
    /// with these cell borders that holds the part.
    fn shift(&mut self, phase: f64, cell_mm: f64) {
        self.before_mm -= phase * cell_mm;
        self.after_mm += phase * cell_mm;
        if self.before_mm < -TOLERANCE / 2.0 * cell_mm {
            // The low end of the part is uncovered.
            self.before_mm += cell_mm;
            self.count += 1.0;
        }
        if self.after_mm > (1.0 - TOLERANCE / 2.0) * cell_mm && self.count > 1.0 {
            // The last cell lies entirely beyond the part.
            self.after_mm -= cell_mm;
            self.count -= 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifted_grids_are_the_smallest_that_hold_the_part() {
        for size_mm in [0.2, 0.5, 2.0, 2.001, 2.1, 2.45, 10.0] {
            let at_zero = GridAxis::fit(size_mm, 0.5, 0.0);
            for phase in [0.0, 0.01, 0.1, 0.25, 0.5, 0.75, 0.99] {
                let GridAxis { count, before_mm, after_mm } = GridAxis::fit(size_mm, 0.5, phase);
                let length_mm = before_mm + size_mm + after_mm;
                assert!((length_mm - 0.5 * count).abs() < 1e-9, "{size_mm} mm at {phase}");
                assert!(before_mm > -0.005 && after_mm > -0.005, "{size_mm} mm at {phase}");
                assert!(before_mm < 0.5 && after_mm < 0.5, "{size_mm} mm at {phase}");
                let moved_cells = (at_zero.before_mm - before_mm) / 0.5;
                let rest = (moved_cells - phase).rem_euclid(1.0);
                assert!(rest.min(1.0 - rest) < 1e-9, "{size_mm} mm at {phase}");
            }
        }
    }
}
