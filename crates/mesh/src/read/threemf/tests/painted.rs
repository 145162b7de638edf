//! Random painted projects of both dialects: the areas of colours are those of the paint.

use std::collections::BTreeMap;

use super::*;
use crate::read::threemf::painting::Split;
use crate::read::threemf::painting::tests::{Tree, area};
use crate::{Mesh, Solid};

/// A small generator of random numbers (a linear congruence, of which the high bits are used).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(end)) as u32
    }

    /// A tree of a depth, with states 0 to `filaments`.
    fn tree(&mut self, depth: u32, filaments: u32) -> Tree {
        if depth == 0 || self.below(4) == 0 {
            return Tree::Leaf(self.below(filaments + 1));
        }
        let split = Split { sides: 1 + self.below(3) as u8, first: self.below(3) as u8 };
        Tree::Split(split, (0..split.count()).map(|_| self.tree(depth - 1, filaments)).collect())
    }
}

/// A project, and the area of each filament in it.
struct Painted {
    entries: Vec<(&'static str, String)>,
    areas: BTreeMap<u32, f64>,
    volume_mm3: f64,
}

/// The mesh with painted facets; adds the areas that the trees paint.
fn mesh_xml(
    mesh: &Mesh,
    attribute: &str,
    own: u32,
    areas: &mut BTreeMap<u32, f64>,
    mut tree: impl FnMut() -> Option<Tree>,
) -> String {
    let mut text = String::from("<mesh><vertices>");
    for [x, y, z] in mesh.vertices() {
        write!(text, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#).unwrap();
    }
    text += "</vertices><triangles>";
    for &[a, b, c] in mesh.triangles() {
        write!(text, r#"<triangle v1="{a}" v2="{b}" v3="{c}""#).unwrap();
        let tree = tree();
        if let Some(tree) = &tree {
            write!(text, r#" {attribute}="{}""#, tree.encode()).unwrap();
        }
        text += "/>";
        let mut of_state = BTreeMap::new();
        tree.unwrap_or(Tree::Leaf(0)).areas(mesh.corners([a, b, c]), &mut of_state);
        for (state, area) in of_state {
            *areas.entry(if state == 0 { own } else { state }).or_default() += area;
        }
    }
    text + "</triangles></mesh>"
}

fn painted(seed: u64, filaments: u32, depth: u32, is_bambu: bool) -> Painted {
    let mut random = Random(seed);
    let own = 1 + random.below(filaments);
    let solid = match seed % 3 {
        0 => Solid::Cuboid { size_mm: [20.0, 15.0, 10.0] },
        1 => Solid::Sphere { radius_mm: 10.0, steps: 12 },
        _ => Solid::Frustum { sides_mm: [20.0, 12.0], height_mm: 15.0 },
    };
    let mesh = solid.mesh();
    let mut areas = BTreeMap::new();
    let attribute = if is_bambu { "paint_color" } else { "slic3rpe:mmu_segmentation" };
    // A quarter of the facets is not painted.
    let tree = || (random.below(4) > 0).then(|| random.tree(depth, filaments));
    let text = mesh_xml(&mesh, attribute, own, &mut areas, tree);
    let core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
    let document = |resources: &str, build: &str| {
        format!(
            r#"<model unit="millimeter" xmlns="{core}" xmlns:p="{PRODUCTION}"
            xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06"><resources>{resources}
            </resources><build>{build}</build></model>"#
        )
    };
    let transform = r#"transform="0 1 0 -1 0 0 0 0 1 100 100 0""#;
    let entries = if is_bambu {
        let root = document(
            r#"<object id="2"><components><component p:path="/3D/Objects/object_1.model"
            objectid="1"/></components></object>"#,
            &format!(r#"<item objectid="2" {transform} printable="1"/>"#),
        );
        let objects = format!(
            r#"<config><object id="2"><metadata key="extruder" value="1"/><part id="1"
            subtype="normal_part"><metadata key="extruder" value="{own}"/></part></object>
            </config>"#
        );
        vec![
            ("3D/3dmodel.model", root),
            (
                "3D/Objects/object_1.model",
                document(&format!(r#"<object id="1">{text}</object>"#), ""),
            ),
            ("Metadata/model_settings.config", objects),
        ]
    } else {
        let root = document(
            &format!(r#"<object id="1">{text}</object>"#),
            &format!(r#"<item objectid="1" {transform}/>"#),
        );
        let last = mesh.triangles().len() - 1;
        let objects = format!(
            r#"<config><object id="1"><metadata type="object" key="extruder" value="{own}"/>
            <volume firstid="0" lastid="{last}"><metadata type="volume" key="volume_type"
            value="ModelPart"/></volume></object></config>"#
        );
        vec![("3D/3dmodel.model", root), ("Metadata/Slic3r_PE_model.config", objects)]
    };
    Painted { entries, areas, volume_mm3: mesh.volume_mm3() }
}

/// The number of a filament, by the name of its material.
fn filament(model: &Model, material: usize) -> u32 {
    model.materials[material].name.strip_prefix("filament ").unwrap().parse().unwrap()
}

// prusa3d/PrusaSlicer#12502, #13900, assimp/assimp#5629
#[test]
fn areas_of_colours_are_those_of_the_paint() {
    let mut most_triangles = 0;
    for number in 0..28_u64 {
        // 1 to 16 filaments, 0 to 6 levels.
        let (filaments, depth) = (1 + (number * 5 % 16) as u32, (number % 7) as u32);
        let is_bambu = number % 2 == 0;
        let painted = painted(number, filaments, depth, is_bambu);
        let entries: Vec<_> =
            painted.entries.iter().map(|(name, text)| (*name, text.as_str())).collect();
        let mut model = read_entries(&entries).unwrap();
        let [body] = &mut model.bodies[..] else { panic!("one body") };
        assert!(
            body.repair(&crate::RepairSettings::default(), &Control::default())
                .unwrap()
                .was_sound(),
            "project {number}"
        );
        let volume = body.mesh.volume_mm3();
        assert!((volume - painted.volume_mm3).abs() < 1e-9 * volume, "project {number}");
        let body = &model.bodies[0];
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for (triangle, corners) in body.mesh.triangles().iter().enumerate() {
            let material = body.paint.get(triangle).map_or(body.material, |&it| Some(it.into()));
            *areas.entry(filament(&model, material.unwrap())).or_default() +=
                area(body.mesh.corners(*corners));
        }
        assert_eq!(areas.len(), painted.areas.len(), "project {number}");
        for (filament, area) in areas {
            let expected = painted.areas[&filament];
            assert!(
                (area - expected).abs() <= 1e-9 * expected,
                "project {number}, filament {filament}: {area} mm², expected {expected} mm²"
            );
        }
        most_triangles = most_triangles.max(model.triangle_count());
    }
    assert!(most_triangles > 10_000, "{most_triangles}");
}
