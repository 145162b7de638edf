//! Boxes parallel to the axes.

/// The smallest box around some points, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Minimum x, y and z.
    pub min: [f64; 3],
    /// Maximum x, y and z.
    pub max: [f64; 3],
}

impl Bounds {
    /// The box around no points; it contains none.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Extends the box to contain a point.
    pub fn add(&mut self, point: [f64; 3]) {
        self.merge(&Self { min: point, max: point });
    }

    /// Extends the box to contain another box.
    pub fn merge(&mut self, other: &Self) {
        self.min = [0, 1, 2].map(|axis| self.min[axis].min(other.min[axis]));
        self.max = [0, 1, 2].map(|axis| self.max[axis].max(other.max[axis]));
    }

    /// Lengths of its sides along x, y and z in mm; negative infinity for [`Bounds::EMPTY`].
    pub fn size_mm(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.max[axis] - self.min[axis])
    }

    /// Length of its diagonal in mm.
    pub fn diagonal_mm(&self) -> f64 {
        self.size_mm().map(|side| side * side).iter().sum::<f64>().sqrt()
    }

    /// Whether a point lies inside the box or on its surface.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|axis| (self.min[axis]..=self.max[axis]).contains(&point[axis]))
    }
}
