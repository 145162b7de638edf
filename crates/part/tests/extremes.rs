//! Files that are valid but extreme: one endless line, a hundred thousand bodies, all vertices at
//! one point.
//!
//! Each takes at most a few seconds if the code that reads it is nearly linear in its size, and
//! minutes or gigabytes if something is quadratic.
//! Times are not asserted: a hanging test shows the fault.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use beadwork_base::Control;
use beadwork_gcode::{MotionLimits as Speeds, Program};
use beadwork_mesh::{
    Body, Format, MaterialRule, Mesh, Model, Placement, ReadError, ReadLimits, RepairError,
    RepairSettings, Solid, Transform,
};
use beadwork_part::slice::{self, SliceError};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fn read(format: Format, bytes: impl AsRef<[u8]>) -> Result<Model, ReadError> {
    Model::read(format, bytes.as_ref(), &ReadLimits::default(), &Control::default())
}

fn pack<'a>(parts: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        // A low level is fast, and enough for contents that repeat.
        let options = SimpleFileOptions::default().compression_level(Some(1));
        writer.start_file(name, options).unwrap();
        writer.write_all(text.as_bytes()).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn model(resources: &str, build: &str) -> String {
    format!(
        "<model xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\">\
         <resources>{resources}</resources><build>{build}</build></model>"
    )
}

fn read_package(resources: &str, build: &str) -> Result<Model, ReadError> {
    read(Format::ThreeMf, pack([("3D/3dmodel.model", model(resources, build).as_str())]))
}

const TETRA: &str = "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" \
    z=\"0\"/><vertex x=\"0\" y=\"1\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"1\"/></vertices>\
    <triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>\
    <triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/></triangles>\
    </mesh>";

fn body(mesh: Mesh) -> Body {
    Body { name: String::new(), mesh, material: Some(0), ..Body::default() }
}

/// A tetrahedron at each position, turned inside out.
fn inverted(positions: impl Iterator<Item = [f64; 3]>) -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for [x, y, z] in positions {
        let first = vertices.len() as u32;
        vertices.extend([[x, y, z], [x + 0.5, y, z], [x, y + 0.5, z], [x, y, z + 0.5]]);
        let faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        triangles.extend(faces.map(|face: [u32; 3]| face.map(|corner| first + corner)));
    }
    Mesh::new(vertices, triangles).unwrap()
}

#[test]
fn stl_of_one_line_and_of_many_solids() {
    let line = "solid ".to_owned() + &"x ".repeat(5 << 20);
    assert!(matches!(read(Format::Stl, &line), Err(ReadError::NoTriangles)));
    let digits = format!("solid\nfacet\nvertex {} 0 0\n", "1".repeat(10 << 20));
    assert!(matches!(read(Format::Stl, &digits), Err(ReadError::Line { line: 3, .. })));
    let facet = "facet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1\nendfacet\n";
    let solids = format!("solid s\n{facet}endsolid\n").repeat(50_000);
    assert_eq!(read(Format::Stl, &solids).unwrap().bodies.len(), 50_000);
}

#[test]
fn obj_of_one_face_and_of_many_bodies() {
    let face = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf{}\n", " 1 2 3".repeat(350_000));
    assert_eq!(read(Format::Obj, &face).unwrap().triangle_count(), 1_049_998);
    let joined = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf{}\n", " 1 2 3 \\\n".repeat(100_000));
    assert_eq!(read(Format::Obj, &joined).unwrap().triangle_count(), 299_998);
    let mut bodies = "v 0 0 0\n".repeat(100_000);
    (0..100_000).for_each(|body| writeln!(bodies, "o {body}\nusemtl m\nf -1 -2 -3").unwrap());
    assert_eq!(read(Format::Obj, &bodies).unwrap().bodies.len(), 100_000);
}

