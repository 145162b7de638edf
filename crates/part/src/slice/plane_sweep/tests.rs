//! The sweep against an exhaustive search of the triangles in every layer, and outlines of solids
//! with known cross-sections.

use proptest::prelude::*;
use rayon::ThreadPool;

use super::*;
use crate::slice::FillRule;
use beadwork_base::{CancelToken, Progress};
use beadwork_mesh::{Mesh, Solid};

/// The outline in one plane, from a search of all triangles.
fn slow_cut(mesh: &Mesh, colours: &[u8], plane: f64) -> Outline {
    let is_met = |&triangle: &u32| {
        let z = mesh.corners(mesh.triangles()[triangle as usize]).map(|corner| corner[2]);
        z.iter().any(|&z| z < plane) && z.iter().any(|&z| z >= plane)
    };
    let met = (0..mesh.triangles().len() as u32).filter(is_met);
    let mut segments: Vec<Segment> = met.map(|triangle| segment(mesh, triangle, plane)).collect();
    link(mesh, &mut segments, colours, plane)
}

fn pool() -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap()
}

#[test]
fn a_frustum_has_squares_in_all_layers() {
    let mut mesh = Solid::Frustum { sides_mm: [8.0, 4.0], height_mm: 4.0 }.mesh();
    mesh.map_vertices(|[x, y, z]| [x + 1.0, y + 2.0, z], false);
    let outlines = cut(&mesh, &[], 0.5, 9, &Control::default()).unwrap();
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
fn vertices_on_planes_leave_outlines_whole() {
    // Every ring of the sphere's vertices lies on a plane or halfway between two.
    for steps in [4, 8, 16] {
        let mut mesh = Solid::Sphere { radius_mm: 4.0, steps }.mesh();
        mesh.map_vertices(|[x, y, z]| [x, y, ((z + 4.0) * 4.0).round() / 4.0], false);
        let outlines = cut(&mesh, &[], 0.5, 16, &Control::default()).unwrap();
        for outline in &outlines {
            assert_eq!(outline.loops().count(), 1);
            assert!(outline.area_mm2() > 0.0);
        }
    }
}

/// Closed surfaces that are hard to cut: few distinct heights, so that many vertices lie on planes,
/// and shells that overlap, some of them inside out.
fn hard_surfaces() -> impl Strategy<Value = (Mesh, Vec<u8>)> {
    let shell = (2_u32..7, -3..3_i8, -3..3_i8, 0..6_i8, any::<bool>());
    (prop::collection::vec(shell, 1..5), any::<bool>()).prop_map(|(shells, is_coloured)| {
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for (steps, x, y, z, is_inverted) in shells {
            let ball = Solid::Sphere { radius_mm: 3.0, steps }.mesh();
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
        let colours = if is_coloured {
            (0..triangles.len()).map(|at| at as u8 % 5).collect()
        } else {
            Vec::new()
        };
        (Mesh::new(vertices, triangles).unwrap(), colours)
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_sweep_finds_the_triangles_that_a_search_finds(
        (mesh, colours) in hard_surfaces(),
        layer in prop::sample::select(vec![0.3, 0.5, 1.0, 7.0]),
    ) {
        let layers = (9.0_f64 / layer) as usize;
        let outlines = cut(&mesh, &colours, layer, layers, &Control::default()).unwrap();
        prop_assert_eq!(outlines.len(), layers);
        for (number, outline) in outlines.iter().enumerate() {
            prop_assert_eq!(outline, &slow_cut(&mesh, &colours, plane_mm(number, layer)));
        }
    }
}

#[test]
fn threads_change_nothing() {
    let mut mesh = Solid::Sphere { radius_mm: 9.0, steps: 60 }.mesh();
    mesh.map_vertices(|[x, y, z]| [x, y, z + 9.0], false);
    let pool = pool();
    let control = Control::on(Threads::Pool(&pool));
    let on_two = cut(&mesh, &[], 0.1, 180, &control).unwrap();
    assert_eq!(on_two, cut(&mesh, &[], 0.1, 180, &Control::default()).unwrap());
}

#[test]
fn a_cancelled_cut_ends() {
    let mesh = Solid::Sphere { radius_mm: 9.0, steps: 60 }.mesh();
    let cancel = CancelToken::new();
    let stop_after_two = |progress: Progress| {
        assert_eq!(progress.total, 90);
        if progress.done == 2 {
            cancel.cancel();
        }
        assert!(progress.done <= 2);
    };
    let control =
        Control { cancel: Some(&cancel), progress: Some(&stop_after_two), ..Control::default() };
    assert_eq!(cut(&mesh, &[], 0.1, 90, &control), Err(Interrupted::Cancelled));
}
