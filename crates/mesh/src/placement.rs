//! Where on the bed a model is printed: how it is turned, scaled and put down.

use thiserror::Error;

use super::model::Model;
use super::surface::{Bounds, Mesh};

/// A map of space onto itself that keeps lines straight: turning, scaling, mirroring, moving.
///
/// A point is a row: `p' = p m + d`, as the 3MF specification has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    rows: [[f64; 3]; 4],
}

impl Transform {
    /// Moves nothing.
    pub const IDENTITY: Self = Self::scaling(1.0);

    /// Scales by a factor, about the origin.
    pub const fn scaling(factor: f64) -> Self {
        Self { rows: [[factor, 0.0, 0.0], [0.0, factor, 0.0], [0.0, 0.0, factor], [0.0; 3]] }
    }

    /// Moves by so many mm along each axis.
    pub const fn translation(by_mm: [f64; 3]) -> Self {
        let mut moved = Self::IDENTITY;
        moved.rows[3] = by_mm;
        moved
    }

    /// Turns about axis 0 (x), 1 (y) or 2 (z), counter-clockwise seen against its direction, by so
    /// many degrees.
    ///
    /// Multiples of 90 degrees are exact.
    pub fn rotation(axis: usize, degrees: f64) -> Self {
        let quarter = degrees.rem_euclid(360.0) / 90.0;
        let (sin, cos) = match quarter {
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

    /// From twelve numbers, row by row, the last row moves: the order in 3MF files.
    pub fn from_rows(values: [f64; 12]) -> Self {
        Self { rows: [0, 1, 2, 3].map(|row| [0, 1, 2].map(|column| values[3 * row + column])) }
    }

    /// This map first, then `other`.
    pub fn then(&self, other: &Self) -> Self {
        let mut rows = self.rows.map(|row| other.linear(row));
        for (value, by) in rows[3].iter_mut().zip(other.rows[3]) {
            *value += by;
        }
        Self { rows }
    }

    /// Where it takes a point.
    pub fn apply_to_point(&self, point: [f64; 3]) -> [f64; 3] {
        let linear = self.linear(point);
        [0, 1, 2].map(|axis| linear[axis] + self.rows[3][axis])
    }

    fn linear(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (0..3).map(|row| point[row] * self.rows[row][axis]).sum())
    }

    fn is_mirror(&self) -> bool {
        let [a, b, c, _] = self.rows;
        let spat = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        spat < 0.0
    }

    /// Moves a mesh; one that it mirrors is turned inside out once more, so that its outside stays
    /// outside.
    pub fn apply(&self, mesh: &mut Mesh) {
        mesh.map_vertices(|point| self.apply_to_point(point), self.is_mirror());
    }
}

/// How a model is put on the bed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Lengths are multiplied by this: 25.4 for a file in inches that does not say so.
    /// More than 0.
    pub scale: f64,
    /// Turns in degrees about x, then y, then z.
    pub rotation_degrees: [f64; 3],
    /// x and y on the bed, in mm, of the middle of the model; `None` for the middle of the bed.
    pub centre_mm: Option<[f64; 2]>,
    /// Width (x), depth (y) and height (z) of what can be printed, in mm, from 0.
    pub bed_mm: [f64; 3],
}

impl Default for Placement {
    /// As it is, in the middle of a bed of 250 x 210 x 210 mm.
    fn default() -> Self {
        Self {
            scale: 1.0,
            rotation_degrees: [0.0; 3],
            centre_mm: None,
            bed_mm: [250.0, 210.0, 210.0],
        }
    }
}

/// Why a model can't be put on the bed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlacementError {
    /// A number makes no sense.
    #[error("{what} is {value}: it must be {must}")]
    Value {
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        must: &'static str,
    },
    /// The model has no extent in some direction.
    #[error("the part is flat: {} x {} x {} mm", .size_mm[0], .size_mm[1], .size_mm[2])]
    Flat {
        /// Its sides.
        size_mm: [f64; 3],
    },
    /// The model does not fit.
    #[error(
        "the part is {:.1} x {:.1} x {:.1} mm and does not fit: from ({:.1}, {:.1}) to ({:.1}, {:.1}) on a bed of {} x {} x {} mm",
        .size_mm[0], .size_mm[1], .size_mm[2], .min_mm[0], .min_mm[1],
        .min_mm[0] + .size_mm[0], .min_mm[1] + .size_mm[1], .bed_mm[0], .bed_mm[1], .bed_mm[2]
    )]
    TooLarge {
        /// Its sides.
        size_mm: [f64; 3],
        /// Its least x and y on the bed.
        min_mm: [f64; 2],
        /// The bed's sides.
        bed_mm: [f64; 3],
    },
}

