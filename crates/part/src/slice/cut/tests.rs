//! Cells compared with rays through the mesh, phases of the grid, and refused input.

use std::sync::Mutex;

use beadwork_base::{CancelToken, Progress};
use proptest::prelude::*;

use super::*;
use crate::slice::{FillRule, Layer, Voxels, cut};
use beadwork_mesh::{Material, MaterialRule, Mesh, Solid, Transform};

fn body(mesh: Mesh, material: usize) -> Body {
    Body { name: String::new(), mesh, material: Some(material), ..Body::default() }
}

fn moved(shape: &Solid, by: [f64; 3]) -> Mesh {
    let mut mesh = shape.mesh();
    Transform::translation(by).apply(&mut mesh);
    mesh
}

fn model(bodies: Vec<Body>) -> Model {
    Model { bodies, ..Model::default() }
}

/// Winding number of the surface around a point: the triangles straight above it, those that face
/// down counted negative.
fn winding(mesh: &Mesh, [x, y, z]: [f64; 3]) -> i32 {
    let mut winding = 0;
    for &triangle in mesh.triangles() {
        let [a, b, c] = mesh.corners(triangle);
        let side =
            |p: [f64; 3], q: [f64; 3]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        let sides = [side(a, b), side(b, c), side(c, a)];
        let is_up = sides.iter().all(|&side| side > 0.0);
        if is_up || sides.iter().all(|&side| side < 0.0) {
            let area: f64 = sides.iter().sum();
            let height = (sides[1] * a[2] + sides[2] * b[2] + sides[0] * c[2]) / area;
            if height > z {
                winding += if is_up { 1 } else { -1 };
            }
        }
    }
    winding
}

#[test]
fn a_box_is_its_cells() {
    let cuboid = moved(&Solid::Cuboid { size_mm: [10.0, 5.0, 2.0] }, [100.0, 50.0, 0.0]);
    let layers =
        slice(&model(vec![body(cuboid, 3)]), &Settings::default(), &Control::default()).unwrap();
    assert_eq!((layers.frame.width, layers.frame.height, layers.layers.len()), (20, 10, 8));
    assert_eq!((layers.frame.left_mm, layers.frame.back_mm), (100.0, 55.0));
    assert!(layers.layers.iter().flatten().all(|layer| layer.region.is_rectangle()));
    assert_eq!((layers.tools(), layers.cell_count()), (4, 1600));
    let voxels = layers.voxels();
    assert_eq!(
        (voxels.count(), voxels.material(19, 9, 7), voxels.material(20, 0, 0)),
        (1600, Some(3), None)
    );
    assert!((voxels.volume_mm3() - 100.0).abs() < 1e-9);
    assert_eq!(voxels.region(0).unwrap(), layers.layers[0].as_ref().unwrap().region);
}

#[test]
fn empty_layers_are_found() {
    let cube = |z: f64| body(moved(&Solid::Cuboid { size_mm: [2.0, 2.0, 1.0] }, [0.0, 0.0, z]), 0);
    let layers = |bodies| slice(&model(bodies), &Settings::default(), &Control::default()).unwrap();
    let sound = layers(vec![cube(0.0), cube(1.0)]);
    assert_eq!((sound.empty_below(), sound.gap()), (0, None));
    let hovering = layers(vec![cube(0.5)]);
    assert_eq!((hovering.empty_below(), hovering.gap()), (2, None));
    let apart = layers(vec![cube(0.5), cube(3.0)]);
    assert_eq!((apart.empty_below(), apart.gap()), (2, Some(6)));
}

