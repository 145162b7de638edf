//! Valid STL and OBJ files.

use std::fmt::Write as _;

use beadwork_mesh::{Format, Mesh, Solid, Transform};

use crate::seed::Seed;

pub(crate) fn cube() -> Mesh {
    Solid::Cuboid { size_mm: [6.0, 5.0, 4.0] }.mesh()
}

pub(crate) fn sphere() -> Mesh {
    let mut mesh = Solid::Sphere { radius_mm: 4.0, steps: 4 }.mesh();
    Transform::translation([10.0, 4.0, 4.0]).apply(&mut mesh);
    mesh
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [[f64; 3]; 3]> {
    mesh.triangles().iter().map(|&triangle| mesh.corners(triangle))
}

fn stl_text(name: &str, mesh: &Mesh) -> String {
    let mut text = format!("solid {name}\n");
    for triangle in corners(mesh) {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        triangle
            .iter()
            .for_each(|[x, y, z]| writeln!(text, "vertex {x:.3} {y:.3} {z:.3}").unwrap());
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid\n"
}

fn stl_binary(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    for triangle in corners(mesh) {
        bytes.extend([0; 12]);
        triangle.iter().flatten().for_each(|&value| bytes.extend((value as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

pub(crate) fn stl_seeds() -> Vec<Seed> {
    let stl = |name, bytes| Seed::mesh(name, Format::Stl, bytes);
    vec![
        stl("cube.stl", stl_binary(&cube())),
        stl("sphere.stl", stl_binary(&sphere())),
        stl("cube-text.stl", stl_text("a cube", &cube()).into_bytes()),
        stl("two-text.stl", (stl_text("a cube", &cube()) + &stl_text("", &sphere())).into_bytes()),
        stl("many-text.stl", stl_text("c", &cube()).repeat(6).into_bytes()),
    ]
}

pub(crate) fn obj_seeds() -> Vec<Seed> {
    let mut polygons = String::from("# polygons\nmtllib colours.mtl\no box\nusemtl red\n");
    cube().vertices().iter().for_each(|[x, y, z]| writeln!(polygons, "v {x} {y} {z} 1.0").unwrap());
    polygons.push_str(
        "vt 0 0\nvn 0 0 1\nf 4/1/1 3/1/1 2/1/1 1/1/1\nf 5//1 6//1 7//1 8//1\nf 1 2 6 5\n\
         usemtl blue\nf 2 3 7 \\\n6\ns off\nf -6 -5 -1 -2\nusemtl red\nf 4 1 5 8\n",
    );
    let mut groups = String::new();
    let mut base = 1;
    for (name, mesh) in [("cube", cube()), ("sphere", sphere())] {
        writeln!(groups, "g {name}\r\nusemtl {name}").unwrap();
        mesh.vertices()
            .iter()
            .for_each(|[x, y, z]| writeln!(groups, "v {x:.4} {y:.4} {z:.4}").unwrap());
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|vertex| vertex + base);
            writeln!(groups, "f {a} {b} {c}").unwrap();
        }
        base += mesh.vertices().len() as u32;
    }
    vec![
        Seed::mesh("cube.obj", Format::Obj, polygons),
        Seed::mesh("groups.obj", Format::Obj, groups),
    ]
}
