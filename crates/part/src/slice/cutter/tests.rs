//! The sweep against a look at every triangle in every layer, and outlines against solids that are
//! known.

use proptest::prelude::*;

use super::*;
use crate::slice::FillRule;
use beadwork_mesh::{Mesh, Shape};

/// Every triangle looked at for one plane.
fn slow_cut(mesh: &Mesh, paint: &[u8], plane: f64) -> Outline {
    let is_met = |&triangle: &u32| {
        let z = mesh.corners(mesh.triangles()[triangle as usize]).map(|corner| corner[2]);
        z.iter().any(|&z| z < plane) && z.iter().any(|&z| z >= plane)
    };
    let met = (0..mesh.triangles().len() as u32).filter(is_met);
    let mut segments: Vec<Segment> = met.map(|triangle| segment(mesh, triangle, plane)).collect();
    link(mesh, &mut segments, paint, plane)
}

fn pool() -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap()
}

#[test]
fn a_frustum_has_squares_in_all_layers() {
    let mut mesh = Shape::Frustum { sides_mm: [8.0, 4.0], height_mm: 4.0 }.mesh();
    mesh.map(|[x, y, z]| [x + 1.0, y + 2.0, z], false);
    let outlines = cut(&mesh, &[], 0.5, 9, None);
    assert!(outlines[8].is_empty());
    for (layer, outline) in outlines[..8].iter().enumerate() {
        let side = 8.0 - plane_mm(layer, 0.5);
        assert!(
            (outline.area_mm2() - side * side).abs() < 1e-9,
            "{} in layer {layer}",
            outline.area_mm2()
        );
        assert_eq!(outline.loops().count(), 1);
        assert_eq!(outline.polygons(FillRule::NonZero).len(), 1);
    }
}

#[test]
fn vertices_on_planes_are_no_trouble() {
    // Every ring of the sphere's vertices lies on a plane or between two.
    for steps in [4, 8, 16] {
        let mut mesh = Shape::Sphere { radius_mm: 4.0, steps }.mesh();
        mesh.map(|[x, y, z]| [x, y, ((z + 4.0) * 4.0).round() / 4.0], false);
        let outlines = cut(&mesh, &[], 0.5, 16, None);
        for outline in &outlines {
            assert_eq!(outline.loops().count(), 1);
            assert!(outline.area_mm2() > 0.0);
        }
    }
}

/// Closed surfaces with every kind of nuisance: few heights, so that many vertices lie on planes,
/// and parts that overlap.
fn nuisances() -> impl Strategy<Value = (Mesh, Vec<u8>)> {
    let part = (2_u32..7, -3..3_i8, -3..3_i8, 0..6_i8, any::<bool>());
    (prop::collection::vec(part, 1..5), any::<bool>()).prop_map(|(parts, is_painted)| {
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for (steps, x, y, z, is_inverted) in parts {
            let ball = Shape::Sphere { radius_mm: 3.0, steps }.mesh();
            let base = vertices.len() as u32;
            let shift = [x, y, z].map(f64::from);
            vertices.extend(ball.vertices().iter().map(|point| {
                let [x, y, z] = [0, 1, 2].map(|axis| point[axis] + shift[axis]);
                [x, y, (2.0 * z).round() / 2.0]
            }));
            triangles.extend(ball.triangles().iter().map(|&[a, b, c]| {
                let corners = if is_inverted { [a, c, b] } else { [a, b, c] };
                corners.map(|vertex| vertex + base)
            }));
        }
        let paint = if is_painted {
            (0..triangles.len()).map(|at| at as u8 % 5).collect()
        } else {
            Vec::new()
        };
        (Mesh::new(vertices, triangles).unwrap(), paint)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_sweep_is_a_look_at_every_triangle((mesh, paint) in nuisances(), layer in prop::sample::select(vec![0.3, 0.5, 1.0, 7.0])) {
        let layers = (9.0_f64 / layer) as usize;
        let outlines = cut(&mesh, &paint, layer, layers, None);
        prop_assert_eq!(outlines.len(), layers);
        for (number, outline) in outlines.iter().enumerate() {
            prop_assert_eq!(outline, &slow_cut(&mesh, &paint, plane_mm(number, layer)));
        }
    }
}

#[test]
fn threads_change_nothing() {
    let mut mesh = Shape::Sphere { radius_mm: 9.0, steps: 60 }.mesh();
    mesh.map(|[x, y, z]| [x, y, z + 9.0], false);
    assert_eq!(cut(&mesh, &[], 0.1, 180, Some(&pool())), cut(&mesh, &[], 0.1, 180, None));
}
