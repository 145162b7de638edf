//! Places a model on the print bed.

use thiserror::Error;

use crate::bounds::Bounds;
use crate::model::Model;
use crate::stray_vertex::{StrayVertex, length};
use crate::transform::Transform;

/// How a model is scaled, rotated and placed on the print bed.
///
/// Construct it with `..Placement::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Factor for all lengths, more than 0; 25.4 for an STL or OBJ file in inches.
    pub scale: f64,
    /// Rotations in degrees about x, then y, then z.
    pub rotation_degrees: [f64; 3],
    /// x and y in mm of the centre of the model's bounding box on the bed; `None` for the centre of
    /// the bed.
    pub centre_mm: Option<[f64; 2]>,
    /// Width (x), depth (y) and height (z) of the build volume in mm, which begins at 0.
    pub bed_mm: [f64; 3],
}

impl Default for Placement {
    /// Not scaled or rotated, in the centre of a bed of 250 x 210 x 210 mm.
    fn default() -> Self {
        let bed_mm = [250.0, 210.0, 210.0];
        Self { scale: 1.0, rotation_degrees: [0.0; 3], centre_mm: None, bed_mm }
    }
}

/// Why a model cannot be placed on the bed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlacementError {
    /// A field of [`Placement`] is out of range.
    #[error("{what} is {value}, must be {must}")]
    Value {
        /// Name of the quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The range it must lie in.
        must: &'static str,
    },
    /// The model is empty, or its extent is 0 along an axis.
    #[error("model is flat: {} x {} x {} mm", .size_mm[0], .size_mm[1], .size_mm[2])]
    Flat {
        /// Lengths of its bounding box.
        size_mm: [f64; 3],
    },
    /// The model does not fit on the bed.
    #[error(
        "model of {} x {} x {} mm does not fit: \
        from ({}, {}) to ({}, {}) on a bed of {} x {} x {} mm{}",
        length(.size_mm[0]), length(.size_mm[1]), length(.size_mm[2]),
        length(.min_mm[0]), length(.min_mm[1]),
        length(.min_mm[0] + .size_mm[0]), length(.min_mm[1] + .size_mm[1]),
        .bed_mm[0], .bed_mm[1], .bed_mm[2],
        .stray.as_ref().map_or_else(String::new, |stray| format!("; {stray}"))
    )]
    TooLarge {
        /// Lengths of its bounding box.
        size_mm: [f64; 3],
        /// Minimum x and y that it would have on the bed.
        min_mm: [f64; 2],
        /// Lengths of the build volume.
        bed_mm: [f64; 3],
        /// A vertex that is far away from nearly all others, if there is one.
        stray: Option<StrayVertex>,
    },
}

/// How far a model may extend beyond the bed, in mm: a model as large as the bed may do so by the
/// rounding of its coordinates.
const TOLERANCE_MM: f64 = 1e-6;

impl Placement {
    /// Scales, rotates and moves a model such that its lowest point has z = 0. After an error the
    /// model is unchanged.
    /// Linear in the triangles.
    pub fn apply(&self, model: &mut Model) -> Result<(), PlacementError> {
        self.check()?;
        let mut turned = Transform::scaling(self.scale);
        for (axis, &degrees) in self.rotation_degrees.iter().enumerate() {
            turned = turned.then(&Transform::rotation(axis, degrees));
        }
        let mut bounds = Bounds::EMPTY;
        let mut is_finite = true;
        for mesh in model.solid_bodies().map(|body| &body.mesh) {
            for &vertex in mesh.triangles().iter().flatten() {
                let point = turned.apply_to_point(mesh.vertices()[vertex as usize]);
                is_finite &= point.iter().all(|value| value.is_finite());
                bounds.add(point);
            }
        }
        // Minima and maxima ignore NaN, so the box would not show that coordinates have overflowed.
        let size_mm = if is_finite { bounds.size_mm() } else { [f64::INFINITY; 3] };
        if !size_mm.iter().all(|&side| side > 0.0) {
            return Err(PlacementError::Flat { size_mm });
        }
        let centre = self.centre_mm.unwrap_or([self.bed_mm[0] / 2.0, self.bed_mm[1] / 2.0]);
        let min_mm = [centre[0] - size_mm[0] / 2.0, centre[1] - size_mm[1] / 2.0];
        let fits = |axis: usize, min: f64| {
            min >= -TOLERANCE_MM && min + size_mm[axis] <= self.bed_mm[axis] + TOLERANCE_MM
        };
        if !fits(0, min_mm[0]) || !fits(1, min_mm[1]) || !fits(2, 0.0) {
            let stray = StrayVertex::find(&model.solid_bodies());
            return Err(PlacementError::TooLarge { size_mm, min_mm, bed_mm: self.bed_mm, stray });
        }
        let [x, y, z] = bounds.min;
        let placed = turned.then(&Transform::translation([min_mm[0] - x, min_mm[1] - y, -z]));
        model.bodies.iter_mut().for_each(|body| placed.apply(&mut body.mesh));
        Ok(())
    }