impl Placement {
    /// Turns, scales and moves a model; its lowest point comes to lie on the bed.
    /// A model that is refused stays as it was.
    pub fn apply(&self, model: &mut Model) -> Result<(), PlacementError> {
        let positive = |what, value: f64| {
            let is_right = value > 0.0 && value.is_finite();
            if is_right {
                Ok(())
            } else {
                Err(PlacementError::Value { what, value, must: "more than 0" })
            }
        };
        positive("the scale", self.scale)?;
        self.bed_mm.iter().try_for_each(|&side| positive("a side of the bed", side))?;
        for &value in self.rotation_degrees.iter().chain(self.centre_mm.iter().flatten()) {
            if !value.is_finite() {
                return Err(PlacementError::Value {
                    what: "an angle or a place",
                    value,
                    must: "a number",
                });
            }
        }
        let mut turned = Transform::scaling(self.scale);
        for (axis, &degrees) in self.rotation_degrees.iter().enumerate() {
            turned = turned.then(&Transform::rotation(axis, degrees));
        }
        let mut bounds = Bounds::EMPTY;
        let mut is_finite = true;
        for mesh in model.bodies.iter().map(|body| &body.mesh) {
            for &vertex in mesh.triangles().iter().flatten() {
                let point = turned.apply_to_point(mesh.vertices()[vertex as usize]);
                is_finite &= point.iter().all(|value| value.is_finite());
                bounds.add(point);
            }
        }
        // Of infinities and what comes of them the box tells nothing.
        let size_mm = if is_finite { bounds.size_mm() } else { [f64::INFINITY; 3] };
        if !size_mm.iter().all(|&side| side > 0.0) {
            return Err(PlacementError::Flat { size_mm });
        }
        let centre = self.centre_mm.unwrap_or([self.bed_mm[0] / 2.0, self.bed_mm[1] / 2.0]);
        let min_mm = [centre[0] - size_mm[0] / 2.0, centre[1] - size_mm[1] / 2.0];
        // A part as large as the bed may miss it by the rounding of its coordinates.
        let slack = 1e-6;
        let fits = |axis: usize, least: f64| {
            least >= -slack && least + size_mm[axis] <= self.bed_mm[axis] + slack
        };
        if !fits(0, min_mm[0]) || !fits(1, min_mm[1]) || !fits(2, 0.0) {
            return Err(PlacementError::TooLarge { size_mm, min_mm, bed_mm: self.bed_mm });
        }
        let [x, y, z] = bounds.min;
        let placed = turned.then(&Transform::translation([min_mm[0] - x, min_mm[1] - y, -z]));
        model.bodies.iter_mut().for_each(|body| placed.apply(&mut body.mesh));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Solid};

    fn model(size_mm: [f64; 3]) -> Model {
        let mesh = Solid::Cuboid { size_mm }.mesh();
        Model {
            bodies: vec![Body { name: String::new(), mesh, material: None, paint: vec![] }],
            materials: vec![],
        }
    }

    #[test]
    fn turns_are_counter_clockwise_and_quarters_exact() {
        assert_eq!(Transform::rotation(0, 90.0).apply_to_point([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(Transform::rotation(1, 90.0).apply_to_point([0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(Transform::rotation(2, -270.0).apply_to_point([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        let eighth = Transform::rotation(2, 45.0);
        let quarter = eighth.then(&eighth).apply_to_point([2.0, 0.0, 1.0]);
        assert!((quarter[0]).abs() < 1e-12 && (quarter[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn maps_are_applied_one_after_the_other() {
        let both = Transform::rotation(2, 90.0)
            .then(&Transform::translation([10.0, 0.0, 0.0]))
            .then(&Transform::scaling(2.0));
        assert_eq!(both.apply_to_point([1.0, 0.0, 0.0]), [20.0, 2.0, 0.0]);
    }

    #[test]
    fn a_mirrored_body_keeps_its_outside() {
        let mut mesh = Solid::Cuboid { size_mm: [1.0, 2.0, 3.0] }.mesh();
        let mirror =
            Transform::from_rows([-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        mirror.apply(&mut mesh);
        assert!((mesh.volume_mm3() - 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_part_stands_in_the_middle_of_the_bed() {
        let mut part = model([10.0, 20.0, 30.0]);
        let placement =
            Placement { scale: 2.0, rotation_degrees: [90.0, 0.0, 0.0], ..Placement::default() };
        placement.apply(&mut part).unwrap();
        let bounds = part.bounds();
        assert_eq!((bounds.min, bounds.max), ([115.0, 75.0, 0.0], [135.0, 135.0, 40.0]));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut part = model([300.0, 20.0, 30.0]);
        let error = Placement::default().apply(&mut part).unwrap_err();
        assert_eq!(part, model([300.0, 20.0, 30.0]));
        assert!(
            error.to_string().starts_with("the part is 300.0 x 20.0 x 30.0 mm and does not fit"),
            "{error}"
        );
        let aside = Placement { centre_mm: Some([2.0, 100.0]), ..Placement::default() };
        assert!(matches!(aside.apply(&mut model([5.0; 3])), Err(PlacementError::TooLarge { .. })));
        let nothing = Placement { scale: 0.0, ..Placement::default() };
        assert_eq!(
            nothing.apply(&mut model([5.0; 3])).unwrap_err().to_string(),
            "the scale is 0: it must be more than 0"
        );
        let nan = Placement { rotation_degrees: [0.0, f64::NAN, 0.0], ..Placement::default() };
        assert!(matches!(nan.apply(&mut model([5.0; 3])), Err(PlacementError::Value { .. })));
        assert!(matches!(
            Placement::default().apply(&mut Model::default()),
            Err(PlacementError::Flat { .. })
        ));
        // Beyond all numbers.
        let beyond =
            Placement { scale: 1e308, rotation_degrees: [0.0, 0.0, 45.0], ..Placement::default() };
        assert!(matches!(
            beyond.apply(&mut model([1e3, 1e3, 1e-307])),
            Err(PlacementError::TooLarge { .. })
        ));
    }
}
