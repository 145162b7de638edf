//! The path of a bead through the cells of a layer.

use beadwork_gcode::Motion;
use beadwork_part::Frame;

/// Minimum length of a visit: a path through a cell counts as a visit only if it is longer than
/// `ROUNDING_MM` + `ROUNDING` times the cell's side.
/// Coordinates in files are rounded, so a motion may end a little beyond the side of a cell.
const ROUNDING_MM: f64 = 0.002;
const ROUNDING: f64 = 0.02;

/// Largest distance from a cell's centre at which a bead still fills the cell, in sides of a cell:
/// half a bead, and some tolerance for rounded coordinates.
const REACH: f64 = 0.5 + 0.005;

/// A bead's path through one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Visit {
    /// Column and row; negative outside the grid.
    position: [i64; 2],
    /// First layer of voxels, and the one after the last; negative below the grid.
    layers: [i64; 2],
    /// Time in the cell, s.
    pub(super) seconds: f64,
    length_mm: f64,
    /// Minimum distance from the cell's centre, in sides of a cell.
    distance: f64,
}

impl Visit {
    /// x, y and z of the voxels, from the bed up, if x and y are not negative.
    pub(super) fn voxels(&self) -> impl Iterator<Item = [u32; 3]> {
        let [x, y] = self.position.map(|i| u32::try_from(i).ok());
        let [first, end] = self.layers.map(|z| u32::try_from(z.max(0)).unwrap_or(u32::MAX));
        (first..end).filter_map(move |z| Some([x?, y?, z]))
    }
}

/// Cuts beads into visits.
///
/// A bead may consist of many motions; consecutive ones in the same cell are one visit.
/// A bead that only clips the corner of a cell, or starts or ends a rounding error beyond a side,
/// does not visit that cell: the time it spends there is added to the visit before or after it, so
/// that the times of all visits add up to that of the bead.
#[derive(Debug)]
pub(super) struct Visits {
    frame: Frame,
    /// The visit of the cell in which the bead ends so far.
    current: Option<Visit>,
    /// The complete visit before it, which clips that follow may still lengthen.
    previous: Option<Visit>,
    /// Time of clips before the first visit of the bead, s.
    early_s: f64,
}

impl Visits {
    pub(super) fn new(frame: Frame) -> Self {
        Self { frame, current: None, previous: None, early_s: 0.0 }
    }

    /// Adds a motion that extrudes within some layers of voxels, and calls `emit` for each visit
    /// that is complete.
    /// `seconds_to` is the time from the motion's start to a point at the given distance from it,
    /// in mm.
    pub(super) fn add_bead(
        &mut self,
        motion: &Motion,
        layers: [i64; 2],
        seconds_to: impl Fn(f64) -> f64,
        emit: &mut impl FnMut(&Visit),
    ) {
        let [from_mm, to_mm] = [motion.from_mm, motion.to_mm].map(|[x, y, _]| [x, y]);
        self.add_line([from_mm, to_mm], motion.length_mm(), layers, seconds_to, emit);
    }

    /// As [`Visits::add_bead`], for a line in x and y whose length may have a part along z.
    pub(super) fn add_line(
        &mut self,
        [from_mm, to_mm]: [[f64; 2]; 2],
        length_mm: f64,
        layers: [i64; 2],
        seconds_to: impl Fn(f64) -> f64,
        emit: &mut impl FnMut(&Visit),
    ) {
        let Frame { left_mm, back_mm, cell_mm, width, height, .. } = self.frame;
        // In cells, x right and y down.
        let to_cells = |[x, y]: [f64; 2]| [(x - left_mm) / cell_mm, (back_mm - y) / cell_mm];
        let (from, to) = (to_cells(from_mm), to_cells(to_mm));
        let step = [to[0] - from[0], to[1] - from[1]];
        let mut before_s = 0.0;
        for ends in crossings(from, step, [width, height]).windows(2) {
            let [begin, end] = [ends[0], ends[1]];
            let at = |fraction: f64| [0, 1].map(|axis| from[axis] + fraction * step[axis]);
            let cell = at(f64::midpoint(begin, end)).map(f64::floor);
            let after_s = seconds_to(end * length_mm);
            self.pass(
                Visit {
                    position: [cell[0] as i64, cell[1] as i64],
                    layers,
                    seconds: after_s - before_s,
                    length_mm: (end - begin) * length_mm,
                    distance: distance(cell.map(|side| side + 0.5), at(begin), at(end)),
                },
                emit,
            );
            before_s = after_s;
        }
    }