    fn check(&self) -> Result<(), PlacementError> {
        let check = |what, value: f64, is_valid: bool, must| {
            if is_valid { Ok(()) } else { Err(PlacementError::Value { what, value, must }) }
        };
        let positive = |what, value: f64| {
            check(what, value, value > 0.0 && value.is_finite(), "more than 0 and finite")
        };
        let finite = |what, value: f64| check(what, value, value.is_finite(), "finite");
        positive("scale", self.scale)?;
        self.bed_mm.iter().try_for_each(|&side| positive("length of the bed", side))?;
        self.rotation_degrees.iter().try_for_each(|&angle| finite("rotation", angle))?;
        self.centre_mm.iter().flatten().try_for_each(|&value| finite("centre", value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::model::Body;
    use crate::solid::Solid;

    fn model(size_mm: [f64; 3]) -> Model {
        let mesh = Solid::Cuboid { size_mm }.mesh();
        Model { bodies: vec![Body { mesh, ..Body::default() }], ..Model::default() }
    }

    #[test]
    fn a_model_is_placed_in_the_centre_of_the_bed() {
        let mut part = model([10.0, 20.0, 30.0]);
        let placement =
            Placement { scale: 2.0, rotation_degrees: [90.0, 0.0, 0.0], ..Placement::default() };
        placement.apply(&mut part).unwrap();
        let bounds = part.bounds();
        assert_eq!((bounds.min, bounds.max), ([115.0, 75.0, 0.0], [135.0, 135.0, 40.0]));
    }

    #[test]
    fn models_that_do_not_fit_are_refused() {
        let mut part = model([300.0, 20.0, 30.0]);
        let error = Placement::default().apply(&mut part).unwrap_err();
        assert_eq!(part, model([300.0, 20.0, 30.0]));
        assert_eq!(
            error.to_string(),
            "model of 300.0 x 20.0 x 30.0 mm does not fit: \
            from (-25.0, 95.0) to (275.0, 115.0) on a bed of 250 x 210 x 210 mm"
        );
        // prusa3d/PrusaSlicer#14343
        let mut stray = model([10.0; 3]);
        stray.bodies[0].name = "cube".into();
        let mut vertices = [[1.0; 3]; 20].to_vec();
        vertices[7] = [1e30, 0.0, 0.0];
        vertices[8] = [2.0, 3.0, 4.0];
        stray.bodies[0].mesh = Mesh::new(vertices, vec![[0, 7, 8]]).unwrap();
        let error = Placement::default().apply(&mut stray).unwrap_err().to_string();
        let end = "; a vertex of body 'cube' at (1.0e30, 0.0, 0.0) is far away from the others";
        assert!(error.starts_with("model of 1.0e30 x 3.0 x 4.0 mm does not fit"), "{error}");
        assert!(error.ends_with(end), "{error}");
        let aside = Placement { centre_mm: Some([2.0, 100.0]), ..Placement::default() };
        assert!(matches!(aside.apply(&mut model([5.0; 3])), Err(PlacementError::TooLarge { .. })));
        let nothing = Placement { scale: 0.0, ..Placement::default() };
        assert_eq!(
            nothing.apply(&mut model([5.0; 3])).unwrap_err().to_string(),
            "scale is 0, must be more than 0 and finite"
        );
        let nan = Placement { rotation_degrees: [0.0, f64::NAN, 0.0], ..Placement::default() };
        assert!(matches!(nan.apply(&mut model([5.0; 3])), Err(PlacementError::Value { .. })));
        assert!(matches!(
            Placement::default().apply(&mut Model::default()),
            Err(PlacementError::Flat { .. })
        ));
        // Coordinates that overflow.
        let beyond =
            Placement { scale: 1e308, rotation_degrees: [0.0, 0.0, 45.0], ..Placement::default() };
        assert!(matches!(
            beyond.apply(&mut model([1e3, 1e3, 1e-307])),
            Err(PlacementError::TooLarge { .. })
        ));
    }
}
