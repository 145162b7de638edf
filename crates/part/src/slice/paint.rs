//! Materials of a body whose surface is painted: every cell takes that of the nearest line of the
//! outline, counted in steps from cell to cell.

use std::collections::VecDeque;
use std::ops::Range;

use super::outline::{FillRule, Outline};
use super::raster::each_run;
use crate::frame::Frame;

/// Numbers for the cells that lie within; others are left as they are.
///
/// Cells along the outline take the number of the line that passes nearest to their centre, and
/// pass it on inwards in widening rings.
/// What no line comes near takes the first number of the outline.
/// Linear in the outline's length and in the cells of the smallest rectangle around it: there may
/// be many small bodies on a large plane.
pub(super) fn spread(outline: &Outline, rule: FillRule, frame: &Frame, materials: &mut [u8]) {
    let Some((columns, rows)) = rectangle(outline, frame) else { return };
    let width = columns.len();
    let mut inside = vec![false; width * rows.len()];
    each_run(outline, rule, frame, |row, first, end| {
        let row = (row as usize - rows.start) * width;
        inside[row + first as usize - columns.start..row + end as usize - columns.start].fill(true);
    });
    let of_plane = |cell: usize| {
        (rows.start + cell / width) * frame.width as usize + columns.start + cell % width
    };
    let mut numbers = vec![0; inside.len()];
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
                if !(columns.start as f64..columns.end as f64).contains(&column)
                    || !(rows.start as f64..rows.end as f64).contains(&row)
                {
                    continue;
                }
                let cell = (row as usize - rows.start) * width + column as usize - columns.start;
                let centre = frame.centre(column as u32, row as u32);
                let distance = (centre[0] - at[0]).hypot(centre[1] - at[1]);
                if inside[cell] && distance < nearest[cell] {
                    nearest[cell] = distance;
                    numbers[cell] = paint;
                }
            }
        }
    }
    let mut queue: VecDeque<usize> =
        (0..inside.len()).filter(|&cell| nearest[cell].is_finite()).collect();
    while let Some(cell) = queue.pop_front() {
        let x = cell % width;
        let right = (x + 1 < width).then_some(cell + 1);
        let left = (x > 0).then(|| cell - 1);
        let below = (cell + width < inside.len()).then_some(cell + width);
        let above = cell.checked_sub(width);
        for other in [right, below, left, above].into_iter().flatten() {
            if inside[other] && nearest[other].is_infinite() {
                nearest[other] = f64::MAX;
                numbers[other] = numbers[cell];
                queue.push_back(other);
            }
        }
    }
    for cell in (0..inside.len()).filter(|&cell| inside[cell] && nearest[cell].is_infinite()) {
        numbers[cell] = first.unwrap_or_default();
    }
    for cell in (0..inside.len()).filter(|&cell| inside[cell]) {
        materials[of_plane(cell)] = numbers[cell];
    }
}

/// The columns and rows that an outline reaches, and one more on every side, for places are
/// rounded.
fn rectangle(outline: &Outline, frame: &Frame) -> Option<(Range<usize>, Range<usize>)> {
    let mut least = [f64::INFINITY; 2];
    let mut greatest = [f64::NEG_INFINITY; 2];
    for &[x, y] in outline.loops().flatten() {
        let place = [x - frame.left_mm, frame.back_mm - y].map(|way| (way / frame.cell_mm).floor());
        least = [0, 1].map(|axis| place[axis].min(least[axis]));
        greatest = [0, 1].map(|axis| place[axis].max(greatest[axis]));
    }
    let range = |axis: usize, count: u32| {
        let bound = |place: f64| place.clamp(0.0, f64::from(count)) as usize;
        bound(least[axis] - 1.0)..bound(greatest[axis] + 2.0)
    };
    let (columns, rows) = (range(0, frame.width), range(1, frame.height));
    (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
}