    /// Ends the bead.
    pub(super) fn end_bead(&mut self, emit: &mut impl FnMut(&Visit)) {
        self.close(emit);
        let rest_s = std::mem::take(&mut self.early_s);
        if let Some(previous) = self.previous.take() {
            emit(&previous);
        } else if rest_s > 0.0 {
            // The bead only clips cells: a visit outside the grid keeps its time.
            emit(&Visit {
                position: [-1; 2],
                layers: [-1; 2],
                seconds: rest_s,
                length_mm: 0.0,
                distance: f64::INFINITY,
            });
        }
    }

    fn pass(&mut self, part: Visit, emit: &mut impl FnMut(&Visit)) {
        match &mut self.current {
            Some(current) if (current.position, current.layers) == (part.position, part.layers) => {
                current.seconds += part.seconds;
                current.length_mm += part.length_mm;
                current.distance = current.distance.min(part.distance);
            }
            _ => {
                self.close(emit);
                self.current = Some(part);
            }
        }
    }

    /// Completes the current visit, or adds its time to another one if it is only a clip.
    fn close(&mut self, emit: &mut impl FnMut(&Visit)) {
        let Some(mut current) = self.current.take() else { return };
        let min_mm = ROUNDING_MM + ROUNDING * self.frame.cell_mm;
        if current.length_mm > min_mm && current.distance <= REACH {
            current.seconds += std::mem::take(&mut self.early_s);
            if let Some(previous) = self.previous.replace(current) {
                emit(&previous);
            }
        } else if let Some(previous) = &mut self.previous {
            previous.seconds += current.seconds;
        } else {
            self.early_s += current.seconds;
        }
    }
}

/// Where a straight motion crosses sides of cells, as fractions of its length: rising from 0 to 1,
/// both included.
///
/// Sides more than a cell beyond the grid do not count: they are at no voxel, and a motion of
/// thousands of kilometres would have too many of them.
fn crossings(from: [f64; 2], step: [f64; 2], grid: [u32; 2]) -> Vec<f64> {
    let mut fractions = vec![0.0];
    for axis in 0..2 {
        let (a, b) = (from[axis], from[axis] + step[axis]);
        let low = (a.min(b).floor() as i64).saturating_add(1).max(-1);
        let high = (a.max(b).ceil() as i64).min(i64::from(grid[axis]) + 2);
        fractions.extend((low..high).map(|side| ((side as f64 - a) / step[axis]).clamp(0.0, 1.0)));
    }
    fractions.push(1.0);
    fractions.sort_unstable_by(f64::total_cmp);
    fractions.dedup();
    fractions
}

/// Distance of a point from a line segment.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let [along, away] =
        [[to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]];
    let length2 = along[0] * along[0] + along[1] * along[1];
    let fraction = if length2 > 0.0 {
        ((along[0] * away[0] + along[1] * away[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(away[0] - fraction * along[0], away[1] - fraction * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: [u32; 2] = [10, 10];

    #[test]
    fn motions_are_cut_at_the_sides_of_cells() {
        assert_eq!(crossings([0.0, 0.5], [2.0, 0.0], GRID), [0.0, 0.5, 1.0]);
        assert_eq!(crossings([2.0, 0.5], [-2.0, 0.0], GRID), [0.0, 0.5, 1.0]);
        assert_eq!(crossings([0.5, 0.5], [0.0, 0.25], GRID), [0.0, 1.0]);
        assert_eq!(crossings([0.5, 0.5], [2.0, 2.0], GRID), [0.0, 0.25, 0.75, 1.0]);
        assert_eq!(crossings([-0.5, 0.25], [1.0, 1.0], GRID), [0.0, 0.5, 0.75, 1.0]);
        let far = crossings([0.5, 0.5], [1e13, -1e13], GRID);
        assert!(far.len() < 20 && far.is_sorted(), "{far:?}");
        assert_eq!(crossings([100.5, 0.5], [5.0, 0.0], GRID), [0.0, 1.0]);
    }

    #[test]
    fn distances_to_a_segment() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(distance([0.5, 0.5], [0.0, 0.0], [1.0, 0.0]), 0.5);
        near(distance([2.0, 0.0], [0.0, 0.0], [1.0, 0.0]), 1.0);
        near(distance([2.0, 2.0], [1.0, 1.0], [1.0, 1.0]), 2.0_f64.sqrt());
    }
}