#[test]
fn touching_bodies_share_no_cell_and_later_bodies_win() {
    let left = moved(&Solid::Cuboid { size_mm: [1.3, 4.0, 1.0] }, [0.0; 3]);
    let right = moved(&Solid::Cuboid { size_mm: [2.7, 4.0, 1.0] }, [1.3, 0.0, 0.0]);
    let inlay = moved(&Solid::Cuboid { size_mm: [1.0, 1.0, 0.5] }, [1.0, 1.0, 0.5]);
    let layers = slice(
        &model(vec![body(left, 0), body(right, 1), body(inlay, 2)]),
        &Settings::default(),
        &Control::default(),
    )
    .unwrap();
    let zones = |layer: usize| layers.layers[layer].as_ref().unwrap().zones.clone();
    let count =
        |layer: usize, zone: u8| zones(layer).ids().iter().filter(|&&id| id == zone).count();
    assert!(layers.layers[0].as_ref().unwrap().region.is_rectangle());
    assert_eq!((count(0, 0), count(0, 1), count(0, 2)), (24, 40, 0));
    assert_eq!((count(3, 0), count(3, 1), count(3, 2)), (22, 38, 4));
}

#[test]
fn colours_of_a_body_do_not_depend_on_the_size_of_the_grid() {
    let coloured = |x: f64| {
        let mut body = body(moved(&Solid::Sphere { radius_mm: 3.0, steps: 6 }, [x, 0.0, 3.0]), 0);
        body.paint = (0..body.mesh.triangles().len()).map(|at| (at % 5) as u8).collect();
        body
    };
    let [alone, both] = [vec![coloured(0.0)], vec![coloured(0.0), coloured(40.0)]]
        .map(|bodies| slice(&model(bodies), &Settings::default(), &Control::default()).unwrap());
    let count = |layers: &Layers, zone: u8| {
        layers.voxels().materials().iter().filter(|&&id| id == zone).count()
    };
    assert!(count(&alone, 4) > 0);
    for zone in 0..5 {
        assert_eq!(2 * count(&alone, zone), count(&both, zone));
    }
    let (small, large) = (alone.voxels(), both.voxels());
    let is_same = |x: u32, y: u32, z: usize| large.material(x, y, z) == small.material(x, y, z);
    assert!((0..alone.layers.len()).all(|z| {
        (0..alone.frame.height).all(|y| (0..alone.frame.width).all(|x| is_same(x, y, z)))
    }));
}

#[test]
fn colours_reach_the_nearest_cells() {
    // `Solid` lists the triangles of a box as two for each face: bottom and top, then the sides,
    // beginning with the front.
    let mut coloured = body(moved(&Solid::Cuboid { size_mm: [10.0, 10.0, 1.0] }, [0.0; 3]), 0);
    coloured.paint = vec![0; 12];
    coloured.paint[4..6].fill(1);
    // Without the colours of top and bottom.
    let settings = Settings { colour_depth_mm: 0.0, ..Settings::default() };
    let layers = slice(&model(vec![coloured]), &settings, &Control::default()).unwrap();
    let layer = layers.layers[1].as_ref().unwrap();
    let at = |x: u32, y: u32| layer.zones.id(layer.region.cell(x, y));
    // The front is row 19; the border between the colours runs along the diagonals.
    assert_eq!([at(10, 19), at(10, 11), at(10, 8), at(0, 15), at(19, 3)], [1, 1, 0, 0, 0]);
}

#[test]
fn colours_of_top_faces_reach_down() {
    let mut coloured = body(moved(&Solid::Cuboid { size_mm: [10.0, 10.0, 3.0] }, [0.0; 3]), 0);
    coloured.paint = vec![0; 12];
    let is_top = |corners: [[f64; 3]; 3]| corners.iter().all(|corner| corner[2] == 3.0);
    for (triangle, colour) in coloured.mesh.triangles().iter().zip(&mut coloured.paint) {
        *colour = u8::from(is_top(coloured.mesh.corners(*triangle)));
    }
    let coloured = model(vec![coloured]);
    let counts = |colour_depth_mm: f64| -> Vec<usize> {
        let settings = Settings { colour_depth_mm, ..Settings::default() };
        let layers = slice(&coloured, &settings, &Control::default()).unwrap().layers;
        let count = |layer: &Layer| layer.materials().iter().filter(|&&id| id == 1).count();
        layers.iter().flatten().map(count).collect()
    };
    // The walls keep the cells that are nearer to them than to the top: none of 20 x 20 in the top
    // layer, then one ring of cells, and two from 0.75 mm, but for a few in the corners.
    let reached = counts(1.0);
    assert_eq!(reached[..8], [0; 8]);
    assert!((16 * 16..16 * 16 + 4).contains(&reached[8]), "{reached:?}");
    assert_eq!(reached[9..], [18 * 18, 18 * 18, 20 * 20]);
    assert_eq!(counts(0.0), [0; 12]);
}

