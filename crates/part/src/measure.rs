//! Bounding boxes and sizes.

/// Minimum and maximum x and y.
pub(crate) type Bounds = [[f64; 2]; 2];

/// The bounding box of points; `None` if there are none.
pub(crate) fn bounds<'a>(points: impl IntoIterator<Item = &'a [f64; 2]>) -> Option<Bounds> {
    let mut points = points.into_iter();
    let first = *points.next()?;
    Some(points.fold([first; 2], |[min, max], point| {
        [[0, 1].map(|k| min[k].min(point[k])), [0, 1].map(|k| max[k].max(point[k]))]
    }))
}

/// Whether two boxes are nearer than a distance in x and y.
pub(crate) fn overlap(a: Bounds, b: Bounds, reach: f64) -> bool {
    [0, 1].iter().all(|&k| a[0][k] <= b[1][k] + reach && b[0][k] <= a[1][k] + reach)
}

/// Area enclosed by a ring in mm², negative if the ring is clockwise.
pub(crate) fn ring_size_mm2(ring: &[[f64; 2]]) -> f64 {
    let Some(&origin) = ring.first() else { return 0.0 };
    let from_origin = |point: [f64; 2]| [point[0] - origin[0], point[1] - origin[1]];
    let cross = |pair: &[[f64; 2]]| {
        let [a, b] = [pair[0], pair[1]].map(from_origin);
        (a[0] * b[1] - b[0] * a[1]) / 2.0
    };
    ring.windows(2).map(cross).sum()
}
