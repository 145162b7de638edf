//! Fills outlines with cells: those whose centre lies within.

use super::outline::{FillRule, Outline};
use crate::frame::Frame;

/// Calls `fill` for each run of cells within: row, first column, column after the last.
///
/// A centre on a line belongs to the side right of it, or above it where the line is level: of two
/// bodies that touch, every cell lies in exactly one.
/// O(r log r) for r rows crossed by lines.
pub(super) fn each_run(
    outline: &Outline,
    rule: FillRule,
    frame: &Frame,
    mut fill: impl FnMut(u32, u32, u32),
) {
    // Rows counted from the front, y upwards; then from the back, as layers have them.
    let [_, front_mm, ..] = frame.sides_mm();
    let row_mm = |row: u32| front_mm + (f64::from(row) + 0.5) * frame.cell_mm;
    let first_row = |y: f64| first_centre(y, front_mm, frame.cell_mm, frame.height);
    let mut crossings: Vec<(u32, f64, i32)> = Vec::new();
    for (from, to, _) in outline.lines() {
        let (low, high, turn) = if from[1] <= to[1] { (from, to, 1) } else { (to, from, -1) };
        for row in first_row(low[1])..first_row(high[1]) {
            let part = (row_mm(row) - low[1]) / (high[1] - low[1]);
            crossings.push((row, low[0] + part * (high[0] - low[0]), turn));
        }
    }
    crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    for row in crossings.chunk_by(|a, b| a.0 == b.0) {
        let mut winding = 0;
        for pair in row.windows(2) {
            winding += pair[0].2;
            if rule.is_inside(winding) {
                let first = first_centre(pair[0].1, frame.left_mm, frame.cell_mm, frame.width);
                let end = first_centre(pair[1].1, frame.left_mm, frame.cell_mm, frame.width);
                if first < end {
                    fill(frame.height - 1 - pair[0].0, first, end);
                }
            }
        }
    }
}

/// The first cell of a line of `count` whose centre does not come before a place.
fn first_centre(place_mm: f64, origin_mm: f64, cell_mm: f64, count: u32) -> u32 {
    let cells = ((place_mm - origin_mm) / cell_mm - 0.5).ceil();
    cells.clamp(0.0, f64::from(count)) as u32
}
