//! Repairs of damaged surfaces.

use std::collections::HashMap;

use beadwork_base::{CancelToken, Interrupted, Progress};
use proptest::prelude::*;

use super::orientation::crossing;
use super::ray_tree::RayTree;
use super::*;
use crate::Solid;
use crate::mesh::Mesh;

fn body(mesh: Mesh) -> Body {
    Body { name: String::new(), mesh, material: None, ..Body::default() }
}

/// Whether every edge is used as often in one direction as in the other.
fn is_closed(mesh: &Mesh) -> bool {
    let mut balance: HashMap<[u32; 2], i32> = HashMap::new();
    for corners in mesh.triangles() {
        for corner in 0..3 {
            let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
            *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    balance.values().all(|&balance| balance == 0)
}

fn combined(solids: &[(Solid, [f64; 3], bool)]) -> Mesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for (solid, shift, inverted) in solids {
        let mesh = solid.mesh();
        let base = vertices.len() as u32;
        vertices.extend(
            mesh.vertices().iter().map(|point| [0, 1, 2].map(|axis| point[axis] + shift[axis])),
        );
        triangles.extend(mesh.triangles().iter().map(|&[a, b, c]| {
            let turned = if *inverted { [a, c, b] } else { [a, b, c] };
            turned.map(|vertex| vertex + base)
        }));
    }
    Mesh::new(vertices, triangles).unwrap()
}

#[test]
fn a_sound_body_stays_as_it_is() {
    let mut sound = body(Solid::Sphere { radius_mm: 5.0, steps: 8 }.mesh());
    let before = sound.clone();
    assert_eq!(
        sound.repair(&RepairSettings::default(), &Control::default()).unwrap(),
        RepairReport::default()
    );
    assert_eq!(sound, before);
}

#[test]
fn a_body_inside_out_is_flipped() {
    let mut inverted =
        body(combined(&[(Solid::Cuboid { size_mm: [1.0, 2.0, 3.0] }, [5.0, 5.0, 5.0], true)]));
    assert_eq!(
        inverted.repair(&RepairSettings::default(), &Control::default()).unwrap().flipped_triangles,
        12
    );
    assert!((inverted.mesh.volume_mm3() - 6.0).abs() < 1e-9);
}

#[test]
fn a_cavity_stays_and_a_body_in_a_cavity_is_flipped() {
    let cube = |side: f64| Solid::Cuboid { size_mm: [side; 3] };
    let hollow =
        [(cube(10.0), [0.0; 3], false), (cube(6.0), [2.0; 3], true), (cube(2.0), [4.0; 3], true)];
    let mut hollow = body(combined(&hollow));
    assert_eq!(
        hollow.repair(&RepairSettings::default(), &Control::default()).unwrap().flipped_triangles,
        12
    );
    assert!((hollow.mesh.volume_mm3() - (1000.0 - 216.0 + 8.0)).abs() < 1e-9);
}

#[test]
fn a_hollow_body_that_is_inside_out_stays_hollow() {
    let cube = |side: f64| Solid::Cuboid { size_mm: [side; 3] };
    let inverted =
        [(cube(10.0), [0.0; 3], true), (cube(6.0), [2.0; 3], false), (cube(2.0), [4.0; 3], true)];
    let mut inverted = body(combined(&inverted));
    assert_eq!(
        inverted.repair(&RepairSettings::default(), &Control::default()).unwrap().flipped_triangles,
        36
    );
    assert!((inverted.mesh.volume_mm3() - (1000.0 - 216.0 + 8.0)).abs() < 1e-9);
}

#[test]
fn a_missing_triangle_is_filled() {
    let mut open = body(Solid::Cuboid { size_mm: [10.0; 3] }.mesh());
    open.mesh.parts_mut().1.pop();
    open.paint = vec![0; 11];
    open.paint[10] = 7;
    assert_eq!(
        open.repair(&RepairSettings::default(), &Control::default()).unwrap(),
        RepairReport { closed_holes: 1, ..RepairReport::default() }
    );
    assert!((open.mesh.volume_mm3() - 1000.0).abs() < 1e-9);
    assert_eq!(open.paint.len(), 12);
}

#[test]
fn surfaces_that_enclose_nothing_are_refused() {
    let point = Mesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]; 12]).unwrap();
    assert_eq!(
        body(point).repair(&RepairSettings::default(), &Control::default()),
        Err(RepairError::NoArea(12))
    );
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let sheet = Mesh::new(corners, vec![[0, 1, 2]]).unwrap();
    let error = body(sheet).repair(&RepairSettings::default(), &Control::default()).unwrap_err();
    assert!(matches!(error, RepairError::NoVolume { triangles: 1, stray: None, .. }), "{error}");
    let cube = Solid::Cuboid { size_mm: [10.0; 3] }.mesh();
    let mut shift = 0.0;
    let apart = noisy(&cube, false, || {
        shift += 0.1;
        shift % 1.0
    });
    let error = body(apart).repair(&RepairSettings::default(), &Control::default()).unwrap_err();
    assert!(error.to_string().contains("merge vertices over a larger distance"), "{error}");
}

