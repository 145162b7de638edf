//! Areas compared with cells.

use beadwork_mesh::{Body, Mesh, Model, Solid, Transform};
use proptest::prelude::*;

use super::*;
use crate::simplify::squared_to_line;
use crate::slice::{FillRule, Layers};

/// Distance in mm from borders within which points may belong to either side.
const BORDER_MM: f64 = 1e-3;

/// Whether a point is inside an area, and its distance to the border in mm.
fn inside(area: &Area, [x, y]: [f64; 2]) -> (bool, f64) {
    let (mut is_inside, mut squared) = (false, f64::INFINITY);
    for ring in area.rings() {
        for (&from, &to) in ring.iter().zip(ring.iter().skip(1).chain(ring.first())) {
            if (from[1] <= y) != (to[1] <= y) {
                let at = from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
                is_inside ^= at > x;
            }
            squared = squared.min(squared_to_line([x, y], from, to));
        }
    }
    (is_inside, squared.sqrt())
}

/// Compares the material of every cell centre that is not near a border.
fn compare(layers: &Layers, areas: &[LayerAreas]) -> Result<(), TestCaseError> {
    prop_assert_eq!(layers.layers.len(), areas.len());
    let frame = &layers.frame;
    let voxels = layers.voxels();
    for (number, layer) in areas.iter().enumerate() {
        let materials: Vec<u8> = layer.areas.iter().map(|each| each.material).collect();
        prop_assert!(materials.is_sorted_by(|a, b| a < b), "{materials:?}");
        for y in 0..frame.height {
            for x in 0..frame.width {
                let centre = frame.centre(x, y);
                let found: Vec<(u8, bool, f64)> = layer
                    .areas
                    .iter()
                    .map(|each| (each.material, inside(&each.area, centre)))
                    .map(|(material, (is_inside, border))| (material, is_inside, border))
                    .collect();
                if found.iter().any(|&(_, _, border)| border < BORDER_MM) {
                    continue;
                }
                let has: Vec<u8> = found.iter().filter(|it| it.1).map(|it| it.0).collect();
                let expected: Vec<u8> = voxels.material(x, y, number).into_iter().collect();
                prop_assert_eq!(has, expected, "layer {} at {:?}", number, centre);
            }
        }
    }
    Ok(())
}

/// The sum of the sizes and the size of the union of a layer's areas.
fn sizes(layer: &LayerAreas) -> (f64, f64) {
    (layer.areas.iter().map(|each| each.area.size_mm2()).sum(), layer.union().size_mm2())
}

fn cylinder(radius: f64, corners: u32, height: f64) -> Mesh {
    let corner = |i: u32| {
        let angle = (f64::from(i) + 0.3) * std::f64::consts::TAU / f64::from(corners);
        [radius * angle.cos(), radius * angle.sin()]
    };
    Solid::Prism { outline_mm: (0..corners).map(corner).collect(), z_mm: [0.0, height] }.mesh()
}

/// A shape at a position, rotated about z.
fn shape() -> impl Strategy<Value = Mesh> {
    let kind = (0..3, 1.0..6.0_f64, 0.5..6.0_f64, 3_u32..30);
    (kind, [0.0..8.0_f64, 0.0..8.0_f64], 0.0..90.0_f64).prop_map(
        |((kind, size, other, corners), [x, y], degrees)| {
            let mut mesh = match kind {
                0 => Solid::Cuboid { size_mm: [size, other, 1.0] }.mesh(),
                1 => cylinder(size / 2.0, corners, 1.0),
                _ => Solid::Frustum { sides_mm: [size, size / 2.0], height_mm: 1.0 }.mesh(),
            };
            let to = Transform::translation([x, y, 0.0]);
            Transform::rotation(2, degrees).then(&to).apply(&mut mesh);
            mesh
        },
    )
}

