//! STL and OBJ files.

use std::fmt::Write as _;
use std::fs;

use beadwork_tests::beadwork;
use serde_json::Value;

type Corner = [f64; 3];
type Triangle = [Corner; 3];

/// The triangles of a box, two for each face.
fn cuboid(min: Corner, size_mm: Corner) -> Vec<Triangle> {
    let corner =
        |bits: usize| [0, 1, 2].map(|axis| min[axis] + size_mm[axis] * (bits >> axis & 1) as f64);
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]].map(|bits| bits.map(corner));
    faces.into_iter().flat_map(triangles).collect()
}

fn cube() -> Vec<Triangle> {
    cuboid([0.0; 3], [10.0; 3])
}

/// Moves every corner by up to `by` along each axis, always in the same way.
fn noisy(triangles: &[Triangle], by: f64) -> Vec<Triangle> {
    let mut state = 7_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        by * (f64::from(state >> 8) / f64::from(1 << 23) - 1.0)
    };
    triangles.iter().map(|corners| corners.map(|at| at.map(|value| value + noise()))).collect()
}

fn binary(triangles: &[Triangle], declared: usize) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((declared as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        corners.iter().flatten().for_each(|&value| bytes.extend((value as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text(triangles: &[Triangle]) -> String {
    let mut text = String::from("solid x\n");
    for corners in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in corners {
            writeln!(text, "vertex {x} {y} {z}").expect("a string takes any text");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid x\n"
}

/// Exit code, volume in mm³ of each tool that is used, and stderr of `plan`.
fn plan(files: &[(&str, &[u8])]) -> (Option<i32>, Vec<f64>, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("the folder can be written");
    }
    let names = files.iter().map(|(name, _)| name);
    let output = beadwork()
        .current_dir(folder.path())
        .arg("plan")
        .args(names)
        .args(["--objective", "tools", "--purge", "0", "--tower", "none", "--json"])
        .output()
        .expect("the binary runs");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let document: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    // The printed volumes follow from rounded lengths of filament.
    let volume =
        |tool: &Value| (1e3 * tool["volume_mm3"].as_f64().expect("a number")).round() / 1e3;
    let tools = document["tools"].as_array().into_iter().flatten();
    (output.status.code(), tools.map(volume).filter(|&volume| volume > 0.0).collect(), stderr)
}

/// The volumes of a plan that must succeed, and what it reports.
fn planned(name: &str, bytes: &[u8]) -> (Vec<f64>, String) {
    let (code, volumes, stderr) = plan(&[(name, bytes)]);
    assert_eq!(code, Some(0), "{stderr}");
    (volumes, stderr)
}

/// The error of a plan that must fail.
fn refused(name: &str, bytes: &[u8]) -> String {
    let (code, _, stderr) = plan(&[(name, bytes)]);
    assert_eq!(code, Some(1), "{stderr}");
    stderr
}

// mikedh/trimesh#1720
#[test]
fn the_count_of_a_binary_stl_is_too_small() {
    for declared in [0, 6] {
        let (volumes, stderr) = planned("cube.stl", &binary(&cube(), declared));
        assert_eq!(volumes, [1000.0]);
        assert!(stderr.contains("header declares"), "{stderr}");
    }
    assert!(
        refused("cube.stl", &binary(&cube(), 20)).contains("declares 20 triangles, file holds 12")
    );
}

// christopherpoole/CADMesh#40 and variants
#[test]
fn text_has_another_encoding_or_layout() {
    let plain = text(&cube());
    let utf16: Vec<u8> =
        format!("\u{feff}{plain}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [
        format!("\u{feff}{plain}").into_bytes(),
        plain.replace('\n', "\r").into_bytes(),
        plain.replace('\n', " ").into_bytes(),
        utf16,
    ] {
        assert_eq!(planned("cube.stl", &bytes), (vec![1000.0], String::new()));
    }
}

#[test]
fn the_extension_is_wrong() {
    let error = refused("cube.obj", text(&cube()).as_bytes());
    assert!(error.contains("not a valid OBJ file: content is an STL mesh"), "{error}");
    let error = refused("cube.stl", b"PK\x03\x04");
    assert!(error.contains("not a valid STL file: content is a ZIP archive"), "{error}");
}

// slic3r/Slic3r#4891, prusa3d/PrusaSlicer#14023
#[test]
fn every_triangle_is_off_by_a_little() {
    for noise_mm in [1e-6, 1e-5, 1e-4, 1e-3] {
        let (volumes, stderr) = planned("cube.stl", &binary(&noisy(&cube(), noise_mm), 12));
        assert_eq!(volumes, [1000.0], "{noise_mm}");
        assert!(stderr.contains("near vertices merged"), "{stderr}");
    }
}

// prusa3d/PrusaSlicer#5833
#[test]
fn coordinates_are_far_from_the_origin() {
    for far_mm in [6.2, 999.7, 9999.3] {
        let (volumes, _) = planned("cube.stl", &binary(&cuboid([far_mm; 3], [10.0; 3]), 12));
        assert_eq!(volumes, [1000.0], "{far_mm}");
    }
}

// prusa3d/PrusaSlicer#14343
#[test]
fn a_vertex_is_far_away() {
    for far_mm in [1e6, 1e30] {
        let mut triangles = cube();
        triangles[0][0][0] = far_mm;
        let error = refused("cube.stl", &binary(&triangles, 12));
        assert!(error.contains("is far away from the others"), "{error}");
    }
    let two = [cube(), cuboid([1e6, 0.0, 0.0], [1.0; 3])].concat();
    let error = refused("cube.stl", &binary(&two, 24));
    assert!(error.contains("does not fit"), "{error}");
}

// bambulab/BambuStudio#7158
#[test]
fn a_body_is_thinner_than_a_bead_or_covered() {
    let plate = binary(&cube(), 12);
    let wall = binary(&cuboid([20.3, 0.0, 0.0], [0.2, 10.0, 10.0]), 12);
    let (code, volumes, stderr) = plan(&[("plate.stl", &plate), ("wall.stl", &wall)]);
    assert_eq!((code, volumes.len()), (Some(0), 1), "{stderr}");
    assert!(stderr.contains("body 'wall' has no cells: it is thinner"), "{stderr}");

    let letter = binary(&cuboid([2.0, 2.0, 0.0], [4.0, 4.0, 2.0]), 12);
    let (_, volumes, stderr) = plan(&[("letter.stl", &letter), ("plate.stl", &plate)]);
    assert_eq!(volumes, [1000.0]);
    assert!(stderr.contains("body 'letter' has no cells left"), "{stderr}");

    // A fin of a body.
    let fin = [cube(), cuboid([10.0, 4.4, 0.0], [10.0, 0.1, 10.0])].concat();
    let (_, stderr) = planned("fin.stl", &binary(&fin, 24));
    assert!(stderr.contains("of its outline is too thin"), "{stderr}");
}

/// An OBJ file of groups with a material each; `colours` are written behind the vertices.
fn obj(boxes: &[Vec<Triangle>], materials: bool, colours: &[&str]) -> String {
    let mut file = String::new();
    for (number, triangles) in boxes.iter().enumerate() {
        writeln!(file, "g group {number}").expect("a string takes any text");
        if materials {
            writeln!(file, "usemtl material {number}").expect("a string takes any text");
        }
        for corners in triangles {
            for [x, y, z] in corners {
                let colour = colours.get(number).copied().unwrap_or_default();
                writeln!(file, "v {x} {y} {z} {colour}").expect("a string takes any text");
            }
            file += "f -3 -2 -1\n";
        }
    }
    file
}

// CNCKitchen/stlTexturizer#110
#[test]
fn groups_of_one_object_touch_or_overlap() {
    let pillar = cuboid([3.0, 3.0, 0.0], [4.0, 4.0, 10.0]);
    let beside = cuboid([10.0, 0.0, 0.0], [5.0, 10.0, 10.0]);
    for (boxes, expected) in [
        (vec![cube(), pillar.clone()], vec![840.0, 160.0]),
        (vec![pillar, cube()], vec![160.0, 840.0]),
        (vec![cube(), beside], vec![1000.0, 500.0]),
    ] {
        let (volumes, _) = planned("part.obj", obj(&boxes, true, &[]).as_bytes());
        assert_eq!(volumes, expected);
    }
}

// mikedh/trimesh#2560
#[test]
fn faces_are_concave() {
    // An L on its side, so that the L is a wall; its corners begin anywhere.
    let corners = [[0, 0], [10, 0], [10, 4], [4, 4], [4, 10], [0, 10]];
    for first in 0..6 {
        let mut file = String::new();
        for depth in [5, 0] {
            for at in 0..6 {
                let [x, z] = corners[(first + at) % 6];
                writeln!(file, "v {x} {depth} {z}").expect("a string takes any text");
            }
        }
        file += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
        for at in 0..6 {
            let next = (at + 1) % 6;
            let quad = [at + 1, next + 1, next + 7, at + 7];
            writeln!(file, "f {} {} {} {}", quad[0], quad[1], quad[2], quad[3])
                .expect("a string takes any text");
        }
        let (volumes, stderr) = planned("part.obj", file.as_bytes());
        assert_eq!((volumes, stderr.as_str()), (vec![320.0], ""), "{first}");
    }
}

// bambulab/BambuStudio#1892, #4422
#[test]
fn vertices_have_colours() {
    let boxes = [cube(), cuboid([10.0, 0.0, 0.0], [5.0, 10.0, 10.0])];
    for colours in [["1 0 0", "0 0 1"], ["255 0 0", "0 0 255"]] {
        let (volumes, _) = planned("part.obj", obj(&boxes, false, &colours).as_bytes());
        assert_eq!(volumes, [1000.0, 500.0]);
    }
    let (volumes, stderr) = planned("part.obj", obj(&boxes, true, &["1 0 0", "0 0 1"]).as_bytes());
    assert_eq!(volumes, [1000.0, 500.0]);
    assert!(stderr.contains("colours of vertices (the file has materials): not used"), "{stderr}");
}