#[test]
fn shells_within_shells_follow_the_rule() {
    let outer = Solid::Cuboid { size_mm: [4.0, 4.0, 1.0] }.mesh();
    let inner = moved(&Solid::Cuboid { size_mm: [2.0, 2.0, 1.0] }, [1.0, 1.0, 0.0]);
    let base = outer.vertices().len() as u32;
    let vertices = [outer.vertices(), inner.vertices()].concat();
    let shifted: Vec<[u32; 3]> =
        inner.triangles().iter().map(|corners| corners.map(|vertex| vertex + base)).collect();
    let both = Mesh::new(vertices, [outer.triangles(), &shifted[..]].concat()).unwrap();
    let count = |rule| {
        let settings = Settings { fill_rule: rule, ..Settings::default() };
        slice(&model(vec![body(both.clone(), 0)]), &settings, &Control::default())
            .unwrap()
            .cell_count()
    };
    assert_eq!((count(FillRule::NonZero), count(FillRule::EvenOdd)), (256, 192));
}

#[test]
fn invalid_input_is_refused() {
    let cube = || vec![body(moved(&Solid::Cuboid { size_mm: [4.0; 3] }, [0.0; 3]), 0)];
    let refused = |bodies: Vec<Body>, settings: Settings| {
        slice(&model(bodies), &settings, &Control::default()).unwrap_err().to_string()
    };
    let settings =
        |cell_mm: f64, layer_mm: f64| Settings { cell_mm, layer_mm, ..Settings::default() };
    assert_eq!(
        refused(cube(), settings(0.0, 0.2)),
        "the bead width is 0 mm: it must be more than 0"
    );
    assert_eq!(
        refused(cube(), settings(0.4, -1.0)),
        "the layer height is -1 mm: it must be more than 0"
    );
    assert_eq!(
        refused(cube(), settings(f64::NAN, 0.2)),
        "the bead width is NaN mm: it must be more than 0"
    );
    assert!(
        refused(cube(), settings(1e-4, 0.2))
            .starts_with("beads of 0.0001 mm make a layer of 40000 x 40000 cells")
    );
    assert!(refused(cube(), settings(0.01, 0.0001)).ends_with("are more than 1073741824 cells"));
    assert!(refused(cube(), settings(0.5, 20.0)).starts_with("no layer has a cell"));
    assert!(refused(vec![], settings(0.5, 0.5)).starts_with("no layer has a cell"));
    let mut without = cube();
    without[0].material = None;
    assert!(refused(without, Settings::default()).starts_with("body 0 has no material"));
    let phase = |phase| Settings { phase, ..Settings::default() };
    assert_eq!(
        refused(cube(), phase([0.0, 1.0])),
        "the grid phase along y is 1: it must be at least 0 and below 1"
    );
    assert!(refused(cube(), phase([f64::NAN, 0.0])).starts_with("the grid phase along x is NaN"));
    let cut = Cut::new(&model(cube()), &Settings::default(), &Control::default()).unwrap();
    assert_eq!(
        cut.layers(&settings(0.5, 0.2), &Control::default()).unwrap_err().to_string(),
        "the layer height is 0.2 mm, but the model was cut at 0.25 mm"
    );
}

#[test]
fn cancelling_and_time_limits_are_told_apart() {
    let cube = model(vec![body(moved(&Solid::Cuboid { size_mm: [4.0; 3] }, [0.0; 3]), 0)]);
    let cancel = CancelToken::new();
    cancel.cancel();
    let cancelled = Control { cancel: Some(&cancel), ..Control::default() };
    let error = slice(&cube, &Settings::default(), &cancelled);
    assert_eq!(error, Err(SliceError::Interrupted(Interrupted::Cancelled)));
    let late = Control { time_is_up: Some(&|| true), ..Control::default() };
    let error = Cut::new(&cube, &Settings::default(), &late);
    assert_eq!(error, Err(SliceError::Interrupted(Interrupted::TimeUp)));
}

