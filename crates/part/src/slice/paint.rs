//! Materials of a body whose surface is painted: every cell takes that of the nearest line of the outline, counted in steps from cell to cell.

use std::collections::VecDeque;

use super::outline::Outline;
use crate::frame::Frame;

/// Numbers for the cells for which `inside` holds, row by row; others are left as they are.
///
/// Cells along the outline take the number of the line that passes nearest to their centre, and pass it on inwards in widening rings. What no line comes
/// near takes the first number of the outline. Linear in the cells and in the outline's length.
pub(super) fn spread(outline: &Outline, frame: &Frame, inside: &[bool], materials: &mut [u8]) {
    let width = frame.width as usize;
    let mut nearest = vec![f64::INFINITY; inside.len()];
    let mut first = None;
    for (from, to, paint) in outline.lines() {
        let Some(paint) = paint else { continue };
        first = first.or(Some(paint));
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        // Twice a cell, so that none is stepped over.
        let steps = (2.0 * length / frame.cell_mm).ceil().max(1.0);
        for step in 0..=steps as u32 {
            let part = f64::from(step) / steps;
            let at = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
            let column = ((at[0] - frame.left_mm) / frame.cell_mm).floor();
            let row = ((frame.back_mm - at[1]) / frame.cell_mm).floor();
            // The cell whose centre is inside may lie beside the one that the line passes through.
            for (column, row) in [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
                .map(|(right, down)| (column + right, row + down))
            {
                if !(0.0..f64::from(frame.width)).contains(&column)
                    || !(0.0..f64::from(frame.height)).contains(&row)
                {
                    continue;
                }
                let cell = row as usize * width + column as usize;
                let centre = frame.centre(column as u32, row as u32);
                let distance = (centre[0] - at[0]).hypot(centre[1] - at[1]);
                if inside[cell] && distance < nearest[cell] {
                    nearest[cell] = distance;
                    materials[cell] = paint;
                }
            }
        }
    }
    let mut queue: VecDeque<usize> = (0..inside.len()).filter(|&cell| nearest[cell].is_finite()).collect();
    while let Some(cell) = queue.pop_front() {
        let x = cell % width;
        let right = (x + 1 < width).then_some(cell + 1);
        let left = (x > 0).then(|| cell - 1);
        let below = (cell + width < inside.len()).then_some(cell + width);
        let above = cell.checked_sub(width);
        for other in [right, below, left, above].into_iter().flatten() {
            if inside[other] && nearest[other].is_infinite() {
                nearest[other] = f64::MAX;
                materials[other] = materials[cell];
                queue.push_back(other);
            }
        }
    }
    for cell in (0..inside.len()).filter(|&cell| inside[cell] && nearest[cell].is_infinite()) {
        materials[cell] = first.unwrap_or_default();
    }
}
