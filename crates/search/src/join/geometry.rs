//! Distances and intersections of points and line segments in the plane.

/// The point of the segment from `a` to `b` nearest to `point`.
pub(super) fn nearest_on_segment(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let length2 = dx * dx + dy * dy;
    if length2 <= 0.0 {
        return a;
    }
    let along = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / length2;
    let along = along.clamp(0.0, 1.0);
    [a[0] + along * dx, a[1] + along * dy]
}

/// Square of the distance between two points.
pub(super) fn distance2(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    dx * dx + dy * dy
}

/// Whether the segments `ab` and `cd` cross properly: in a single point that is an end of neither,
/// and further than `margin` from each of the lines' ends.
///
/// A step begins and ends on loops, so touching is not crossing; the margin covers the rounding of
/// such points.
pub(super) fn crosses([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2], margin: f64) -> bool {
    // Signed distances of the ends of one segment from the line through the other.
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        let [dx, dy] = [q[0] - p[0], q[1] - p[1]];
        let length = (dx * dx + dy * dy).sqrt();
        if length <= 0.0 { 0.0 } else { (dx * (r[1] - p[1]) - dy * (r[0] - p[0])) / length }
    };
    let opposite = |s: f64, t: f64| (s > margin && t < -margin) || (s < -margin && t > margin);
    // Along the step the margin matters at its ends, which lie on loops.
    // Along the other line it does not: a step through a corner of a loop does cross the loop.
    let touches = |s: f64, t: f64| (s >= 0.0 && t <= 0.0) || (s <= 0.0 && t >= 0.0);
    opposite(side(c, d, a), side(c, d, b)) && touches(side(a, b, c), side(a, b, d))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "whole numbers are exact")]
    fn nearest_points_of_segments() {
        let nearest = |x, y| nearest_on_segment([x, y], [0.0, 0.0], [4.0, 0.0]);
        assert_eq!(nearest(1.0, 2.0), [1.0, 0.0]);
        assert_eq!(nearest(-1.0, 2.0), [0.0, 0.0]);
        assert_eq!(nearest(9.0, -2.0), [4.0, 0.0]);
        assert_eq!(nearest_on_segment([3.0, 1.0], [1.0, 1.0], [1.0, 1.0]), [1.0, 1.0]);
    }

    #[test]
    fn steps_that_touch_do_not_cross() {
        let line = [[0.0, 0.0], [4.0, 0.0]];
        let cross = |step| crosses(step, line, 1e-6);
        assert!(cross([[1.0, -1.0], [2.0, 1.0]]));
        assert!(!cross([[1.0, 0.0], [2.0, 1.0]]), "begins on the line");
        assert!(!cross([[1.0, 1e-9], [2.0, -1.0]]), "begins on the line, but for rounding");
        assert!(!cross([[5.0, -1.0], [6.0, 1.0]]), "passes its end");
        assert!(cross([[4.0, -1.0], [4.0, 1.0]]), "through its end");
        assert!(!cross([[1.0, 0.0], [2.0, 0.0]]), "along the line");
    }
}