#[test]
fn progress_counts_the_layers_that_are_cut_and_filled() {
    // 16 layers; each body is cut in those it reaches and two more above.
    let cube = |z: f64| body(moved(&Solid::Cuboid { size_mm: [2.0, 2.0, 2.0] }, [0.0, 0.0, z]), 0);
    let seen = Mutex::new(Vec::new());
    let observe = |progress: Progress| seen.lock().unwrap().push((progress.done, progress.total));
    let control = Control { progress: Some(&observe), ..Control::default() };
    slice(&model(vec![cube(0.0), cube(2.0)]), &Settings::default(), &control).unwrap();
    let total = (8 + 2) + (8 + 2) + 16;
    assert_eq!(
        seen.into_inner().unwrap(),
        (1..=total).map(|done| (done, total)).collect::<Vec<_>>()
    );
}

#[test]
fn one_cut_serves_all_grids() {
    let mut ball = body(moved(&Solid::Sphere { radius_mm: 3.0, steps: 9 }, [0.1, 0.2, 3.0]), 0);
    ball.paint = (0..ball.mesh.triangles().len()).map(|at| (at % 3) as u8).collect();
    let cube = body(moved(&Solid::Cuboid { size_mm: [2.0; 3] }, [2.0, 0.0, 0.0]), 1);
    let model = model(vec![ball, cube]);
    let control = Control::default();
    let cut = Cut::new(&model, &Settings::default(), &control).unwrap();
    for cell_mm in [0.45, 0.5, 0.55] {
        for phase in [[0.0; 2], [0.5, 0.0], [0.3, 0.9]] {
            let settings = Settings { cell_mm, phase, ..Settings::default() };
            assert_eq!(cut.layers(&settings, &control), slice(&model, &settings, &control));
        }
    }
}

#[test]
fn a_phase_shifts_the_grid_by_a_fraction_of_a_cell() {
    let ball =
        model(vec![body(moved(&Solid::Sphere { radius_mm: 3.1, steps: 8 }, [50.0, 40.0, 3.1]), 0)]);
    let control = Control::default();
    let sliced = |phase: [f64; 2]| {
        slice(&ball, &Settings { phase, ..Settings::default() }, &control).unwrap()
    };
    let at_zero = sliced([0.0; 2]).frame;
    assert_eq!((at_zero.width, at_zero.height), (13, 13));
    for phase in [[0.25, 0.0], [0.0, 0.4], [0.9, 0.6]] {
        let layers = sliced(phase);
        let frame = layers.frame;
        let moved = [frame.left_mm - at_zero.left_mm, frame.back_mm - at_zero.back_mm];
        for axis in 0..2 {
            let rest = (moved[axis] / 0.5 - phase[axis]).rem_euclid(1.0);
            assert!(rest.min(1.0 - rest) < 1e-9, "{phase:?}");
        }
        let [left, front, right, back] = frame.sides_mm();
        assert!(left <= 46.9 && right >= 53.1 && front <= 36.9 && back >= 43.1, "{phase:?}");
        assert_ne!(layers.layers[4], sliced([0.0; 2]).layers[4], "{phase:?}");
    }
}

