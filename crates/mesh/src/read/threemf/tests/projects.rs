//! Projects of slicers: filaments, roles, plates and purge volumes.
#![allow(clippy::format_collect, reason = "tests write short texts")]

use ndarray::array;

use super::*;
use crate::Role;

/// A cube of 1 mm at a position along x.
fn cube(x: u32) -> String {
    let vertices: String = (0..8)
        .map(|corner: u32| {
            let (dx, y, z) = (corner & 1, corner >> 1 & 1, corner >> 2);
            format!(r#"<vertex x="{}" y="{y}" z="{z}"/>"#, x + dx)
        })
        .collect();
    let triangles: String = FACES.iter().map(|&face| triangle(face, "")).collect();
    format!("<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>")
}

const FACES: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

fn triangle([a, b, c]: [u32; 3], more: &str) -> String {
    format!(r#"<triangle v1="{a}" v2="{b}" v3="{c}"{more}/>"#)
}

fn document(resources: &str, build: &str) -> String {
    format!(
        r#"<model xmlns:p="{PRODUCTION}" xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06">
        <resources>{resources}</resources><build>{build}</build></model>"#
    )
}

/// The names of the materials of bodies.
fn materials(model: &Model) -> Vec<Option<&str>> {
    let name = |material: usize| model.materials[material].name.as_str();
    model.bodies.iter().map(|body| body.material.map(name)).collect()
}

const BAMBU: &str = "Metadata/model_settings.config";
const PRUSA: &str = "Metadata/Slic3r_PE_model.config";

/// Objects 1 to `count`, which are cubes, and object 9, which is composed of them.
fn assembly(count: u32) -> String {
    let objects: String = (1..=count)
        .map(|id| {
            let kind = if id == 1 { "model" } else { "other" };
            format!(r#"<object id="{id}" type="{kind}">{}</object>"#, cube(2 * id))
        })
        .collect();
    let components: String =
        (1..=count).map(|id| format!(r#"<component objectid="{id}"/>"#)).collect();
    document(
        &format!(r#"{objects}<object id="9"><components>{components}</components></object>"#),
        r#"<item objectid="9"/>"#,
    )
}

fn part(id: u32, kind: &str, extruder: &str) -> String {
    format!(
        r#"<part id="{id}" subtype="{kind}"><metadata key="name" value="p{id}"/>
        <metadata key="extruder" value="{extruder}"/></part>"#
    )
}

// CNCKitchen/stlTexturizer#110, prusa3d/PrusaSlicer#15694
#[test]
fn parts_of_bambu_projects_have_roles_and_filaments() {
    let parts = [
        part(1, "normal_part", "2"),
        part(2, "negative_part", "1"),
        part(3, "modifier_part", "1"),
        part(4, "modifier_part", "0"),
        part(5, "support_blocker", "1"),
        part(6, "normal_part", "0"),
    ]
    .concat();
    let settings = format!(
        r#"<config><object id="9"><metadata key="name" value="thing"/>
        <metadata key="extruder" value="3"/>{parts}</object></config>"#
    );
    let project = r##"{"filament_colour": ["#FF0000", "#00FF00", "#0000FF"],
        "filament_type": ["PLA", "PETG", "PLA"], "layer_height": "0.2",
        "flush_volumes_matrix": ["0", "10", "20", "30", "0", "40", "50", "60", "0"],
        "flush_multiplier": "2"}"##;
    let model = read_entries(&[
        ("3D/3dmodel.model", &assembly(6)),
        (BAMBU, &settings),
        ("Metadata/project_settings.config", project),
    ])
    .unwrap();
    let roles: Vec<_> = model.bodies.iter().map(|body| body.role).collect();
    assert_eq!(roles, [Role::Solid, Role::Negative, Role::Modifier, Role::Solid]);
    assert_eq!(
        materials(&model),
        [Some("filament 2 (PETG)"), None, Some("filament 1 (PLA)"), Some("filament 3 (PLA)")]
    );
    assert!(model.bodies.iter().all(|body| body.object == 0));
    assert_eq!(model.materials[2].colour, Some([0, 0, 255]));
    assert_eq!(
        model.purge_mm3,
        Some(array![[0.0, 20.0, 40.0], [60.0, 0.0, 80.0], [100.0, 120.0, 0.0]])
    );
    assert_eq!(
        warnings(&model),
        [
            "modifiers that do not change the filament (p4): not used",
            "support enforcers and blockers (p5): not used",
            "print settings of the project: not used",
        ]
    );
}

#[test]
fn unknown_parts_and_broken_settings_are_refused() {
    for (settings, message) in [
        (part(1, "hologram_part", "1"), "unknown type of a part: 'hologram_part'"),
        (part(1, "normal_part", "-1"), "extruder is '-1', expected an integer from 0 to 255"),
        (part(1, "normal_part", "300"), "extruder is '300', expected an integer from 0 to 255"),
    ] {
        let settings = format!(r#"<config><object id="9">{settings}</object></config>"#);
        let error = read_entries(&[("3D/3dmodel.model", &assembly(1)), (BAMBU, &settings)]);
        let error = error.unwrap_err().to_string();
        assert!(error.starts_with("Metadata/model_settings.config, byte "), "{error}");
        assert!(error.ends_with(message), "{error}");
    }
    for (project, message) in [
        ("[", "not valid JSON"),
        (r#"{"flush_volumes_matrix": ["0", "x", "1", "0"]}"#, "'x' is not a number"),
        (r#"{"flush_volumes_matrix": ["0", "-1", "1", "0"]}"#, "purge volume -1 is not between"),
    ] {
        let entry = "Metadata/project_settings.config";
        let error = read_entries(&[("3D/3dmodel.model", &assembly(1)), (entry, project)]);
        let error = error.unwrap_err().to_string();
        assert!(error.starts_with(entry) && error.contains(message), "{error}");
    }
}

#[test]
fn only_the_first_plate_is_printed() {
    let resources = format!(
        r#"<object id="1" name="a">{0}</object><object id="2" name="b">{0}</object>"#,
        cube(0)
    );
    let build = r#"<item objectid="1"/><item objectid="1" transform="1 0 0 0 1 0 0 0 1 300 0 0"/>
        <item objectid="2"/>"#;
    let plate = |number: u32, object: u32, instance: u32| {
        format!(
            r#"<plate><metadata key="plater_id" value="{number}"/><model_instance>
            <metadata key="object_id" value="{object}"/>
            <metadata key="instance_id" value="{instance}"/></model_instance></plate>"#
        )
    };
    let text = document(&resources, build);
    let settings = format!("<config>{}{}</config>", plate(2, 1, 1), plate(1, 1, 0));
    let model = read_entries(&[("3D/3dmodel.model", &text), (BAMBU, &settings)]).unwrap();
    assert_eq!((model.bodies.len(), model.bounds().max[0]), (1, 1.0));
    assert_eq!(
        warnings(&model),
        ["objects that are not on plate 1, the first one (a, b): not used"]
    );
    // One plate with objects: everything is on it.
    let settings = format!("<config>{}<plate/></config>", plate(1, 1, 0));
    let model = read_entries(&[("3D/3dmodel.model", &text), (BAMBU, &settings)]).unwrap();
    assert_eq!(model.bodies.len(), 3);
    assert_eq!(materials(&model), [Some("filament 1"); 3]);
}

/// Two cubes as one mesh.
fn two_cubes() -> String {
    let (first, second) = (cube(0), cube(2));
    let vertices = |text: &str| {
        text.split("</vertices>").next().unwrap().split("<vertices>").nth(1).unwrap().to_owned()
    };
    let moved: String =
        FACES.iter().map(|face| triangle(face.map(|corner| corner + 8), "")).collect();
    let triangles: String = FACES.iter().map(|&face| triangle(face, "")).collect();
    format!(
        "<mesh><vertices>{}{}</vertices><triangles>{triangles}{moved}</triangles></mesh>",
        vertices(&first),
        vertices(&second)
    )
}

fn volume(first: u32, last: u32, settings: &[(&str, &str)]) -> String {
    let settings: String = settings
        .iter()
        .map(|(key, value)| format!(r#"<metadata type="volume" key="{key}" value="{value}"/>"#))
        .collect();
    format!(r#"<volume firstid="{first}" lastid="{last}">{settings}<mesh_stat/></volume>"#)
}

fn prusa(volumes: &str, settings: &str) -> Result<Model, ReadError> {
    // The second instance is a component of its own object.
    let text = document(
        &format!(
            r#"<object id="1">{}</object><object id="2"><components><component objectid="1"/>
            </components></object>"#,
            two_cubes()
        ),
        r#"<item objectid="1"/><item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 9 0"/>"#,
    );
    let objects = format!(
        r#"<config><object id="1" instances_count="2"><metadata type="object" key="name" value="x"/>
        <metadata type="object" key="extruder" value="2"/>{volumes}</object></config>"#
    );
    read_entries(&[
        ("3D/3dmodel.model", &text),
        (PRUSA, &objects),
        ("Metadata/Slic3r_PE.config", settings),
    ])
}

// prusa3d/PrusaSlicer#15694
#[test]
fn volumes_of_prusa_projects_have_roles_and_filaments() {
    let settings = "; generated by PrusaSlicer\n\n; extruder_colour = \"\";#00FF00\n\
        ; filament_colour = #FF0000;#0000FF\n; filament_type = PLA;PLA\n\
        ; wiping_volumes_matrix = 0,70,80,0\n";
    let volumes = volume(0, 11, &[("volume_type", "ModelPart"), ("extruder", "0")])
        + &volume(12, 23, &[("volume_type", "NegativeVolume"), ("extruder", "1")]);
    let model = prusa(&volumes, settings).unwrap();
    let bodies: Vec<_> =
        model.bodies.iter().map(|body| (body.role, body.object, body.copy_of)).collect();
    assert_eq!(
        bodies,
        [
            (Role::Solid, 0, Some(0)),
            (Role::Negative, 0, Some(1)),
            (Role::Solid, 1, Some(0)),
            (Role::Negative, 1, Some(1)),
        ]
    );
    assert!((model.bodies[1].mesh.volume_mm3() - 1.0).abs() < 1e-12);
    assert_eq!(model.bodies[1].mesh.bounds().min, [2.0, 0.0, 0.0]);
    assert_eq!(materials(&model)[0], Some("filament 2 (PLA)"));
    assert_eq!(model.materials[0].colour, Some([0, 255, 0]));

    let volumes = volume(0, 11, &[]) + &volume(12, 23, &[("extruder", "1")]);
    let mut model = prusa(&volumes, settings).unwrap();
    model.assign_materials(MaterialRule::Stated);
    assert_eq!(materials(&model)[..2], [Some("filament 2 (PLA)"), Some("filament 1 (PLA)")]);
    assert_eq!(model.purge_mm3, Some(array![[0.0, 70.0], [80.0, 0.0]]));
    // A volume without settings of its own, and a modifier in the older form.
    let volumes = volume(12, 23, &[("modifier", "1"), ("extruder", "3")]);
    let model = prusa(&volumes, settings).unwrap();
    assert_eq!(model.bodies[0].role, Role::Solid);
    assert_eq!((model.bodies[1].role, materials(&model)[1]), (Role::Modifier, Some("filament 3")));
    assert!(warnings(&model)[0].starts_with("purge volumes of the project, which does not state"));

    for volumes in
        [volume(0, 24, &[]), volume(5, 4, &[]), volume(0, 11, &[]) + &volume(11, 23, &[])]
    {
        let error = prusa(&volumes, settings).unwrap_err().to_string();
        assert!(error.contains("object 1: project has a part of the triangles"), "{error}");
    }
}

#[test]
fn purge_volumes_of_prusa_projects_are_those_that_it_uses() {
    let both = volume(0, 11, &[("extruder", "1")]) + &volume(12, 23, &[("extruder", "2")]);
    let colours = "; filament_colour = #FF0000;#0000FF\n; wiping_volumes_matrix = 0,70,80,0\n";
    let purge = |more: &str| prusa(&both, &format!("{colours}{more}")).unwrap();
    assert_eq!(purge("").purge_mm3, Some(array![[0.0, 70.0], [80.0, 0.0]]));
    let shared = "; wiping_volumes_use_custom_matrix = 0\n; multimaterial_purging = 140\n\
        ; filament_purge_multiplier = 100%,50%\n";
    assert_eq!(purge(shared).purge_mm3, Some(array![[0.0, 70.0], [140.0, 0.0]]));
    let several = purge("; single_extruder_multi_material = 0\n");
    assert_eq!(several.purge_mm3, None);
    assert!(
        warnings(&several)
            .contains(&"purge volumes of a project for several extruders: not used".into())
    );
}

// prusa3d/PrusaSlicer#13900, assimp/assimp#5629
#[test]
fn paint_of_both_dialects_is_read() {
    for attribute in ["paint_color", "slic3rpe:mmu_segmentation"] {
        let paint = |text: &str| format!(r#" {attribute}="{text}""#);
        let painted: String = FACES
            .iter()
            .enumerate()
            .map(|(number, &face)| match number {
                0 => triangle(face, &paint("8")),
                1 => triangle(face, &paint("444483")),
                _ => triangle(face, ""),
            })
            .collect();
        let mesh = cube(0);
        let (start, _) = mesh.split_once("<triangles>").unwrap();
        let resources = format!(
            r#"<object id="1">{start}<triangles>{painted}</triangles></mesh></object>
            <object id="2">{}</object>"#,
            cube(3)
        );
        let text = document(&resources, r#"<item objectid="1"/><item objectid="2"/>"#);
        let error = read_entries(&[("3D/3dmodel.model", &text)]).unwrap_err().to_string();
        assert!(error.contains("digits that belong to no node"), "{error}");
        let text = text.replace("444483", "44483");
        let mut model = read_entries(&[("3D/3dmodel.model", &text)]).unwrap();
        let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["filament 1", "filament 2"]);
        // What is not painted has filament 1.
        assert_eq!(materials(&model), [None, Some("filament 1")]);
        let count = |wanted| model.bodies[0].paint.iter().filter(|paint| **paint == wanted).count();
        assert_eq!(count(1), 3, "two halves of the neighbour, and one quarter");
        for body in &mut model.bodies {
            let report =
                body.repair(&crate::RepairSettings::default(), &Control::default()).unwrap();
            assert_eq!((report.closed_holes, report.flipped_triangles), (0, 0));
            assert!((body.mesh.volume_mm3() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_stated_filament_overrides_a_material() {
    let resources = format!(
        r##"<basematerials id="5"><base name="wood" displaycolor="#AA8800"/></basematerials>
        <object id="1" pid="5" pindex="0">{0}</object>
        <object id="2" pid="5" pindex="0">{0}</object>"##,
        cube(0)
    );
    let settings =
        r#"<config><object id="2"><metadata key="extruder" value="4"/></object></config>"#;
    let text = document(&resources, r#"<item objectid="1"/><item objectid="2"/>"#);
    let model = read_entries(&[("3D/3dmodel.model", &text), (BAMBU, settings)]).unwrap();
    assert_eq!(materials(&model), [Some("wood"), Some("filament 4")]);
    assert_eq!(
        warnings(&model),
        ["materials of objects for which the project states a filament: not used"]
    );
}

#[test]
fn changes_of_layers_are_reported() {
    let codes = r#"<custom_gcodes_per_layer><plate><layer top_z="1" type="2" extruder="2"/></plate>
        </custom_gcodes_per_layer>"#;
    let entry = "Metadata/custom_gcode_per_layer.xml";
    let model = read_entries(&[("3D/3dmodel.model", &assembly(1)), (entry, codes)]).unwrap();
    assert_eq!(warnings(&model), ["filament changes and pauses at heights: not used"]);
    let empty = "<custom_gcodes_per_layer><plate/></custom_gcodes_per_layer>";
    let model = read_entries(&[("3D/3dmodel.model", &assembly(1)), (entry, empty)]).unwrap();
    assert_eq!(warnings(&model), [""; 0]);
}

#[test]
fn parts_of_a_painted_mesh_are_ranges_of_its_facets() {
    let mesh =
        two_cubes().replacen(r#"v3="3"/>"#, r#"v3="3" slic3rpe:mmu_segmentation="480C043"/>"#, 1);
    // The tree is malformed: five children.
    let text = document(&format!(r#"<object id="1">{mesh}</object>"#), r#"<item objectid="1"/>"#);
    assert!(read_entries(&[("3D/3dmodel.model", &text)]).is_err());
    let text = text.replace("480C043", "480C03");
    let volumes =
        volume(0, 11, &[("extruder", "4")]) + &volume(12, 23, &[("volume_type", "NegativeVolume")]);
    let objects = format!(r#"<config><object id="1">{volumes}</object></config>"#);
    let model = read_entries(&[("3D/3dmodel.model", &text), (PRUSA, &objects)]).unwrap();
    let [solid, negative] = &model.bodies[..] else { panic!("two bodies") };
    // Four quarters, and three neighbours in two parts each.
    assert_eq!((solid.mesh.triangles().len(), negative.mesh.triangles().len()), (18, 12));
    assert!((solid.mesh.volume_mm3() - 1.0).abs() < 1e-12);
    assert!((negative.mesh.volume_mm3() - 1.0).abs() < 1e-12);
    let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["filament 1", "filament 2", "filament 3", "filament 4"]);
    let count = |wanted| solid.paint.iter().filter(|paint| **paint == wanted).count();
    assert_eq!([0, 1, 2, 3].map(count), [1, 1, 1, 15]);
}
