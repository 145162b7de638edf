//! Traits of files from public bug reports, from the bytes of the file to the layers of the part.
//!
//! The report that a test is modelled on is named above it.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

use beadwork_base::Control;
use beadwork_mesh::{
    Format, MaterialRule, Mesh, Model, Placement, ReadLimits, RepairSettings, Solid,
};
use beadwork_part::slice::{Layers, Settings, slice};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A binary STL file.
fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    for &triangle in mesh.triangles() {
        bytes.extend([0; 12]);
        for value in mesh.corners(triangle).into_iter().flatten() {
            bytes.extend((value as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// Reads, repairs, places and slices a file.
fn sliced(format: Format, bytes: &[u8], settings: &Settings) -> (Model, Layers) {
    let control = Control::default();
    let mut model = Model::read(format, bytes, &ReadLimits::default(), &control).unwrap();
    for body in &mut model.bodies {
        body.repair(&RepairSettings::default(), &control).unwrap();
    }
    model.assign_materials(MaterialRule::Stated);
    Placement { bed_mm: [2000.0; 3], ..Placement::default() }.apply(&mut model).unwrap();
    let layers = slice(&model, settings, &control).unwrap();
    (model, layers)
}

/// Volume in mm³ of the cells of each material.
fn volumes(layers: &Layers) -> Vec<f64> {
    let mut volumes = vec![0.0; layers.tools() as usize];
    for layer in layers.layers.iter().flatten() {
        for material in layer.materials().iter().filter(|&&material| material != u8::MAX) {
            volumes[usize::from(*material)] += layers.frame.cell_mm3();
        }
    }
    volumes
}

// prusa3d/PrusaSlicer#5833: float32 coordinates away from the origin
#[test]
fn ten_thousand_boxes_of_whole_beads_are_exact() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5833);
    for number in 0..10_000 {
        let beads: [u32; 3] =
            [random.random_range(1..60), random.random_range(1..60), random.random_range(1..6)];
        let cell_mm = f64::from(random.random_range(20..120_u32)) / 100.0;
        let layer_mm = f64::from(random.random_range(5..40_u32)) / 100.0;
        let size_mm = [0, 1, 2]
            .map(|axis| f64::from(beads[axis]) * if axis == 2 { layer_mm } else { cell_mm });
        let corner: [f64; 3] = [0; 3].map(|_| random.random_range(-1000.0..1000.0));
        let mut mesh = Solid::Cuboid { size_mm }.mesh();
        mesh.map_vertices(|at| [0, 1, 2].map(|axis| at[axis] + corner[axis]), false);
        let settings = Settings { cell_mm, layer_mm, ..Settings::default() };
        let (_, layers) = sliced(Format::Stl, &stl(&mesh), &settings);
        let size = [layers.frame.width, layers.frame.height, layers.layers.len() as u32];
        assert_eq!(size, beads, "box {number}, {size_mm:?} mm at {corner:?}");
        assert_eq!(layers.cell_count(), u64::from(beads[0] * beads[1] * beads[2]));
        // The grid is centred on the part.
        let [left, front, right, back] = layers.frame.sides_mm();
        let off_mm = [(left + right) / 2.0 - 1000.0, (front + back) / 2.0 - 1000.0];
        assert!(off_mm.iter().all(|off| off.abs() < 1e-9), "{off_mm:?}");
    }
}

/// An OBJ file of boxes, each with a material of its own.
fn obj(boxes: &[([f64; 3], [f64; 3])]) -> String {
    let mut text = String::new();
    for (number, (min, size_mm)) in boxes.iter().enumerate() {
        let mesh = Solid::Cuboid { size_mm: *size_mm }.mesh();
        for vertex in mesh.vertices() {
            let [x, y, z] = [0, 1, 2].map(|axis| vertex[axis] + min[axis]);
            text += &format!("v {x} {y} {z}\n");
        }
        text += &format!("g group{number}\nusemtl colour{number}\n");
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|vertex| vertex as usize + 8 * number + 1);
            text += &format!("f {a} {b} {c}\n");
        }
    }
    text
}

// CNCKitchen/stlTexturizer#110: lettering and inlays as groups of one object
#[test]
fn shells_of_one_colour_that_touch_or_overlap_keep_their_volumes() {
    let (plate, pillar) = (([0.0; 3], [10.0, 10.0, 5.0]), ([3.0, 3.0, 0.0], [4.0, 4.0, 5.0]));
    let beside = ([10.0, 0.0, 0.0], [5.0, 10.0, 5.0]);
    for (boxes, expected) in [
        (vec![plate, beside], vec![500.0, 250.0]),
        (vec![plate, pillar], vec![420.0, 80.0]),
        (vec![pillar, plate], vec![80.0, 420.0]),
        (vec![pillar, plate, beside], vec![80.0, 420.0, 250.0]),
        (vec![([0.0; 3], [1.0, 1.0, 0.25]), ([1.0, 0.0, 0.0], [1.0, 1.0, 0.25])], vec![0.25; 2]),
    ] {
        let (_, layers) = sliced(Format::Obj, obj(&boxes).as_bytes(), &Settings::default());
        assert_eq!(volumes(&layers), expected);
    }
}
