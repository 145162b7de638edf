//! A bead that is not part of a program yet, as deposition events.

use beadwork_part::Frame;

use super::visit::{Visit, Visits};

/// A bead's path through one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathVisit {
    /// Column and row of the cell; `None` outside the grid.
    pub cell: Option<[u32; 2]>,
    /// Time in the cell, s.
    pub seconds: f64,
}

/// The cells that a bead visits, in the order in which it does, as
/// [`program_events`](super::program_events) finds them in a program; a cell may be visited more
/// than once.
///
/// The bead consists of straight lines, each with its ends in mm and its time in s, at a constant
/// speed.
/// The times of the visits add up to those of the lines.
/// Linear in the length of the bead in cells.
pub fn path_visits(
    lines: impl IntoIterator<Item = ([[f64; 2]; 2], f64)>,
    frame: &Frame,
) -> Vec<PathVisit> {
    let mut found = Vec::new();
    let mut visits = Visits::new(*frame);
    let is_inside = |&[x, y, _]: &[u32; 3]| x < frame.width && y < frame.height;
    let mut emit = |visit: &Visit| {
        let cell = visit.voxels().find(is_inside).map(|[x, y, _]| [x, y]);
        found.push(PathVisit { cell, seconds: visit.seconds });
    };
    for ([from, to], seconds) in lines {
        let length_mm = libm::hypot(to[0] - from[0], to[1] - from[1]);
        if length_mm > 0.0 {
            let seconds_to = |passed_mm: f64| seconds * passed_mm / length_mm;
            visits.add_line([from, to], length_mm, [0, 1], seconds_to, &mut emit);
        }
    }
    visits.end_bead(&mut emit);
    found
}
