//! Divides polygons into triangles.
//!
//! # Method
//! A fan around the first corner is right if all its triangles face the same side as the polygon,
//! as they do for convex polygons.
//! Otherwise some of them would lie outside the polygon, so ears are clipped off one after the
//! other: triangles of three neighbouring corners that contain no other corner.
//! Ear clipping takes time quadratic in the corners, or cubic at worst, so it has a budget; without
//! it, fans enclose the same volume, but have parts outside the polygon that cancel each other.

use crate::vector::{cross, minus};

/// Divides polygons into triangles, within a budget for all of them.
pub(super) struct Triangulator {
    /// Tests of a corner against a triangle that are left.
    budget: usize,
}

impl Default for Triangulator {
    /// The budget is used up within a second.
    fn default() -> Self {
        Self { budget: 100_000_000 }
    }
}

impl Triangulator {
    /// The triangles of a polygon of at least three points, as indices of its points: two fewer
    /// than points, facing the side that the polygon faces.
    pub(super) fn divide(&mut self, points: &[[f64; 3]]) -> Vec<[usize; 3]> {
        if points.len() > 3 {
            let flat = projected(points);
            let is_right = |&[a, b, c]: &[usize; 3]| area(flat[a], flat[b], flat[c]) >= 0.0;
            if !fan(points.len()).all(|triangle| is_right(&triangle)) {
                return self.clip_ears(&flat).unwrap_or_else(|| fan(points.len()).collect());
            }
        }
        fan(points.len()).collect()
    }

    /// `None` if the polygon intersects itself, or the budget is used up.
    fn clip_ears(&mut self, points: &[[f64; 2]]) -> Option<Vec<[usize; 3]>> {
        let mut left: Vec<usize> = (0..points.len()).collect();
        let mut triangles = Vec::with_capacity(points.len() - 2);
        let mut at = 0;
        while left.len() > 3 {
            let count = left.len();
            let ear =
                |at: usize| [left[(at + count - 1) % count], left[at], left[(at + 1) % count]];
            // A corner between its neighbours, on a line, is an ear only if there is no other.
            let mut found = None;
            for is_thin in [false, true] {
                for step in 0..count {
                    let candidate = (at + step) % count;
                    let [a, b, c] = ear(candidate).map(|corner| points[corner]);
                    let is_convex =
                        if is_thin { area(a, b, c) == 0.0 } else { area(a, b, c) > 0.0 };
                    if !is_convex {
                        continue;
                    }
                    self.budget = self.budget.checked_sub(count)?;
                    let is_inside = |point: [f64; 2]| {
                        let is_corner = [a, b, c].contains(&point);
                        !is_corner
                            && area(a, b, point) >= 0.0
                            && area(b, c, point) >= 0.0
                            && area(c, a, point) >= 0.0
                    };
                    if is_thin || !left.iter().any(|&corner| is_inside(points[corner])) {
                        found = Some(candidate);
                        break;
                    }
                }
                if found.is_some() {
                    break;
                }
            }
            let clipped = found?;
            triangles.push(ear(clipped));
            left.remove(clipped);
            // Not the next corner, which would make a fan of slivers.
            at = (clipped + 1) % left.len();
        }
        triangles.push([left[0], left[1], left[2]]);
        Some(triangles)
    }
}

/// The triangles around the first of some points.
fn fan(count: usize) -> impl Iterator<Item = [usize; 3]> {
    (1..count - 1).map(|corner| [0, corner, corner + 1])
}

/// Points seen along the axis that is nearest to the normal of their polygon, from the side that
/// makes the polygon run anticlockwise.
fn projected(points: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let mut normal = [0.0; 3];
    for pair in points[1..].windows(2) {
        let area = cross(minus(pair[0], points[0]), minus(pair[1], points[0]));
        (0..3).for_each(|axis| normal[axis] += area[axis]);
    }
    let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        std::mem::swap(&mut x, &mut y);
    }
    points.iter().map(|point| [point[x], point[y]]).collect()
}

