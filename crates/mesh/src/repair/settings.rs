//! Settings of a repair.

use crate::bounds::Bounds;

/// Spacing of numbers that is taken for precision, in mm: that of coordinates of 400 m.
/// Larger coordinates are errors.
const MAX_SPACING_MM: f64 = 0.05;

/// Vertices farther apart than this share of the body's diagonal are never merged.
const MAX_SHARE: f64 = 1e-3;

/// How a body is repaired.
///
/// Construct it with `..RepairSettings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RepairSettings {
    /// Maximum distance along each axis, in mm, of two vertices of open edges that are merged.
    /// It is raised to the spacing of float32 numbers at the size of the body's coordinates, up to
    /// 0.05 mm, and lowered to a thousandth of the body's diagonal.
    pub max_merge_mm: f64,
}

impl Default for RepairSettings {
    /// Merges vertices up to 0.004 mm apart: twice as far as noise of 0.002 mm.
    fn default() -> Self {
        Self { max_merge_mm: 4e-3 }
    }
}

impl RepairSettings {
    /// The maximum distance for a body with these bounds, in mm.
    pub(super) fn max_merge_mm(self, bounds: &Bounds) -> f64 {
        let spacing_mm = spacing_mm(bounds).min(MAX_SPACING_MM);
        self.max_merge_mm.max(spacing_mm).min(MAX_SHARE * bounds.diagonal_mm())
    }
}

/// The spacing of float32 numbers at the largest coordinate.
pub(super) fn spacing_mm(bounds: &Bounds) -> f64 {
    let coordinates = bounds.min.iter().chain(&bounds.max);
    coordinates.fold(0.0, |max: f64, at| max.max(at.abs())) * f64::from(f32::EPSILON)
}
