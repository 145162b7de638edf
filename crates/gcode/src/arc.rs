//! Arcs as chords.

use std::f64::consts::TAU;

use crate::{Arc, Number};

/// How far a chord may lie from its arc, in mm: well below what a printer can place.
const DEVIATION_MM: f64 = 0.005;

/// The most chords of one arc, whatever its size, so that a broken program can't ask for endless
/// work.
const MOST_CHORDS: u32 = 720;

/// A smaller radius is no arc, in mm.
const SMALLEST_MM: f64 = 1e-6;

/// The chords of an arc: where each ends, and its share of the arc's length.
#[derive(Debug)]
pub(super) struct Chords {
    from: [f64; 3],
    to: [f64; 3],
    centre: [f64; 2],
    /// Angle at the beginning, and how far it turns from there; more than 0 against the clock.
    begin: f64,
    turn: f64,
    /// At the beginning and at the end: programs round both places, so that they differ a little.
    radii: [f64; 2],
    count: u32,
    done: u32,
}

impl Chords {
    /// `None` if there is no such arc.
    pub(super) fn new(from: [f64; 3], to: [f64; 3], arc: &Arc) -> Option<Self> {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let [i, j] = match (arc.i, arc.j, arc.r) {
            (None, None, None) => return None,
            (None, None, Some(radius)) => centre_of(dx, dy, radius.to_f64(), arc.clockwise)?,
            (i, j, _) => [i, j].map(|value| value.unwrap_or(Number::ZERO).to_f64()),
        };
        let radii = [i.hypot(j), (dx - i).hypot(dy - j)];
        if radii.iter().any(|&radius| radius < SMALLEST_MM) {
            return None;
        }
        let begin = (-j).atan2(-i);
        let end = (dy - j).atan2(dx - i);
        let turn = if dx == 0.0 && dy == 0.0 {
            // Back to its beginning: the whole circle.
            if arc.clockwise { -TAU } else { TAU }
        } else if arc.clockwise {
            -(begin - end).rem_euclid(TAU)
        } else {
            (end - begin).rem_euclid(TAU)
        };
        let widest = radii[0].max(radii[1]);
        let step = 2.0 * (1.0 - DEVIATION_MM / widest).max(0.0).acos();
        let count = (turn.abs() / step).ceil().clamp(1.0, f64::from(MOST_CHORDS)) as u32;
        let centre = [from[0] + i, from[1] + j];
        Some(Self { from, to, centre, begin, turn, radii, count, done: 0 })
    }

    pub(super) fn next(&mut self) -> Option<([f64; 3], f64)> {
        if self.done == self.count {
            return None;
        }
        self.done += 1;
        let share = 1.0 / f64::from(self.count);
        if self.done == self.count {
            return Some((self.to, share));
        }
        let part = f64::from(self.done) * share;
        let angle = self.begin + part * self.turn;
        let radius = self.radii[0] + part * (self.radii[1] - self.radii[0]);
        let place = [
            self.centre[0] + radius * angle.cos(),
            self.centre[1] + radius * angle.sin(),
            self.from[2] + part * (self.to[2] - self.from[2]),
        ];
        Some((place, share))
    }
}

/// The centre, seen from the beginning, of the arc of this radius to a place (dx, dy); the shorter
/// way round unless the radius is less than 0.
fn centre_of(dx: f64, dy: f64, radius: f64, clockwise: bool) -> Option<[f64; 2]> {
    let chord = dx.hypot(dy);
    let half = chord / 2.0;
    // Half a circle's radius may be rounded down.
    if chord == 0.0 || radius.abs() < half - DEVIATION_MM {
        return None;
    }
    let height = (radius * radius - half * half).max(0.0).sqrt();
    // The shorter way against the clock has its centre on the left.
    let height = if clockwise == (radius < 0.0) { height } else { -height };
    Some([dx / 2.0 - height * dy / chord, dy / 2.0 + height * dx / chord])
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