/// Twice the area of a triangle; positive if it runs anticlockwise.
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Triangles that face one side, and have the area of the polygon together, do not overlap.
    fn check(points: &[[f64; 3]]) {
        let flat = projected(points);
        let of = |&[a, b, c]: &[usize; 3]| area(flat[a], flat[b], flat[c]);
        let whole: f64 = fan(points.len()).map(|triangle| of(&triangle)).sum();
        let triangles = Triangulator::default().divide(points);
        assert_eq!(triangles.len(), points.len() - 2);
        assert!(triangles.iter().all(|triangle| of(triangle) >= -1e-12), "{points:?}");
        assert!((triangles.iter().map(of).sum::<f64>() - whole).abs() < 1e-9 * whole.abs());
        // Every side of the polygon belongs to a triangle, in the same direction.
        for from in 0..points.len() {
            let to = (from + 1) % points.len();
            let has = |corners: &[usize; 3]| {
                (0..3).any(|at| corners[at] == from && corners[(at + 1) % 3] == to)
            };
            assert_eq!(triangles.iter().filter(|corners| has(corners)).count(), 1);
        }
    }

    // mikedh/trimesh#2560
    #[test]
    fn concave_polygons_do_not_leave_their_outline() {
        let shapes: [&[[f64; 2]]; 3] = [
            &[[0.0, 0.0], [9.0, 0.0], [9.0, 4.0], [4.0, 4.0], [4.0, 9.0], [0.0, 9.0]],
            // A comb with corners on straight lines.
            &[
                [0.0, 0.0],
                [2.0, 0.0],
                [4.0, 0.0],
                [6.0, 0.0],
                [6.0, 5.0],
                [5.0, 5.0],
                [5.0, 1.0],
                [4.0, 1.0],
                [4.0, 3.0],
                [4.0, 5.0],
                [3.0, 5.0],
                [3.0, 1.0],
                [1.0, 1.0],
                [1.0, 5.0],
                [0.0, 5.0],
            ],
            // A square with a square hole, which a cut joins with the outside.
            &[
                [0.0, 0.0],
                [9.0, 0.0],
                [9.0, 9.0],
                [0.0, 9.0],
                [0.0, 0.0],
                [3.0, 3.0],
                [3.0, 6.0],
                [6.0, 6.0],
                [6.0, 3.0],
                [3.0, 3.0],
            ],
        ];
        for shape in shapes {
            for first in 0..shape.len() {
                let mut points: Vec<[f64; 3]> = shape.iter().map(|&[x, y]| [x, y, 1.0]).collect();
                points.rotate_left(first);
                check(&points);
                points.reverse();
                check(&points);
                points.iter_mut().for_each(|point| point.rotate_left(1));
                check(&points);
            }
        }
    }

    #[test]
    fn polygons_that_cannot_be_clipped_become_fans() {
        let mut triangulator = Triangulator::default();
        assert_eq!(triangulator.divide(&[[1.0; 3]; 5]).len(), 3);
        let bow = [[0.0; 3], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(triangulator.divide(&bow).len(), 2);
        let dart = [[0.0; 3], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
        assert_ne!(triangulator.divide(&dart[..]), [[0, 1, 2], [0, 2, 3]]);
        triangulator.budget = 3;
        assert_eq!(triangulator.divide(&dart[..]), [[0, 1, 2], [0, 2, 3]]);
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 2_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn stars_are_divided(
            radii in prop::collection::vec(0.1..1.0_f64, 3..40),
            tilt in -2.0..2.0,
        ) {
            let step = std::f64::consts::TAU / radii.len() as f64;
            let at = |(number, radius): (usize, &f64)| {
                let angle = number as f64 * step;
                let (x, y) = (radius * angle.cos(), radius * angle.sin());
                [x, y, tilt * x - y]
            };
            check(&radii.iter().enumerate().map(at).collect::<Vec<_>>());
        }
    }
}