#[test]
fn xml_of_long_attributes_and_deep_elements() {
    let long = "&amp;".repeat(2 << 20);
    let named = format!(r#"<object id="1" name="{long}">{TETRA}</object>"#);
    assert_eq!(read_package(&named, r#"<item objectid="1"/>"#).unwrap().bodies[0].name.len(), 200);
    let number =
        format!(r#"<object id="1"><mesh><vertices><vertex x="{}"/>"#, "9".repeat(10 << 20));
    assert!(matches!(read_package(&number, ""), Err(ReadError::Entry { .. })));
    let many: String = (0..500_000).fold(String::new(), |mut text, at| {
        write!(text, " a{at}=''").unwrap();
        text
    });
    assert!(matches!(
        read_package(&format!("<object {many} id='1'/>"), r#"<item objectid="1"/>"#),
        Err(ReadError::NoTriangles)
    ));
    let deep = "<a>".repeat(1 << 20);
    assert!(matches!(read_package(&deep, ""), Err(ReadError::Entry { .. })));
    let deep = deep + &"</a>".repeat(1 << 20) + "<object id='1'/>";
    let item = r#"<item objectid="1"/>"#;
    assert!(matches!(read_package(&deep, item), Err(ReadError::NoTriangles)));
}

#[test]
fn a_package_of_many_objects_components_and_parts() {
    let mut objects = String::new();
    let mut items = String::new();
    for id in 1..=100_000 {
        write!(
            objects,
            r#"<object id="{id}"><components><component objectid="0"/></components></object>"#
        )
        .unwrap();
        write!(items, r#"<item objectid="{id}"/>"#).unwrap();
    }
    write!(objects, r#"<object id="0">{TETRA}</object>"#).unwrap();
    assert_eq!(read_package(&objects, &items).unwrap().bodies.len(), 100_000);
    let components = r#"<component objectid="0"/>"#.repeat(100_000);
    let one = format!(
        "<object id=\"0\">{TETRA}</object><object id=\"1\"><components>{components}</components>\
         </object>"
    );
    assert_eq!(read_package(&one, r#"<item objectid="1"/>"#).unwrap().bodies.len(), 100_000);

    let names: Vec<String> = (0..20_000).map(|part| format!("3D/{part}.model")).collect();
    let object = model(&format!(r#"<object id="1">{TETRA}</object>"#), "");
    let components = names.iter().fold(String::new(), |mut text, name| {
        write!(text, r#"<component p:path="/{name}" objectid="1"/>"#).unwrap();
        text
    });
    let root = model(
        &format!(r#"<object id="1"><components>{components}</components></object>"#),
        r#"<item objectid="1"/>"#,
    );
    let parts = names.iter().map(|name| (name.as_str(), object.as_str()));
    let parts = pack(parts.chain([("3D/3dmodel.model", root.as_str())]));
    assert_eq!(read(Format::ThreeMf, parts).unwrap().bodies.len(), 20_000);
}

#[test]
fn instances_of_vertices_without_triangles() {
    // Copies of all vertices would take 2.4 MB for each instance, 24 GB in total.
    let vertices = r#"<vertex x="0" y="0" z="0"/>"#.repeat(100_000);
    let object = format!(
        "<object id=\"1\"><mesh><vertices>{vertices}</vertices><triangles><triangle v1=\"7\" \
         v2=\"8\" v3=\"9\"/></triangles></mesh></object>"
    );
    let model = read_package(&object, &r#"<item objectid="1"/>"#.repeat(10_000)).unwrap();
    assert_eq!((model.bodies.len(), model.bodies[0].mesh.vertices().len()), (10_000, 3));
}

#[test]
fn all_vertices_at_one_point() {
    let point = Mesh::new(
        vec![[1.0; 3]; 3_000_000 / 3],
        (0..300_000).map(|at| [at, at + 1, at + 2]).collect(),
    );
    assert_eq!(
        body(point.unwrap()).repair(&RepairSettings::default(), &Control::default()),
        Err(RepairError::NoArea(300_000))
    );
    let same = Mesh::new(vec![[1.0; 3]; 1], vec![[0; 3]; 300_000]);
    assert_eq!(
        body(same.unwrap()).repair(&RepairSettings::default(), &Control::default()),
        Err(RepairError::NoArea(300_000))
    );
    // All triangles share one edge.
    let mut vertices = vec![[0.0; 3], [0.0, 0.0, 1.0]];
    vertices.extend((0..300_000).map(|at| [f64::from(at).cos(), f64::from(at).sin(), 0.5]));
    let book = Mesh::new(vertices, (2..300_002).map(|at| [0, 1, at]).collect()).unwrap();
    _ = body(book).repair(&RepairSettings::default(), &Control::default());
}

#[test]
fn thousands_of_inverted_bodies_are_all_turned() {
    let spread = inverted((0..50_000).map(|at| [f64::from(at % 317), f64::from(at / 317), 0.0]));
    let mut spread = body(spread);
    assert_eq!(
        spread.repair(&RepairSettings::default(), &Control::default()).unwrap().flipped_triangles,
        200_000
    );
    // Stacked, so that every ray meets all of them.
    let mut stacked = body(inverted((0..2_000).map(|at| [0.0, 0.0, f64::from(at)])));
    assert_eq!(
        stacked.repair(&RepairSettings::default(), &Control::default()).unwrap().flipped_triangles,
        8_000
    );
}

#[test]
fn a_hole_of_many_edges() {
    let corners = 200_000;
    let outline_mm = (0..corners)
        .map(|at| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(at) / f64::from(corners)).sin_cos();
            [100.0 * cos, 100.0 * sin]
        })
        .collect();
    let cup = Solid::Prism { outline_mm, z_mm: [0.0, 5.0] }.mesh();
    let top = corners as u32;
    let open = cup
        .triangles()
        .iter()
        .copied()
        .filter(|triangle| triangle.iter().any(|&at| at < top))
        .collect();
    let mut cup = body(Mesh::new(cup.vertices().to_vec(), open).unwrap());
    assert_eq!(
        cup.repair(&RepairSettings::default(), &Control::default()).unwrap().closed_holes,
        1
    );
}

#[test]
fn parts_of_extreme_height() {
    let settings = slice::Settings { cell_mm: 1.0, layer_mm: 1e-3, ..slice::Settings::default() };
    let needle = |height| Model {
        bodies: vec![body(Solid::Cuboid { size_mm: [2.0, 2.0, height] }.mesh())],
        ..Model::default()
    };
    assert_eq!(
        slice::slice(&needle(100.0), &settings, &Control::default()).unwrap().layers.len(),
        100_000
    );
    for height in [2e5, 1e6, 1e300, 1e308] {
        let error = slice::slice(&needle(height), &settings, &Control::default());
        assert!(matches!(error, Err(SliceError::Cells { .. })), "{height}");
    }
}

#[test]
fn many_bodies_in_many_layers() {
    let cube = Solid::Cuboid { size_mm: [0.9; 3] }.mesh();
    let bodies = (0..10_000).map(|at| {
        let mut mesh = cube.clone();
        Transform::translation([f64::from(at % 100), f64::from(at / 100), f64::from(at % 200)])
            .apply(&mut mesh);
        Body { mesh, paint: (0..12).map(|at| at % 2).collect(), ..Body::default() }
    });
    let materials =
        ["a", "b"].map(|name| beadwork_mesh::Material { name: name.into(), colour: None });
    let mut model =
        Model { bodies: bodies.collect(), materials: materials.into(), ..Model::default() };
    model
        .bodies
        .iter_mut()
        .for_each(|body| _ = body.repair(&RepairSettings::default(), &Control::default()).unwrap());
    model.assign_materials(MaterialRule::Stated);
    let settings = slice::Settings { cell_mm: 0.5, layer_mm: 0.1, ..slice::Settings::default() };
    assert!(slice::slice(&model, &settings, &Control::default()).unwrap().cell_count() > 10_000);
}

#[test]
fn extreme_coordinates() {
    let settings = slice::Settings { cell_mm: 1.0, layer_mm: 1.0, ..slice::Settings::default() };
    for size in [1e100, 1e154, 1e300, 1.7e308] {
        let text = format!(
            "v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\n\
             f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        );
        let mut model = read(Format::Obj, &text).unwrap();
        _ = model.bodies[0].repair(&RepairSettings::default(), &Control::default());
        model.assign_materials(MaterialRule::Stated);
        assert!(slice::slice(&model, &settings, &Control::default()).is_err());
        for scale in [1.0, 1e-300, 1e300] {
            let placement =
                Placement { scale, rotation_degrees: [45.0; 3], ..Placement::default() };
            if placement.apply(&mut model.clone()).is_ok() {
                assert!(size * scale < 1000.0);
            }
        }
    }
}

#[test]
fn gcode_of_extreme_lines_arcs_and_numbers() {
    let speeds =
        Speeds { acceleration_mm_s2: 1000.0, square_corner_mm_s: 5.0, max_speed_mm_s: 300.0 };
    let seconds = |text: &str| {
        let program = text.parse::<Program>().unwrap();
        assert_eq!(program.emit().parse().as_ref(), Ok(&program));
        program.print_seconds(speeds, &Control::default()).unwrap()
    };
    for piece in ["N1 ", "N1 G", "N1*", "(a)", "(", "X1", "X ", "* ", "\u{feff}", "M117 ("] {
        let line = piece.repeat((2 << 20) / piece.len());
        for start in ["", "G1 ", "N5 ", "M117 ", "G4 "] {
            if let Ok(program) = format!("{start}{line}").parse::<Program>() {
                assert_eq!(program.emit().parse().as_ref(), Ok(&program), "{piece}");
            }
        }
    }
    // Motions that never stop need not all be kept in memory.
    assert!(seconds(&"G2 I9000\n".repeat(20_000)) > 1e6);
    assert!(
        seconds("G91\nG1 X9000000000000 E9000000000000\nG2 X9000000000000 I4500000000000\n") > 1e9
    );
    assert!("G1 X1000000000000000000".parse::<Program>().is_err());
}