#[test]
fn a_box_of_whole_cells_keeps_its_cells_at_any_phase() {
    let cuboid = moved(&Solid::Cuboid { size_mm: [10.0, 5.0, 2.0] }, [100.0, 50.0, 0.0]);
    let cuboid = model(vec![body(cuboid, 0)]);
    let cells = |phase: [f64; 2]| {
        let settings = Settings { phase, ..Settings::default() };
        let layers = slice(&cuboid, &settings, &Control::default()).unwrap();
        let region = &layers.layers[0].as_ref().unwrap().region;
        let (mut columns, mut rows): (Vec<u32>, Vec<u32>) =
            region.cells().map(|cell| region.xy(cell)).unzip();
        columns.sort_unstable();
        columns.dedup();
        rows.sort_unstable();
        rows.dedup();
        assert_eq!(region.cell_count() as usize, columns.len() * rows.len());
        (columns.len(), rows.len(), layers.frame.width, layers.frame.height)
    };
    assert_eq!(cells([0.0; 2]), (20, 10, 20, 10));
    assert_eq!(cells([0.3, 0.0]), (20, 10, 21, 10));
    assert_eq!(cells([0.0, 0.7]), (20, 10, 20, 11));
    assert_eq!(cells([0.2, 0.9]), (20, 10, 21, 11));
}

#[test]
fn materials_of_a_layer_are_indexed_by_row_and_column() {
    let cuboid = moved(&Solid::Cuboid { size_mm: [2.0, 1.0, 0.5] }, [0.0; 3]);
    let layers =
        slice(&model(vec![body(cuboid, 3)]), &Settings::default(), &Control::default()).unwrap();
    let layer = layers.layers[0].as_ref().unwrap();
    assert_eq!(layer.materials().dim(), (2, 4));
    assert!(layer.materials().iter().all(|&material| material == 3));
    assert_eq!(layers.voxels().layer(1), layer.materials());
    assert_eq!(Voxels::EMPTY, Zones::OUTSIDE);
    let outlines =
        cut(&Solid::Cuboid { size_mm: [2.0, 1.0, 0.5] }.mesh(), &[], 0.25, 2, &Control::default());
    assert_eq!(outlines.unwrap()[1].area_mm2(), 2.0);
}

/// A box of an object, from `x` to `x + width`, with a square cross-section of 2 mm.
fn bar(role: Role, object: usize, material: Option<usize>, x: f64, width: f64) -> Body {
    let mesh = moved(&Solid::Cuboid { size_mm: [width, 2.0, 2.0] }, [x, 0.0, 0.0]);
    Body { mesh, role, object, material, ..Body::default() }
}

// prusa3d/PrusaSlicer#15694
#[test]
fn negative_bodies_and_modifiers_affect_their_object_only() {
    // Along x: object 0 is 4 mm long; 1 mm of it is removed, and 1 mm has another material.
    // Object 1 covers a part of what is removed and what is modified.
    let bodies = vec![
        bar(Role::Negative, 0, None, 1.0, 1.0),
        bar(Role::Modifier, 0, Some(1), 2.0, 9.0),
        bar(Role::Solid, 0, Some(0), 0.0, 4.0),
        bar(Role::Solid, 1, Some(2), 1.5, 1.0),
    ];
    let layers = slice(&model(bodies), &Settings::default(), &Control::default()).unwrap();
    for layer in layers.layers {
        let layer = layer.unwrap();
        for row in layer.materials().rows() {
            assert_eq!(row.to_vec(), [0, 0, Voxels::EMPTY, 2, 2, 1, 1, 1]);
        }
    }
}

/// Each object is filled like a model of its own.
#[test]
fn objects_with_modifiers_leave_nothing_to_the_next_one() {
    // The modifier and the negative body of object 0 reach over object 1.
    let bodies = vec![
        bar(Role::Solid, 0, Some(0), 0.0, 2.0),
        bar(Role::Modifier, 0, Some(1), 1.0, 9.0),
        bar(Role::Negative, 0, None, 1.5, 9.0),
        bar(Role::Solid, 1, Some(2), 2.0, 2.0),
        bar(Role::Modifier, 1, Some(3), 3.5, 0.5),
        bar(Role::Solid, 2, Some(4), 4.5, 0.5),
        bar(Role::Negative, 2, None, 0.0, 1.0),
    ];
    let layers = slice(&model(bodies), &Settings::default(), &Control::default()).unwrap();
    for layer in layers.layers {
        for row in layer.unwrap().materials().rows() {
            let empty = Voxels::EMPTY;
            assert_eq!(row.to_vec(), [0, 0, 1, empty, 2, 2, 2, 3, empty, 4]);
        }
    }
}

