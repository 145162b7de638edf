//! Honeycombs made of zigzag lines.

use super::scan_lines::Family;
use crate::area::{Area, Ring};

/// Zigzag lines that make a honeycomb within an area.
///
/// Each line consists of sides along its direction and sides at 60 degrees to either side of it.
/// Where two lines run along a wall of the honeycomb, they lie side by side, a bead apart.
/// `along` is the unit vector in the direction of the lines, `density` more than 0 and below 1. O(n
/// log n), where n counts each line that each edge of the border crosses, and each corner.
pub(super) fn honeycomb(
    area: &Area,
    along: [f64; 2],
    bead_mm: f64,
    density: f64,
) -> Vec<Vec<[f64; 2]>> {
    let turn = |[x, y]: [f64; 2]| [along[0] * x + along[1] * y, along[0] * y - along[1] * x];
    let back = |[u, v]: [f64; 2]| [along[0] * u - along[1] * v, along[1] * u + along[0] * v];
    let rings: Vec<Ring> =
        area.rings().map(|ring| ring.iter().map(|&p| turn(p)).collect()).collect();
    let zigzag = Zigzag::new(bead_mm, density);
    // Every other line is the mirror image.
    let mut lines = zigzag.clip(&rings, 0.0);
    lines.extend(Zigzag { rise: -zigzag.rise, ..zigzag }.clip(&rings, zigzag.pitch));
    lines.iter_mut().flatten().for_each(|point| *point = back(*point));
    lines
}

/// A line along the u axis that rises and falls: v is a function of u.
///
/// Lengths are in mm.
/// With v less this function in place of v, zigzag lines are straight, so that they can be clipped
/// like these.
struct Zigzag {
    /// Half the length of a side.
    half_side: f64,
    /// From the low to the high sides.
    rise: f64,
    /// From a line to the next, which is mirrored.
    pitch: f64,
}

impl Zigzag {
    fn new(bead_mm: f64, density: f64) -> Self {
        // A period of a line has two straight sides and two slanted ones, each of length a; it
        // takes 3 a along the line, and a sqrt(3) / 2 and a bead across it.
        // So the density is 4 a bead / (3 a (a sqrt(3) / 2 + bead)).
        let rise = bead_mm * (4.0 / (3.0 * density) - 1.0);
        Self { half_side: rise / 3.0_f64.sqrt(), rise, pitch: rise + bead_mm }
    }

    /// v at u, where u counts halves of a side: it is high from 0 to 2, low from 3 to 5.
    fn v(&self, halves: f64) -> f64 {
        let at = halves.rem_euclid(6.0);
        let part = if at < 3.0 { (at - 2.0).max(0.0) } else { 1.0 - (at - 5.0).max(0.0) };
        self.rise * (0.5 - part)
    }

    /// The corners between two positions, which count halves of a side, from low to high.
    fn corners(&self, from: f64, to: f64) -> impl DoubleEndedIterator<Item = [f64; 2]> {
        let halves = from.ceil() as i64..=to.floor() as i64;
        halves
            .filter(|halves| matches!(halves.rem_euclid(6), 0 | 2 | 3 | 5))
            .map(|halves| [halves as f64 * self.half_side, self.v(halves as f64)])
    }

    /// Every other line within rings, beginning with one that is shifted across; in u and v.
    fn clip(&self, rings: &[Ring], shift_mm: f64) -> Vec<Vec<[f64; 2]>> {
        let halves = |point: [f64; 2]| point[0] / self.half_side;
        let straight = |[u, v]: [f64; 2]| [u, v - self.v(u / self.half_side)];
        let straighten = |ring: &Ring| -> Ring {
            let mut straightened = Ring::new();
            for (&from, &to) in ring.iter().zip(ring.iter().skip(1).chain(ring.first())) {
                straightened.push(straight(from));
                let slope = (to[1] - from[1]) / (to[0] - from[0]);
                let bend = |[u, v]: [f64; 2]| [u, from[1] + (u - from[0]) * slope - v];
                if from[0] < to[0] {
                    straightened.extend(self.corners(halves(from), halves(to)).map(bend));
                } else if from[0] > to[0] {
                    straightened.extend(self.corners(halves(to), halves(from)).rev().map(bend));
                }
            }
            straightened
        };
        let straightened: Vec<Ring> = rings.iter().map(straighten).collect();
        let family = Family { along: [1.0, 0.0], spacing_mm: 2.0 * self.pitch, shift_mm };
        let bend = |[start, end]: [[f64; 2]; 2]| -> Vec<[f64; 2]> {
            let at = |[u, v]: [f64; 2]| [u, v + self.v(u / self.half_side)];
            let corners = self.corners(halves(start), halves(end));
            let is_within = |point: &[f64; 2]| start[0] < point[0] && point[0] < end[0];
            let corners = corners.filter(is_within).map(|[u, v]| [u, v + start[1]]);
            std::iter::once(at(start)).chain(corners).chain([at(end)]).collect()
        };
        family.clip(straightened.iter()).into_iter().map(bend).collect()
    }
}
