//! Fills outlines with cells: scan-line conversion by winding number.
//!
//! Every row of cell centres is a scan line.
//! The lines of the outline that cross it are sorted by x, and a walk along the scan line adds up
//! their directions to the winding number between one crossing and the next; the fill rule says
//! whether those cells are inside.
//!
//! All intervals are half-open.
//! A line that goes up from y0 to y1 crosses the rows whose centres lie in [y0, y1), so where two
//! lines join, exactly one of them crosses the row, and a horizontal line crosses none.
//! Between crossings at x0 and x1 the cells are those whose centres lie in [x0, x1).

use super::outline::{FillRule, Outline};
use crate::frame::Frame;

/// Calls `fill` with each run of cells inside: row, first column, column after the last.
///
/// A cell centre exactly on a line belongs to what lies to the right of the line, or above it if
/// the line is horizontal; so of two bodies that touch, exactly one has the cell.
/// O(r log r), where r counts each row that each line crosses.
pub(super) fn for_each_run(
    outline: &Outline,
    rule: FillRule,
    frame: &Frame,
    mut fill: impl FnMut(u32, u32, u32),
) {
    // Here rows are counted from the front, in the direction of y; layers count from the back.
    let [_, front_mm, ..] = frame.sides_mm();
    let row_mm = |row: u32| front_mm + (f64::from(row) + 0.5) * frame.cell_mm;
    let first_row = |y: f64| first_centre(y, front_mm, frame.cell_mm, frame.height);
    // Row, x, and the change of the winding number when passed from left to right.
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

/// The first of `count` cells from the origin whose centre is at or beyond a position.
fn first_centre(position_mm: f64, origin_mm: f64, cell_mm: f64, count: u32) -> u32 {
    let cells = ((position_mm - origin_mm) / cell_mm - 0.5).ceil();
    cells.clamp(0.0, f64::from(count)) as u32
}