// prusa3d/PrusaSlicer#15694, where nothing is left
#[test]
fn negative_bodies_that_remove_everything_are_named() {
    let bodies =
        vec![bar(Role::Solid, 0, Some(0), 0.0, 4.0), bar(Role::Negative, 0, None, -1.0, 9.0)];
    let model = model(bodies);
    let (settings, control) = (Settings::default(), Control::default());
    let error = slice(&model, &settings, &control).unwrap_err().to_string();
    assert!(error.ends_with("or negative bodies remove all of it"), "{error}");
    // Beside another object.
    let mut bodies = model.bodies;
    bodies.push(bar(Role::Solid, 1, Some(0), 20.0, 1.0));
    let model = Model { bodies, ..Model::default() };
    let cut = Cut::new(&model, &settings, &control).unwrap();
    let layers = cut.layers(&settings, &control).unwrap();
    let [removed, negative, other] = cut.coverage(&layers, &settings, &control).unwrap()[..] else {
        panic!("three bodies")
    };
    assert!(removed.cells > 0 && removed.own_cells == 0);
    assert!(negative.cells >= removed.cells);
    assert_eq!((other.cells, other.own_cells), (layers.cell_count(), layers.cell_count()));
}

#[test]
fn materials_are_given_by_rule() {
    let two = || {
        let mut bodies = vec![body(Solid::Cuboid { size_mm: [1.0; 3] }.mesh(), 0); 2];
        bodies[1].material = None;
        let materials = vec![Material { name: "PLA".into(), colour: None }];
        Model { bodies, materials, ..Model::default() }
    };
    let numbers = |rule| {
        let mut model = two();
        model.assign_materials(rule);
        let numbers: Vec<_> = model.bodies.iter().map(|body| body.material).collect();
        (numbers, model.materials.len())
    };
    assert_eq!(numbers(MaterialRule::Stated), (vec![Some(0), Some(1)], 2));
    assert_eq!(numbers(MaterialRule::PerBody), (vec![Some(0), Some(1)], 2));
    assert_eq!(numbers(MaterialRule::Single), (vec![Some(0), Some(0)], 1));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// A cell is filled if a ray upwards from its centre leaves the body more often than it enters.
    #[test]
    fn cells_are_those_with_their_centre_inside(
        steps in 3_u32..12,
        radius in 1.0..4.0_f64,
        shift in (0.0..1.0_f64, 0.0..1.0_f64),
        side in 0.5..6.0_f64,
        cell in 0.3..0.9_f64,
        phase in [0.0..1.0_f64, 0.0..1.0_f64],
        is_shifted: bool,
    ) {
        let mut ball =
            moved(&Solid::Sphere { radius_mm: radius, steps }, [shift.0, shift.1, radius]);
        // Turned, so that no cell centre lies exactly below an edge, where rays are ambiguous.
        Transform::rotation(2, 17.3).then(&Transform::rotation(0, 5.1)).apply(&mut ball);
        let cube = moved(&Solid::Cuboid { size_mm: [side; 3] }, [shift.1, -shift.0, 0.0]);
        let bodies = vec![body(ball, 0), body(cube, 1)];
        let settings = Settings {
            cell_mm: cell,
            layer_mm: 0.4,
            phase: if is_shifted { phase } else { [0.0; 2] },
            ..Settings::default()
        };
        let layers = slice(&model(bodies.clone()), &settings, &Control::default()).unwrap();
        let voxels = layers.voxels();
        for z in 0..voxels.depth {
            for y in 0..voxels.frame.height {
                for x in 0..voxels.frame.width {
                    let [px, py] = voxels.frame.centre(x, y);
                    let point = [px, py, layers.cut_mm(z)];
                    let expected = (0..2_u8)
                        .rev()
                        .find(|&at| winding(&bodies[usize::from(at)].mesh, point) != 0);
                    prop_assert_eq!(
                        voxels.material(x, y, z),
                        expected,
                        "cell ({}, {}, {})",
                        x,
                        y,
                        z
                    );
                }
            }
        }
    }
}