#[test]
fn a_large_hole_that_is_not_flat_is_refused() {
    let mut half = body(Solid::Sphere { radius_mm: 10.0, steps: 12 }.mesh());
    // Without a wedge, the boundary of the rest is far from flat.
    let vertices = half.mesh.vertices().to_vec();
    half.mesh.parts_mut().1.retain(|corners| {
        let [x, y] = [0, 1]
            .map(|axis| corners.iter().map(|&vertex| vertices[vertex as usize][axis]).sum::<f64>());
        x < 0.0 || y < 0.0
    });
    assert!(matches!(
        half.repair(&RepairSettings::default(), &Control::default()),
        Err(RepairError::Hole { .. })
    ));
}

#[test]
fn a_repair_can_be_cancelled_and_reports_progress() {
    let mut sphere = body(Solid::Sphere { radius_mm: 10.0, steps: 80 }.mesh());
    let triangles = sphere.mesh.triangles().len();
    let seen = std::sync::Mutex::new(Vec::new());
    let progress = |progress: Progress| seen.lock().unwrap().push(progress);
    let control = Control { progress: Some(&progress), ..Control::default() };
    sphere.repair(&RepairSettings::default(), &control).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.len() > 12 && seen.is_sorted_by_key(|progress| progress.done));
    assert_eq!(seen.last(), Some(&Progress { done: 7 * triangles, total: 7 * triangles }));

    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    assert_eq!(
        sphere.repair(&RepairSettings::default(), &control),
        Err(RepairError::Interrupted(Interrupted::Cancelled))
    );
}

/// A part with flat faces: a prism of this many sides, 10 mm high.
fn prism(sides: u32) -> Mesh {
    let corner = |side: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(side) / f64::from(sides)).sin_cos();
        [10.0 * cos, 10.0 * sin]
    };
    Solid::Prism { outline_mm: (0..sides).map(corner).collect(), z_mm: [0.0, 10.0] }.mesh()
}

/// A copy with vertices of their own for every triangle, or for every group of triangles that face
/// the same direction, each moved by `noise` of the group and the corner.
fn noisy(mesh: &Mesh, by_face: bool, mut noise: impl FnMut() -> f64) -> Mesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    // Directions of faces, rounded, and the vertices of each face.
    let mut faces: Vec<([i64; 3], HashMap<u32, u32>)> = Vec::new();
    for &triangle in mesh.triangles() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = crate::vector::cross(crate::vector::minus(b, a), crate::vector::minus(c, a));
        let length = crate::vector::dot(normal, normal).sqrt();
        let direction = normal.map(|value| (1e3 * value / length).round() as i64);
        let known = faces.iter().position(|(other, _)| by_face && *other == direction);
        let face = known.unwrap_or_else(|| {
            faces.push((direction, HashMap::new()));
            faces.len() - 1
        });
        triangles.push(triangle.map(|vertex| {
            *faces[face].1.entry(vertex).or_insert_with(|| {
                vertices.push(mesh.vertices()[vertex as usize].map(|value| value + noise()));
                vertices.len() as u32 - 1
            })
        }));
    }
    Mesh::new(vertices, triangles).unwrap()
}

// slic3r/Slic3r#4891, prusa3d/PrusaSlicer#14023
#[test]
fn parts_with_noisy_vertices_are_read() {
    let mut state = 1_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    let cube = Solid::Cuboid { size_mm: [10.0; 3] }.mesh();
    let sphere = Solid::Sphere { radius_mm: 10.0, steps: 16 }.mesh();
    for mesh in [cube, sphere, prism(6), prism(48)] {
        for noise_mm in [1e-6, 1e-5, 1e-4, 1e-3] {
            for (by_face, far_mm) in [(false, 0.0), (true, 0.0), (false, 900.0), (true, 900.0)] {
                let mut moved = mesh.clone();
                crate::Transform::translation([far_mm, -far_mm, 0.3]).apply(&mut moved);
                let mut open = body(noisy(&moved, by_face, || noise_mm * random()));
                let done = open.repair(&RepairSettings::default(), &Control::default()).unwrap();
                assert!(is_closed(&open.mesh));
                assert!(done.near_vertices > 0 && done.closed_holes == 0, "{done:?}");
                assert_eq!(open.mesh.triangles().len(), mesh.triangles().len());
                let error = (open.mesh.volume_mm3() / mesh.volume_mm3() - 1.0).abs();
                assert!(error < 1e-3, "{error} with noise of {noise_mm} mm");
            }
        }
    }
}

