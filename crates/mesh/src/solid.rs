//! Meshes of simple solids.

use std::f64::consts::TAU;

use crate::mesh::Mesh;

/// A simple solid, for examples and tests.
/// Its surface is closed and faces outwards.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// A box with one corner at the origin.
    Cuboid {
        /// Lengths along x, y and z in mm.
        size_mm: [f64; 3],
    },
    /// An outline extruded along z.
    Prism {
        /// Corners in mm, counter-clockwise when seen from above.
        /// The last one is connected to the first.
        outline_mm: Vec<[f64; 2]>,
        /// z of the bottom and of the top in mm.
        z_mm: [f64; 2],
    },
    /// The solid between two outlines, such as an inclined pipe or a cone.
    /// Straight edges connect the corners of the outlines in order.
    Loft {
        /// Corners of the bottom in mm, counter-clockwise when seen from above.
        bottom_mm: Vec<[f64; 2]>,
        /// Corners of the top, as many as of the bottom, in the same form.
        top_mm: Vec<[f64; 2]>,
        /// z of the bottom and of the top in mm.
        z_mm: [f64; 2],
    },
    /// A truncated square pyramid around the z axis, with its bottom at z = 0.
    Frustum {
        /// Sides of the bottom and of the top in mm.
        sides_mm: [f64; 2],
        /// Height in mm.
        height_mm: f64,
    },
    /// A sphere around the origin, made of 2 `steps` meridians and `steps` bands: 4 `steps`
    /// (`steps` - 1) triangles.
    Sphere {
        /// Radius in mm.
        radius_mm: f64,
        /// At least 2.
        steps: u32,
    },
}

impl Solid {
    /// Creates the surface.
    /// Linear in its triangles.
    ///
    /// # Panics
    /// If a prism or a loft has fewer than 3 corners, the outlines of a loft differ in their number
    /// of corners, a sphere has fewer than 2 steps, or a length is not finite.
    pub fn mesh(&self) -> Mesh {
        match self {
            &Self::Cuboid { size_mm: [x, y, z] } => {
                prism(&[[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]], None, [0.0, z])
            }
            Self::Prism { outline_mm, z_mm } => prism(outline_mm, None, *z_mm),
            Self::Loft { bottom_mm, top_mm, z_mm } => prism(bottom_mm, Some(top_mm), *z_mm),
            &Self::Frustum { sides_mm: [bottom, top], height_mm } => {
                let square = |side: f64| {
                    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                        .map(|[x, y]| [x * side / 2.0, y * side / 2.0])
                };
                prism(&square(bottom), Some(&square(top)), [0.0, height_mm])
            }
            &Self::Sphere { radius_mm, steps } => sphere(radius_mm, steps),
        }
    }
}

/// The surface between two outlines of equally many corners; without `top`, both are the same.
///
/// Bottom and top are fans around their first corner.
/// Fans of outlines that are not convex overlap themselves, but correctly: points outside are
/// covered as often by triangles that face up as by triangles that face down.
fn prism(bottom: &[[f64; 2]], top: Option<&[[f64; 2]]>, z_mm: [f64; 2]) -> Mesh {
    let count = bottom.len() as u32;
    assert!(count >= 3, "an outline needs at least 3 corners");
    assert!(top.is_none_or(|top| top.len() == bottom.len()), "outlines have equally many corners");
    let ring =
        |outline: &[[f64; 2]], z: f64| outline.iter().map(|&[x, y]| [x, y, z]).collect::<Vec<_>>();
    let mut vertices = ring(bottom, z_mm[0]);
    vertices.extend(ring(top.unwrap_or(bottom), z_mm[1]));
    let mut triangles = Vec::new();
    for corner in 1..count - 1 {
        triangles.push([0, corner + 1, corner]);
        triangles.push([count, count + corner, count + corner + 1]);
    }
    for corner in 0..count {
        let next = (corner + 1) % count;
        triangles.push([corner, next, count + next]);
        triangles.push([corner, count + next, count + corner]);
    }
    Mesh::new(vertices, triangles).expect("lengths are finite")
}

fn sphere(radius: f64, steps: u32) -> Mesh {
    assert!(steps >= 2, "a sphere needs at least 2 steps");
    let around = 2 * steps;
    let mut vertices = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    for ring in 1..steps {
        let (sin, cos) = (TAU / 2.0 * f64::from(ring) / f64::from(steps)).sin_cos();
        for meridian in 0..around {
            let (y, x) = (TAU * f64::from(meridian) / f64::from(around)).sin_cos();
            vertices.push([radius * sin * x, radius * sin * y, -radius * cos]);
        }
    }
    let vertex = |ring: u32, meridian: u32| 2 + (ring - 1) * around + meridian % around;
    let mut triangles = Vec::new();
    for meridian in 0..around {
        triangles.push([0, vertex(1, meridian + 1), vertex(1, meridian)]);
        triangles.push([1, vertex(steps - 1, meridian), vertex(steps - 1, meridian + 1)]);
        for ring in 1..steps - 1 {
            let [a, b] = [vertex(ring, meridian), vertex(ring, meridian + 1)];
            let [c, d] = [vertex(ring + 1, meridian), vertex(ring + 1, meridian + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    Mesh::new(vertices, triangles).expect("lengths are finite")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_match_formulas() {
        let sphere = Solid::Sphere { radius_mm: 10.0, steps: 100 }.mesh();
        assert_eq!(sphere.triangles().len(), 4 * 100 * 99);
        let volume = 4.0 / 3.0 * TAU / 2.0 * 1000.0;
        assert!((sphere.volume_mm3() / volume - 1.0).abs() < 1e-3);
        let frustum = Solid::Frustum { sides_mm: [4.0, 1.0], height_mm: 3.0 }.mesh();
        assert!((frustum.volume_mm3() - 21.0).abs() < 1e-9);
        // An inclined prism has the volume of an upright one.
        let square = |x: f64| vec![[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 3.0], [x, 3.0]];
        let (bottom_mm, top_mm) = (square(0.0), square(7.0));
        let loft = Solid::Loft { bottom_mm, top_mm, z_mm: [1.0, 5.0] }.mesh();
        assert!((loft.volume_mm3() - 24.0).abs() < 1e-9);
        assert_eq!(loft.bounds().size_mm(), [9.0, 3.0, 4.0]);
        // An L is not convex.
        let outline_mm =
            vec![[2.0, 2.0], [2.0, 5.0], [0.0, 5.0], [0.0, 0.0], [5.0, 0.0], [5.0, 2.0]];
        let prism = Solid::Prism { outline_mm, z_mm: [1.0, 2.0] }.mesh();
        assert!((prism.volume_mm3() - 16.0).abs() < 1e-9);
    }
}
