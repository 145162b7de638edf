//! Approximates arcs by chords.
//!
//! A chord that spans the angle θ of a circle of radius r is at most r (1 - cos(θ/2)) away from the
//! arc, in its middle (the sagitta).
//! Setting this to the permitted deviation d gives the widest angle, θ = 2 acos(1 - d/r), and so
//! the number of chords.

use std::f64::consts::TAU;

use crate::command::Arc;
use crate::number::Number;

/// Maximum distance between a chord and its arc, in mm: well below the precision of a printer.
const MAX_DEVIATION_MM: f64 = 0.005;

/// Maximum number of chords per arc, whatever its size, so that a malformed program cannot cause
/// unbounded work.
/// A full circle of radius 525 mm or less stays within it.
const MAX_CHORDS: u32 = 720;

/// A circle with a smaller radius is treated as a malformed arc, in mm.
const MIN_RADIUS_MM: f64 = 1e-6;

/// The chords of an arc.
#[derive(Debug)]
pub(crate) struct Chords {
    from: [f64; 3],
    to: [f64; 3],
    centre: [f64; 2],
    /// Angle of the start as seen from the centre, in radians.
    start_angle: f64,
    /// Angle that the arc spans, in radians; positive if counter-clockwise.
    span: f64,
    /// Distances of start and end from the centre.
    /// They differ a little because programs round the ends and the centre; the chords interpolate
    /// between the two.
    radii: [f64; 2],
    count: u32,
    done: u32,
}

impl Chords {
    /// Creates the chords of an arc between two points; `None` if no such arc exists.
    pub(crate) fn new(from: [f64; 3], to: [f64; 3], arc: &Arc) -> Option<Self> {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let [i, j] = match (arc.i, arc.j, arc.r) {
            (None, None, None) => return None,
            (None, None, Some(radius)) => centre_of(dx, dy, radius.to_f64(), arc.clockwise)?,
            (i, j, _) => [i, j].map(|value| value.unwrap_or(Number::ZERO).to_f64()),
        };
        let radii = [i.hypot(j), (dx - i).hypot(dy - j)];
        if radii.iter().any(|&radius| radius < MIN_RADIUS_MM) {
            return None;
        }
        let start_angle = (-j).atan2(-i);
        let end_angle = (dy - j).atan2(dx - i);
        let span = if dx == 0.0 && dy == 0.0 {
            // An arc that ends where it starts is a full circle.
            if arc.clockwise { -TAU } else { TAU }
        } else if arc.clockwise {
            -(start_angle - end_angle).rem_euclid(TAU)
        } else {
            (end_angle - start_angle).rem_euclid(TAU)
        };
        let max_radius = radii[0].max(radii[1]);
        let max_step = 2.0 * (1.0 - MAX_DEVIATION_MM / max_radius).max(0.0).acos();
        let count = (span.abs() / max_step).ceil().clamp(1.0, f64::from(MAX_CHORDS)) as u32;
        let centre = [from[0] + i, from[1] + j];
        Some(Self { from, to, centre, start_angle, span, radii, count, done: 0 })
    }

    /// The end of the next chord, and its share of the arc's length and filament.
    pub(crate) fn next(&mut self) -> Option<([f64; 3], f64)> {
        if self.done == self.count {
            return None;
        }
        self.done += 1;
        let share = 1.0 / f64::from(self.count);
        if self.done == self.count {
            // Exactly the end that the program asks for, without rounding.
            return Some((self.to, share));
        }
        let part = f64::from(self.done) * share;
        let angle = self.start_angle + part * self.span;
        let radius = self.radii[0] + part * (self.radii[1] - self.radii[0]);
        let end = [
            self.centre[0] + radius * angle.cos(),
            self.centre[1] + radius * angle.sin(),
            self.from[2] + part * (self.to[2] - self.from[2]),
        ];
        Some((end, share))
    }
}

