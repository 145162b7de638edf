//! Bounding boxes.

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
