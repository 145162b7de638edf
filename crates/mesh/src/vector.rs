//! Arithmetic with vectors of three numbers.

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Signed volume of the tetrahedron between a triangle and the origin, in mm³: positive if the
/// triangle is counter-clockwise when seen from the side away from the origin.
///
/// The sum over the triangles of a closed surface is the volume inside.
pub(crate) fn tetrahedron_mm3([a, b, c]: [[f64; 3]; 3]) -> f64 {
    dot(a, cross(b, c)) / 6.0
}