/// The centre, relative to the start, of an arc of the given radius that ends at (dx, dy).
/// A negative radius selects the longer of the two arcs.
///
/// The centre lies on the perpendicular bisector of the straight line between the ends, at a height
/// h above its midpoint with h² + (length/2)² = radius².
fn centre_of(dx: f64, dy: f64, radius: f64, clockwise: bool) -> Option<[f64; 2]> {
    let length = dx.hypot(dy);
    let half = length / 2.0;
    // The radius of a half circle may have been rounded down by the slicer.
    if length == 0.0 || radius.abs() < half - MAX_DEVIATION_MM {
        return None;
    }
    let height = (radius * radius - half * half).max(0.0).sqrt();
    // A shorter, counter-clockwise arc has its centre on the left of the line from start to end.
    let height = if clockwise == (radius < 0.0) { height } else { -height };
    Some([dx / 2.0 - height * dy / length, dy / 2.0 + height * dx / length])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chords(to: [f64; 2], arc: &Arc) -> Option<Vec<[f64; 3]>> {
        let mut chords = Chords::new([1.0, 2.0, 0.0], [1.0 + to[0], 2.0 + to[1], 3.0], arc)?;
        let (places, shares): (Vec<_>, Vec<_>) = std::iter::from_fn(|| chords.next()).unzip();
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        Some(places)
    }

    fn length(places: &[[f64; 3]]) -> f64 {
        let mut from = [1.0, 2.0, 0.0];
        let each = places.iter().map(|&to| {
            let from = std::mem::replace(&mut from, to);
            (to[0] - from[0]).hypot(to[1] - from[1])
        });
        each.sum()
    }

    fn by_radius(radius: i32, clockwise: bool) -> Arc {
        Arc { r: Some(Number::whole(radius)), clockwise, ..Arc::default() }
    }

    fn by_centre(i: i32, j: i32, clockwise: bool) -> Arc {
        Arc { i: Some(Number::whole(i)), j: Some(Number::whole(j)), clockwise, ..Arc::default() }
    }

    #[test]
    fn lengths_and_sides() {
        let quarter = TAU * 10.0 / 4.0;
        for (arc, expected, side) in [
            (by_radius(10, false), quarter, 1.0),
            (by_radius(10, true), quarter, -1.0),
            (by_radius(-10, false), 3.0 * quarter, 1.0),
            (by_radius(-10, true), 3.0 * quarter, -1.0),
            (by_centre(0, 10, false), quarter, 1.0),
            (by_centre(10, 0, true), quarter, -1.0),
            (by_centre(10, 0, false), 3.0 * quarter, 1.0),
        ] {
            let places = chords([10.0, 10.0], &arc).unwrap();
            assert!((length(&places) / expected - 1.0).abs() < 1e-3, "{arc:?}");
            assert_eq!(places.last(), Some(&[11.0, 12.0, 3.0]));
            // Against the clock, an arc bulges to the right of its chord.
            let [x, y, _] = places[places.len() / 2];
            assert!(side * ((x - 1.0) - (y - 2.0)) > 0.0, "{arc:?}");
        }
        let circle = chords([0.0, 0.0], &by_centre(5, 0, true)).unwrap();
        assert!((length(&circle) / (5.0 * TAU) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn impossible_arcs_and_endless_ones() {
        assert_eq!(chords([1.0, 0.0], &Arc::default()), None);
        assert_eq!(chords([1.0, 0.0], &by_centre(0, 0, true)), None);
        assert_eq!(chords([1.0, 0.0], &by_centre(1, 0, true)), None, "the centre is its end");
        assert_eq!(chords([0.0, 0.0], &by_radius(5, true)), None);
        assert_eq!(chords([30.0, 0.0], &by_radius(5, true)), None);
        assert_eq!(chords([0.0, 0.0], &by_centre(1_000_000_000, 0, true)).unwrap().len(), 720);
    }
}
