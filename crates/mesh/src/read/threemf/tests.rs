//! Reads small archives that the tests create.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use beadwork_base::{CancelToken, Interrupted, Progress};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::*;
use crate::{Format, MaterialRule};

mod painted;
mod projects;
mod specification;

const TETRA: &str = r#"<mesh><vertices>
    <vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>
    <vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/>
    </vertices><triangles>
    <triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/>
    <triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3" p1="1"/>
    </triangles></mesh>"#;

const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
const MATERIALS: &str = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";

fn archive(entries: &[(&str, &str)]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in entries {
        writer.start_file(*name, SimpleFileOptions::default()).unwrap();
        writer.write_all(text.as_bytes()).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn model(resources: &str, build: &str) -> String {
    format!(
        r#"<?xml version="1.0"?><model unit="inch" xmlns:p="{PRODUCTION}" xmlns:m="{MATERIALS}">
        <resources>{resources}</resources><build>{build}</build></model>"#
    )
}

fn read_entries(entries: &[(&str, &str)]) -> Result<Model, ReadError> {
    Model::read(Format::ThreeMf, &archive(entries), &ReadLimits::default(), &Control::default())
}

fn read_model(resources: &str, build: &str) -> Result<Model, ReadError> {
    read_entries(&[("3D/3dmodel.model", &model(resources, build))])
}

/// The warnings about a model.
fn warnings(model: &Model) -> Vec<String> {
    model.warnings.iter().map(ToString::to_string).collect()
}

fn refused(resources: &str, build: &str) -> String {
    read_model(resources, build).unwrap_err().to_string()
}

#[test]
fn units_transforms_and_components_are_applied() {
    let resources = format!(
        r#"<object id="1" type="model" name="tetra">{TETRA}</object><object id="2"><components>
        <component objectid="1" transform="2 0 0 0 2 0 0 0 2 0 0 0"/><component objectid="1"/>
        </components></object>
        <object id="3" type="support">{TETRA}</object>"#
    );
    let build = r#"<item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>
        <item objectid="1"/><item objectid="3"/>"#;
    let mut model = read_model(&resources, build).unwrap();
    assert_eq!(model.bodies.len(), 3);
    let sixth = 25.4_f64.powi(3) / 6.0;
    for (body, volume) in model.bodies.iter().zip([8.0 * sixth, sixth, sixth]) {
        assert!((body.mesh.volume_mm3() - volume).abs() < 1e-6, "{}", body.mesh.volume_mm3());
    }
    assert_eq!(model.bodies[0].mesh.bounds().min, [254.0, 0.0, 0.0]);
    model.assign_materials(MaterialRule::Stated);
    assert_eq!(
        model.bodies.iter().map(|body| body.material).collect::<Vec<_>>(),
        // Copies of one mesh.
        [Some(0), Some(0), Some(0)]
    );
    assert_eq!(model.bodies.iter().map(|body| body.object).collect::<Vec<_>>(), [0, 0, 1]);
    let lines: Vec<_> = model.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(lines, ["objects of type support (object 3): not used"]);
    model.assign_materials(MaterialRule::Single);
    assert_eq!(model.materials.len(), 1);
}

#[test]
fn materials_come_from_groups_of_object_and_triangle() {
    let resources = format!(
        r##"<basematerials id="5"><base name="PLA &amp; co" displaycolor="#FF0000FF"/>
        <base name="ABS" displaycolor="#00FF00"/></basematerials>
        <m:colorgroup id="6"><m:color color="#0000FF"/></m:colorgroup>
        <object id="1" pid="5" pindex="0">{TETRA}</object><object id="2" pid="6">{}</object>
        <object id="3" pid="5" pindex="1"><components><component objectid="4"/></components>
        </object><object id="4">{}</object>"##,
        TETRA.replace(" p1=\"1\"", ""),
        TETRA.replace(" p1=\"1\"", "")
    );
    let build = r#"<item objectid="1"/><item objectid="2"/><item objectid="3"/>"#;
    let mut model = read_model(&resources, build).unwrap();
    model.assign_materials(MaterialRule::Stated);
    let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["PLA & co", "ABS", "#0000FF"]);
    assert_eq!(model.materials[1].colour, Some([0, 255, 0]));
    assert_eq!(model.bodies[0].paint, [0, 0, 0, 1]);
    assert_eq!((model.bodies[1].material, model.bodies[2].material), (Some(2), Some(1)));
}

#[test]
fn objects_may_be_in_other_documents() {
    let root = model(
        r#"<object id="1"><components><component p:path="/3D/other.model" objectid="7"/>
        </components></object>"#,
        r#"<item objectid="1"/>"#,
    );
    let other = model(&format!(r#"<object id="7">{TETRA}</object>"#), "");
    let list = r#"<Relationships><Relationship Target="/odd/place.model"
        Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
    let read = read_entries(&[
        ("_rels/.rels", list),
        ("odd/place.model", &root),
        ("3D/other.model", &other),
    ])
    .unwrap();
    assert_eq!(read.triangle_count(), 4);
    let error = read_entries(&[("_rels/.rels", list), ("odd/place.model", &root)]).unwrap_err();
    assert_eq!(error.to_string(), "archive has no entry 3D/other.model");
    let error = read_entries(&[("_rels/.rels", list)]).unwrap_err();
    assert_eq!(error.to_string(), "archive has no entry odd/place.model");
}

#[test]
fn errors_state_their_location() {
    let object = format!(r#"<object id="1">{TETRA}</object>"#);
    let item = r#"<item objectid="1"/>"#;
    assert_eq!(
        refused(&object, r#"<item objectid="9"/>"#),
        "3D/3dmodel.model: object 9 does not exist"
    );
    assert_eq!(
        refused(&object, ""),
        "3D/3dmodel.model: build is empty: the file has an object, but does not list it for \
         printing"
    );
    assert!(
        refused(&object.replace("x=\"1\"", "x=\"one\""), item).ends_with(": 'one' is not a number")
    );
    assert!(
        refused(&object.replace("x=\"1\"", "x=\"nan\""), item)
            .ends_with("'nan' is not a finite number")
    );
    assert!(
        refused(&object.replace("x=\"1\"", ""), item).ends_with(": vertex must have x, y and z")
    );
    assert!(
        refused(&object.replace("v1=\"1\"", "v1=\"4\""), item)
            .contains("triangle 3: vertex 4 does not exist, mesh has 4")
    );
    assert!(
        refused(&object, r#"<item objectid="1" transform="1 0 0"/>"#)
            .ends_with("transform has 3 numbers, expected 12")
    );
    // 1e310 - 1e310: coordinates must not become NaN.
    let beyond =
        format!(r#"<item objectid="1" transform="{0} 0 0 -{0} 1 0 0 0 1 0 0 0"/>"#, "1e308");
    let large = object.replace("x=\"1\" y=\"0\"", "x=\"100\" y=\"100\"");
    assert!(
        refused(&large, &beyond)
            .ends_with("transform of object 1 makes coordinates that are not finite")
    );
    let round = r#"<object id="1"><components><component objectid="1"/>
        <component objectid="1"/></components></object>"#;
    assert!(
        refused(round, item)
            .ends_with("object 1 contains itself, or nests components more than 32 deep")
    );
    let cut = model(&object, item);
    let error = read_entries(&[("3D/3dmodel.model", &cut[..cut.len() - 30])]).unwrap_err();
    assert!(matches!(error, ReadError::Entry { .. }), "{error}");
    let error = read_entries(&[("3D/3dmodel.model", "<svg></svg>")]).unwrap_err();
    assert!(error.to_string().ends_with("document has no <model> element"));
    assert_eq!(
        read_entries(&[("a.txt", "")]).unwrap_err().to_string(),
        "archive has no entry 3D/3dmodel.model"
    );
    let error = Model::read(
        Format::ThreeMf,
        b"no archive at all",
        &ReadLimits::default(),
        &Control::default(),
    )
    .unwrap_err();
    assert_eq!(error.to_string(), "not a valid 3MF file: not a ZIP archive");
}

#[test]
fn unused_vertices_are_dropped() {
    let spare = TETRA
        .replace("</vertices>", &(r#"<vertex x="9" y="9" z="9"/>"#.repeat(20) + "</vertices>"));
    let spare =
        spare.replace("<vertices>", &("<vertices>".to_owned() + r#"<vertex x="9" y="9" z="9"/>"#));
    let shifted = [("4", "5"), ("3", "4"), ("2", "3"), ("1", "2"), ("0", "1")].iter().fold(
        spare,
        |text, (from, to)| {
            (1..4).fold(text, |text, corner| {
                text.replace(&format!("v{corner}=\"{from}\""), &format!("v{corner}=\"{to}\""))
            })
        },
    );
    let resources = format!(
        r#"<object id="1">{TETRA}</object><object id="2">{shifted}</object>
        <object id="3"><mesh></mesh></object>"#
    );
    let build = r#"<item objectid="1"/><item objectid="2"/><item objectid="3"/>"#;
    let model = read_model(&resources, build).unwrap();
    let [plain, spare] = &model.bodies[..] else { panic!("two bodies") };
    assert_eq!(plain.mesh, spare.mesh);
}

#[test]
fn archives_that_unpack_beyond_the_limit_are_refused() {
    let spaces = " ".repeat(8 << 20);
    let bomb = archive(&[("3D/3dmodel.model", &model(&spaces, ""))]);
    assert!(bomb.len() < 20_000);
    let limits = ReadLimits { unpacked_bytes: 1 << 20, ..ReadLimits::default() };
    let error = Model::read(Format::ThreeMf, &bomb, &limits, &Control::default()).unwrap_err();
    assert_eq!(error.to_string(), "file has more than 1048576 bytes when unpacked");
    // Objects made of two of the one before: 2^30 bodies of 4 triangles.
    let mut resources = format!(r#"<object id="1">{TETRA}</object>"#);
    for id in 2..31 {
        let part = format!(r#"<component objectid="{}"/>"#, id - 1);
        write!(resources, r#"<object id="{id}"><components>{part}{part}</components></object>"#)
            .unwrap();
    }
    let limits = ReadLimits { triangles: 10_000, ..ReadLimits::default() };
    let bomb = archive(&[("3D/3dmodel.model", &model(&resources, r#"<item objectid="30"/>"#))]);
    assert!(matches!(
        Model::read(Format::ThreeMf, &bomb, &limits, &Control::default()),
        Err(ReadError::TooLarge { .. })
    ));
}

#[test]
fn unpacking_can_be_cancelled_and_reports_progress() {
    let noise = |id: u32| {
        (0..60_000).fold(String::new(), |text, at: u32| {
            text + &format!(
                "<metadata>{}</metadata>",
                at.wrapping_mul(2_654_435_761).rotate_left(id)
            )
        })
    };
    let first = format!(r#"<object id="1">{TETRA}</object>{}"#, noise(1));
    let bytes = archive(&[("3D/3dmodel.model", &model(&first, r#"<item objectid="1"/>"#))]);
    let seen = std::sync::Mutex::new(Vec::new());
    let cancel = CancelToken::new();
    let progress = |progress: Progress| seen.lock().unwrap().push(progress);
    let control =
        Control { cancel: Some(&cancel), progress: Some(&progress), ..Control::default() };
    let limits = ReadLimits::default();
    Model::read(Format::ThreeMf, &bytes, &limits, &control).unwrap();
    let total = bytes.len();
    {
        let seen = seen.lock().unwrap();
        assert!(seen.len() > 10 && seen.is_sorted_by_key(|progress| progress.done));
        assert_eq!(seen.last(), Some(&Progress { done: total, total }));
    }
    cancel.cancel();
    let error = Model::read(Format::ThreeMf, &bytes, &limits, &control);
    assert!(matches!(error, Err(ReadError::Interrupted(Interrupted::Cancelled))));
}