#[test]
fn tolerances_shrink_with_the_body() {
    // On one side of an edge, a vertex near its centre, at most 0.002 mm off.
    for (side_mm, t_junctions) in [(10.0, 1), (0.5, 0)] {
        let mut mesh = Solid::Cuboid { size_mm: [side_mm; 3] }.mesh();
        let [a, b, c] = mesh.triangles()[0];
        let corners = mesh.corners([a, b, c]);
        let share = 0.002 / side_mm;
        let near = [0, 1, 2].map(|axis| {
            let centre = f64::midpoint(corners[0][axis], corners[1][axis]);
            centre + share * (corners[2][axis] - centre)
        });
        let (vertices, triangles) = mesh.parts_mut();
        vertices.push(near);
        triangles[0] = [a, 8, c];
        triangles.push([8, b, c]);
        let done = body(mesh).repair(&RepairSettings::default(), &Control::default()).unwrap();
        assert_eq!((done.closed_t_junctions, done.closed_holes), (t_junctions, 1 - t_junctions));
    }
}

#[test]
fn closed_regions_keep_details_smaller_than_the_tolerance() {
    // A tiny tetrahedron on its own, beside a box of which a triangle is missing.
    let tiny = [[20.0, 0.0, 0.0], [20.001, 0.0, 0.0], [20.0, 0.001, 0.0], [20.0, 0.0, 0.001]];
    let mut mesh = Solid::Cuboid { size_mm: [10.0; 3] }.mesh();
    let (vertices, triangles) = mesh.parts_mut();
    triangles.pop();
    vertices.extend(tiny);
    triangles.extend([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|t| t.map(|at| at + 8)));
    let mut detailed = body(mesh);
    let done = detailed.repair(&RepairSettings::default(), &Control::default()).unwrap();
    assert_eq!(done, RepairReport { closed_holes: 1, ..RepairReport::default() });
    assert_eq!((detailed.mesh.vertices().len(), detailed.mesh.triangles().len()), (12, 16));
}

/// Edges that lie in each other on a line, which has many vertices: splitting all of them would
/// make a quadratic number of triangles.
#[test]
fn edges_on_one_line_do_not_multiply() {
    let count = 2_000_u32;
    let mut points: Vec<[f64; 3]> = (0..=count).map(|at| [f64::from(at), 0.0, 0.0]).collect();
    let mut triangles = Vec::new();
    let mut add = |from: u32, to: u32, y: f64| {
        triangles.push([from, to, points.len() as u32]);
        points.push([f64::from(from), y, 1.0 + f64::from(from)]);
    };
    (0..count / 2).for_each(|at| add(at, count - at, 500.0));
    (0..count).for_each(|at| add(at, at + 1, -500.0));
    let mut nested = body(Mesh::new(points, triangles).unwrap());
    _ = nested.repair(&RepairSettings::default(), &Control::default());
    assert!(nested.mesh.triangles().len() < 20_000, "{}", nested.mesh.triangles().len());
}