fn body() -> impl Strategy<Value = Body> {
    let role = prop_oneof![
        4 => Just(Role::Solid),
        1 => Just(Role::Modifier),
        1 => Just(Role::Negative),
    ];
    (shape(), role, 0_usize..3, 0_u8..4, any::<bool>()).prop_map(
        |(mesh, role, object, material, is_painted)| {
            let paint = if is_painted && role != Role::Negative {
                (0..mesh.triangles().len()).map(|at| (at / 2 % 3) as u8).collect()
            } else {
                Vec::new()
            };
            Body { mesh, role, object, material: Some(material.into()), paint, ..Body::default() }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Random bodies of all roles, painted or not, of up to three objects.
    #[test]
    fn points_have_the_material_of_their_cells(
        mut bodies in prop::collection::vec(body(), 1..7),
        is_odd: bool,
    ) {
        bodies.sort_by_key(|body| body.object);
        let fill_rule = if is_odd { FillRule::EvenOdd } else { FillRule::NonZero };
        let settings = Settings { cell_mm: 0.4, layer_mm: 0.4, fill_rule, ..Settings::default() };
        let control = Control::default();
        let model = Model { bodies, ..Model::default() };
        // Models without solid bodies are refused.
        let Ok(cut) = Cut::new(&model, &settings, &control) else { return Ok(()) };
        if let (Ok(layers), Ok(areas)) =
            (cut.layers(&settings, &control), cut.areas(&settings, &control))
        {
            compare(&layers, &areas)?;
            for layer in &areas {
                let (sum, union) = sizes(layer);
                prop_assert!((sum - union).abs() < 1e-3, "{sum} {union}");
            }
        }
    }
}

fn solid(mesh: Mesh, material: usize) -> Body {
    Body { mesh, material: Some(material), ..Body::default() }
}

fn areas_of(bodies: Vec<Body>) -> Result<Vec<LayerAreas>, SliceError> {
    let (settings, control) = (Settings::default(), Control::default());
    let model = Model { bodies, ..Model::default() };
    Cut::new(&model, &settings, &control)?.areas(&settings, &control)
}

#[test]
fn bodies_that_touch_share_their_border() {
    let mut right = Solid::Cuboid { size_mm: [2.7, 4.0, 1.0] }.mesh();
    Transform::translation([1.3, 0.0, 0.0]).apply(&mut right);
    let left = || Solid::Cuboid { size_mm: [1.3, 4.0, 1.0] }.mesh();
    let two = areas_of(vec![solid(left(), 0), solid(right.clone(), 1)]).unwrap();
    let (sum, union) = sizes(&two[0]);
    assert!((sum - 16.0).abs() < 1e-4 && (union - 16.0).abs() < 1e-4);
    assert_eq!(two[0].union().components().len(), 1);
    let one = areas_of(vec![solid(left(), 3), solid(right, 3)]).unwrap();
    assert_eq!((one[0].areas.len(), one[0].areas[0].material), (1, 3));
    assert_eq!(one[0].areas[0].area.components(), two[0].union().components());
}

#[test]
fn colours_divide_the_inside_of_the_outline() {
    let mesh = cylinder(5.0, 100, 1.0);
    let paint = (0..mesh.triangles().len()).map(|at| (at * 4 / mesh.triangles().len()) as u8);
    let painted = Body { paint: paint.collect(), ..solid(mesh.clone(), 0) };
    let (plain, painted) = (areas_of(vec![solid(mesh, 0)]), areas_of(vec![painted]));
    let (plain, painted) = (plain.unwrap(), painted.unwrap());
    assert!(painted.iter().all(|layer| layer.areas.len() > 1));
    for (plain, painted) in plain.iter().zip(&painted) {
        let (sum, union) = sizes(painted);
        let size = plain.areas[0].area.size_mm2();
        assert!((sum - size).abs() < 1e-4 && (union - size).abs() < 1e-4, "{sum} {union} {size}");
        let around = painted.union();
        assert!(around.difference(&plain.areas[0].area).size_mm2() < 1e-4);
    }
}

#[test]
fn layers_without_anything_are_refused() {
    let cube = || Solid::Cuboid { size_mm: [2.0; 3] }.mesh();
    let negative = Body { role: Role::Negative, material: None, ..solid(cube(), 0) };
    let error = areas_of(vec![solid(cube(), 0), negative]).unwrap_err().to_string();
    assert!(error.ends_with("or negative bodies remove all of it"), "{error}");
    let thin = Solid::Cuboid { size_mm: [2.0, 0.1, 2.0] }.mesh();
    // Areas may be thinner than a cell.
    let size = areas_of(vec![solid(thin, 0)]).unwrap()[3].union().size_mm2();
    assert!((size - 0.2).abs() < 1e-6);
}
