//! A bead's way through the cells of a plane.

use beadwork_gcode::Motion;
use beadwork_part::Frame;

/// A shorter way in a cell, in mm, is the rounding of a place in a file, and no visit: and with it
/// so much of a cell's side.
const ROUNDING_MM: f64 = 0.002;
const ROUNDING: f64 = 0.02;

/// How far from a cell's centre a bead may pass that fills it, in sides of a cell: half a bead, and
/// what rounding takes.
const REACH: f64 = 0.5 + 0.005;

/// The time a bead spends in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Visit {
    /// Column, row and layer; less than 0 outside the plane.
    pub(super) place: [i64; 3],
    pub(super) seconds: f64,
    length_mm: f64,
    /// Least distance from the centre, in sides of a cell.
    distance: f64,
}

impl Visit {
    /// x, y and z, if they are such as a voxel can have.
    pub(super) fn voxel(&self) -> Option<[u32; 3]> {
        let [x, y, z] = self.place.map(|i| u32::try_from(i).ok());
        Some([x?, y?, z?])
    }
}

/// Cuts beads into visits.
/// A bead may be many motions; what they spend in a cell, one after the other, is one visit.
///
/// Where a bead only clips the corner of a cell, or begins or ends a rounding error beyond a side,
/// that is no visit: its time goes to a neighbour of the same bead.
#[derive(Debug)]
pub(super) struct Visits {
    frame: Frame,
    open: Option<Visit>,
    /// A complete visit that clips that follow may still lengthen.
    last: Option<Visit>,
    /// Time of clips before the first visit of a bead, s.
    early_s: f64,
}

impl Visits {
    pub(super) fn new(frame: Frame) -> Self {
        Self { frame, open: None, last: None, early_s: 0.0 }
    }

    /// Goes along a motion that extrudes; `seconds_to` tells how long it takes to get so many mm
    /// from its beginning.
    pub(super) fn bead(
        &mut self,
        motion: &Motion,
        seconds_to: impl Fn(f64) -> f64,
        told: &mut impl FnMut(&Visit),
    ) {
        let Frame { left_mm, back_mm, cell_mm, layer_mm, .. } = self.frame;
        // In cells, x right and y down.
        let place = |[x, y, _]: [f64; 3]| [(x - left_mm) / cell_mm, (back_mm - y) / cell_mm];
        let (from, to) = (place(motion.from_mm), place(motion.to_mm));
        let step = [to[0] - from[0], to[1] - from[1]];
        let length_mm = motion.length_mm();
        let layer =
            (f64::midpoint(motion.from_mm[2], motion.to_mm[2]) / layer_mm - 1.0).round() as i64;
        let mut before_s = 0.0;
        for part in crossed(from, step).windows(2) {
            let [begin, end] = [part[0], part[1]];
            let at = |share: f64| [0, 1].map(|axis| from[axis] + share * step[axis]);
            let cell = at(f64::midpoint(begin, end)).map(f64::floor);
            let after_s = seconds_to(end * length_mm);
            self.pass(
                Visit {
                    place: [cell[0] as i64, cell[1] as i64, layer],
                    seconds: after_s - before_s,
                    length_mm: (end - begin) * length_mm,
                    distance: distance(cell.map(|side| side + 0.5), at(begin), at(end)),
                },
                told,
            );
            before_s = after_s;
        }
    }

    /// The bead is over.
    pub(super) fn end(&mut self, told: &mut impl FnMut(&Visit)) {
        self.close(told);
        let rest_s = std::mem::take(&mut self.early_s);
        if let Some(last) = self.last.take() {
            told(&last);
        } else if rest_s > 0.0 {
            // Nothing but clips: the time must not be lost.
            told(&Visit {
                place: [-1; 3],
                seconds: rest_s,
                length_mm: 0.0,
                distance: f64::INFINITY,
            });
        }
    }

    fn pass(&mut self, part: Visit, told: &mut impl FnMut(&Visit)) {
        match &mut self.open {
            Some(open) if open.place == part.place => {
                open.seconds += part.seconds;
                open.length_mm += part.length_mm;
                open.distance = open.distance.min(part.distance);
            }
            _ => {
                self.close(told);
                self.open = Some(part);
            }
        }
    }

    fn close(&mut self, told: &mut impl FnMut(&Visit)) {
        let Some(mut open) = self.open.take() else { return };
        let least_mm = ROUNDING_MM + ROUNDING * self.frame.cell_mm;
        if open.length_mm > least_mm && open.distance <= REACH {
            open.seconds += std::mem::take(&mut self.early_s);
            if let Some(last) = self.last.replace(open) {
                told(&last);
            }
        } else if let Some(last) = &mut self.last {
            last.seconds += open.seconds;
        } else {
            self.early_s += open.seconds;
        }
    }
}

/// Where a way enters and leaves cells, as shares of it, rising from 0 to 1.
fn crossed(from: [f64; 2], step: [f64; 2]) -> Vec<f64> {
    let mut shares = vec![0.0];
    for axis in 0..2 {
        let (a, b) = (from[axis], from[axis] + step[axis]);
        let (low, high) = (a.min(b).floor() as i64 + 1, a.max(b).ceil() as i64);
        shares.extend((low..high).map(|side| ((side as f64 - a) / step[axis]).clamp(0.0, 1.0)));
    }
    shares.push(1.0);
    shares.sort_unstable_by(f64::total_cmp);
    shares.dedup();
    shares
}

/// From a point to a stretch of a straight line.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let [along, away] =
        [[to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]];
    let length2 = along[0] * along[0] + along[1] * along[1];
    let share = if length2 > 0.0 {
        ((along[0] * away[0] + along[1] * away[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(away[0] - share * along[0], away[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_cut_at_the_sides_of_cells() {
        assert_eq!(crossed([0.0, 0.5], [2.0, 0.0]), [0.0, 0.5, 1.0]);
        assert_eq!(crossed([2.0, 0.5], [-2.0, 0.0]), [0.0, 0.5, 1.0]);
        assert_eq!(crossed([0.5, 0.5], [0.0, 0.25]), [0.0, 1.0]);
        assert_eq!(crossed([0.5, 0.5], [2.0, 2.0]), [0.0, 0.25, 0.75, 1.0]);
        assert_eq!(crossed([-0.5, 0.25], [1.0, 1.0]), [0.0, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn distances_to_a_stretch() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(distance([0.5, 0.5], [0.0, 0.0], [1.0, 0.0]), 0.5);
        near(distance([2.0, 0.0], [0.0, 0.0], [1.0, 0.0]), 1.0);
        near(distance([2.0, 2.0], [1.0, 1.0], [1.0, 1.0]), 2.0_f64.sqrt());
    }
}
