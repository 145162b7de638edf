//! Affine maps of space.

use crate::mesh::Mesh;

/// An affine map: rotation, scaling, reflection and translation in any combination.
///
/// Points are row vectors, as in the 3MF specification: `p' = p M + d`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// The three rows of M, and d.
    rows: [[f64; 3]; 4],
}

impl Transform {
    /// Maps every point to itself.
    pub const IDENTITY: Self = Self::scaling(1.0);

    /// Scales by a factor, relative to the origin.
    pub const fn scaling(factor: f64) -> Self {
        Self { rows: [[factor, 0.0, 0.0], [0.0, factor, 0.0], [0.0, 0.0, factor], [0.0; 3]] }
    }

    /// Moves by a vector in mm.
    pub const fn translation(by_mm: [f64; 3]) -> Self {
        let mut transform = Self::IDENTITY;
        transform.rows[3] = by_mm;
        transform
    }

    /// Rotates about axis 0 (x), 1 (y) or 2 (z), counter-clockwise when the axis points at the
    /// viewer.
    ///
    /// Multiples of 90 degrees are exact.
    pub fn rotation(axis: usize, degrees: f64) -> Self {
        let quarters = degrees.rem_euclid(360.0) / 90.0;
        let (sin, cos) = match quarters {
            0.0 => (0.0, 1.0),
            1.0 => (1.0, 0.0),
            2.0 => (0.0, -1.0),
            3.0 => (-1.0, 0.0),
            _ => degrees.to_radians().sin_cos(),
        };
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut rows = Self::IDENTITY.rows;
        rows[next][next] = cos;
        rows[next][last] = sin;
        rows[last][next] = -sin;
        rows[last][last] = cos;
        Self { rows }
    }

    /// Creates a map from twelve numbers, as in 3MF files: the three rows of M, then d.
    pub fn from_rows(values: [f64; 12]) -> Self {
        Self { rows: [0, 1, 2, 3].map(|row| [0, 1, 2].map(|column| values[3 * row + column])) }
    }

    /// Returns the map that applies `self` first and then `other`.
    pub fn then(&self, other: &Self) -> Self {
        let mut rows = self.rows.map(|row| other.linear(row));
        for (value, by) in rows[3].iter_mut().zip(other.rows[3]) {
            *value += by;
        }
        Self { rows }
    }

    /// Maps a point.
    pub fn apply_to_point(&self, point: [f64; 3]) -> [f64; 3] {
        let linear = self.linear(point);
        [0, 1, 2].map(|axis| linear[axis] + self.rows[3][axis])
    }

    /// Maps a mesh.
    /// If the map is a reflection, triangles are reversed, so that they still face outwards.
    pub fn apply(&self, mesh: &mut Mesh) {
        mesh.map_vertices(|point| self.apply_to_point(point), self.is_reflection());
    }

    fn linear(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (0..3).map(|row| point[row] * self.rows[row][axis]).sum())
    }

    /// Whether the determinant of M is negative.
    fn is_reflection(&self) -> bool {
        let [a, b, c, _] = self.rows;
        let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        determinant < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Solid;

    #[test]
    fn rotations_are_counter_clockwise_and_quarters_exact() {
        assert_eq!(Transform::rotation(0, 90.0).apply_to_point([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(Transform::rotation(1, 90.0).apply_to_point([0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(Transform::rotation(2, -270.0).apply_to_point([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        let eighth = Transform::rotation(2, 45.0);
        let quarter = eighth.then(&eighth).apply_to_point([2.0, 0.0, 1.0]);
        assert!((quarter[0]).abs() < 1e-12 && (quarter[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn combined_maps_are_applied_in_order() {
        let both = Transform::rotation(2, 90.0)
            .then(&Transform::translation([10.0, 0.0, 0.0]))
            .then(&Transform::scaling(2.0));
        assert_eq!(both.apply_to_point([1.0, 0.0, 0.0]), [20.0, 2.0, 0.0]);
    }

    #[test]
    fn a_reflected_body_is_not_inside_out() {
        let mut mesh = Solid::Cuboid { size_mm: [1.0, 2.0, 3.0] }.mesh();
        let mirror =
            Transform::from_rows([-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        mirror.apply(&mut mesh);
        assert!((mesh.volume_mm3() - 6.0).abs() < 1e-12);
    }
}