/// Splits a triangle into four with the centres of its edges, repeatedly, as `choice` decides.
fn divide(
    mut triangle: [[f64; 3]; 3],
    depth: u32,
    choice: &mut impl FnMut() -> bool,
    out: &mut Vec<[[f64; 3]; 3]>,
) {
    if depth == 0 || !choice() {
        triangle.rotate_left(usize::from(choice()));
        out.push(triangle);
        return;
    }
    let [a, b, c] = triangle;
    let centre = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|axis| f64::midpoint(p[axis], q[axis]));
    let [d, e, f] = [centre(a, b), centre(b, c), centre(c, a)];
    for part in [[a, d, f], [d, b, e], [f, e, c], [d, e, f]] {
        divide(part, depth - 1, choice, out);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Vertices that are not shared, flipped triangles, missing triangles: the repaired surface is
    /// the sphere again.
    #[test]
    fn a_damaged_sphere_is_restored(
        steps in 6_u32..14,
        flipped in prop::collection::vec(any::<prop::sample::Index>(), 0..20),
        missing in prop::collection::vec(any::<prop::sample::Index>(), 0..3),
        apart: bool,
        offset in 0..1000_i32,
    ) {
        let sphere = Solid::Sphere { radius_mm: 10.0, steps }.mesh();
        let shift = f64::from(offset);
        let moved = |&[x, y, z]: &[f64; 3]| [x + shift, y, z - shift];
        let points: Vec<[f64; 3]> = sphere.vertices().iter().map(moved).collect();
        let mut triangles = sphere.triangles().to_vec();
        for index in flipped {
            let triangle = index.index(triangles.len());
            triangles[triangle].swap(0, 1);
        }
        for index in &missing {
            let triangle = index.index(triangles.len());
            triangles.swap_remove(triangle);
        }
        let (points, triangles) = if apart {
            let corners = triangles.iter().flatten().map(|&vertex| points[vertex as usize]);
            let own = |triangle: u32| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2];
            (corners.collect::<Vec<_>>(), (0..triangles.len() as u32).map(own).collect())
        } else {
            (points, triangles)
        };
        let mut damaged = body(Mesh::new(points, triangles).unwrap());
        let done = damaged.repair(&RepairSettings::default(), &Control::default()).unwrap();
        prop_assert!(is_closed(&damaged.mesh));
        prop_assert!(done.closed_holes <= missing.len());
        // A filled hole may cut off a corner, but no more than the share of the missing triangles.
        let error = (damaged.mesh.volume_mm3() / sphere.volume_mm3() - 1.0).abs();
        prop_assert!(error < 1e-9 || error < 0.05 * missing.len() as f64, "{}", error);
    }

    /// Neighbouring triangles that are divided differently, with noise: nothing of the volume is
    /// lost, and no hole has to be filled.
    #[test]
    fn t_junctions_are_closed(
        sides in 3_u32..9,
        depth in 1_u32..4,
        choices in prop::collection::vec(any::<bool>(), 50..400),
        noise in prop::option::of(1e-7..1e-4_f64),
        painted: bool,
    ) {
        let mesh = prism(sides);
        let mut at = 0;
        let mut choice = || {
            at += 1;
            choices[at % choices.len()]
        };
        let mut divided = Vec::new();
        for &triangle in mesh.triangles() {
            divide(mesh.corners(triangle), depth, &mut choice, &mut divided);
        }
        let noise = noise.unwrap_or_default();
        let mut sign = || if choice() { noise } else { -noise };
        let corners: Vec<[f64; 3]> =
            divided.iter().flatten().map(|corner| corner.map(|value| value + sign())).collect();
        let triangles: Vec<[u32; 3]> =
            (0..divided.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let mut split = body(Mesh::new(corners, triangles).unwrap());
        if painted {
            split.paint = vec![3; divided.len()];
        }
        let done = split.repair(&RepairSettings::default(), &Control::default()).unwrap();
        prop_assert!(is_closed(&split.mesh));
        prop_assert_eq!(done.closed_holes, 0);
        prop_assert!(!painted || split.paint.len() == split.mesh.triangles().len());
        let error = (split.mesh.volume_mm3() / mesh.volume_mm3() - 1.0).abs();
        prop_assert!(error < if noise > 0.0 { 1e-3 } else { 1e-9 }, "{}", error);
    }

    #[test]
    fn any_surface_is_closed_or_refused(
        points in prop::collection::vec([-3..3_i8, -3..3_i8, -3..3_i8], 3..12),
        corners in prop::collection::vec(any::<[prop::sample::Index; 3]>(), 1..40),
        painted: bool,
    ) {
        let vertices: Vec<[f64; 3]> = points.iter().map(|point| point.map(f64::from)).collect();
        let vertex = |index: prop::sample::Index| index.index(vertices.len()) as u32;
        let triangles: Vec<[u32; 3]> =
            corners.iter().map(|corners| corners.map(vertex)).collect();
        let mut any = body(Mesh::new(vertices, triangles).unwrap());
        if painted {
            any.paint = vec![3; any.mesh.triangles().len()];
        }
        if any.repair(&RepairSettings::default(), &Control::default()).is_ok() {
            prop_assert!(is_closed(&any.mesh));
            prop_assert!(!painted || any.paint.len() == any.mesh.triangles().len());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_ray_tree_misses_no_triangle_above_a_point(
        corners in prop::collection::vec(prop::array::uniform3(-8_i32..8), 60),
        points in prop::collection::vec(prop::array::uniform3(-8_i32..8), 8),
        triangles in prop::collection::vec(prop::array::uniform3(0_u32..60), 1..200),
    ) {
        let vertices: Vec<[f64; 3]> = corners.iter().map(|corner| corner.map(f64::from)).collect();
        let mesh = Mesh::new(vertices, triangles).unwrap();
        let tree = RayTree::new(&mesh, &mut Work::new(&Control::default(), 1, 0)).unwrap();
        for point in points.iter().map(|point| point.map(|value| f64::from(value) + 0.25)) {
            let crosses = |triangle: u32| {
                crossing(mesh.corners(mesh.triangles()[triangle as usize]), point) != 0
            };
            let all = 0..mesh.triangles().len() as u32;
            let mut found = Vec::new();
            let visited = tree.each_above(point, |triangle| found.push(triangle));
            prop_assert!(visited <= mesh.triangles().len());
            found.retain(|&triangle| crosses(triangle));
            found.sort_unstable();
            prop_assert_eq!(found, all.filter(|&triangle| crosses(triangle)).collect::<Vec<_>>());
        }
    }
}
