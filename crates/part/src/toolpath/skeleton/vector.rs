//! Vectors of the plane.

/// A point or a vector, in mm.
pub(super) type Vector = [f64; 2];

pub(super) fn add_scaled(a: Vector, b: Vector, factor: f64) -> Vector {
    [a[0] + b[0] * factor, a[1] + b[1] * factor]
}

pub(super) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The vector turned left by a right angle.
pub(super) fn left(a: Vector) -> Vector {
    [-a[1], a[0]]
}

pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

pub(super) fn distance(a: Vector, b: Vector) -> f64 {
    length(sub(a, b))
}

/// The vector with length 1; `None` if it is almost zero.
pub(super) fn unit(a: Vector) -> Option<Vector> {
    let length = length(a);
    (length > 1e-9).then(|| [a[0] / length, a[1] / length])
}

pub(super) fn lerp(a: Vector, b: Vector, t: f64) -> Vector {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
}

/// The point of a segment that is nearest to a point.
pub(super) fn nearest_on_segment(segment: [Vector; 2], point: Vector) -> Vector {
    let along = sub(segment[1], segment[0]);
    let square = dot(along, along);
    if square <= 0.0 {
        return segment[0];
    }
    let t = dot(sub(point, segment[0]), along) / square;
    lerp(segment[0], segment[1], t.clamp(0.0, 1.0))
}
