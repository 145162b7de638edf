//! Boxes of whole beads, from the bytes of an STL file to the cells of the part.
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
fn sliced(bytes: &[u8], settings: &Settings) -> Layers {
    let control = Control::default();
    let mut model = Model::read(Format::Stl, bytes, &ReadLimits::default(), &control).unwrap();
    for body in &mut model.bodies {
        body.repair(&RepairSettings::default(), &control).unwrap();
    }
    model.assign_materials(MaterialRule::Stated);
    Placement { bed_mm: [2000.0; 3], ..Placement::default() }.apply(&mut model).unwrap();
    slice(&model, settings, &control).unwrap()
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
        let layers = sliced(&stl(&mesh), &settings);
        let size = [layers.frame.width, layers.frame.height, layers.layers.len() as u32];
        assert_eq!(size, beads, "box {number}, {size_mm:?} mm at {corner:?}");
        assert_eq!(layers.cell_count(), u64::from(beads[0] * beads[1] * beads[2]));
        // The grid is centred on the part.
        let [left, front, right, back] = layers.frame.sides_mm();
        let off_mm = [(left, right), (front, back)].map(|(a, b)| f64::midpoint(a, b) - 1000.0);
        assert!(off_mm.iter().all(|off| off.abs() < 1e-9), "{off_mm:?}");
    }
}
