//! What the published specifications define.

use super::*;

const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";

fn item(id: u32) -> String {
    format!(r#"<item objectid="{id}"/>"#)
}

fn tetra() -> String {
    TETRA.replace(" p1=\"1\"", "")
}

/// A document whose root element has more attributes.
fn with_attributes(attributes: &str, resources: &str, build: &str) -> Result<Model, ReadError> {
    let text = format!(
        r#"<model xmlns="{CORE}" {attributes}><resources>{resources}</resources>
        <build>{build}</build></model>"#
    );
    read_entries(&[("3D/3dmodel.model", &text)])
}

#[test]
fn required_extensions_are_refused_by_name() {
    let object = format!(r#"<object id="1">{}</object>"#, tetra());
    for (namespace, name) in [
        (
            "http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07",
            "boolean operations extension",
        ),
        (
            "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02",
            "beam lattice extension",
        ),
        ("http://schemas.microsoft.com/3dmanufacturing/slice/2015/07", "slice extension"),
        (
            "http://schemas.microsoft.com/3dmanufacturing/securecontent/2019/07",
            "secure content extension",
        ),
        ("http://example.com/gears", "extension http://example.com/gears"),
    ] {
        let attributes = format!(r#"xmlns:q="{namespace}" requiredextensions="q""#);
        let error = with_attributes(&attributes, &object, &item(1)).unwrap_err().to_string();
        assert!(
            error.ends_with(&format!("file requires the {name}, which is not supported")),
            "{error}"
        );
        // It is only used if it is not required.
        let attributes = attributes.replace("required", "recommended");
        let model = with_attributes(&attributes, &object, &item(1)).unwrap();
        assert_eq!(warnings(&model), [format!("data of the {name}: not used")]);
    }
    let error = with_attributes(r#"requiredextensions="x""#, &object, &item(1)).unwrap_err();
    assert!(error.to_string().contains("file requires the extension x, which is not supported"));
    let supported =
        format!(r#"xmlns:p="{PRODUCTION}" xmlns:m="{MATERIALS}" requiredextensions="p  m""#);
    assert_eq!(warnings(&with_attributes(&supported, &object, &item(1)).unwrap()), [""; 0]);
}

// F27b: a boolean shape next to a mesh
#[test]
fn shapes_of_extensions_are_not_empty_meshes() {
    let boolean = r#"xmlns:any="http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07""#;
    let resources = format!(
        r#"<object id="1">{0}</object><object id="2"><any:booleanshape objectid="1"
        operation="difference"><any:boolean objectid="1"/></any:booleanshape></object>"#,
        tetra()
    );
    let both = item(1) + &item(2);
    let error = with_attributes(boolean, &resources, &both).unwrap_err().to_string();
    assert!(
        error.ends_with("object 2 needs the boolean operations extension, which is not supported"),
        "{error}"
    );
    // An object that is not printed does not matter.
    assert_eq!(with_attributes(boolean, &resources, &item(1)).unwrap().bodies.len(), 1);

    let lattice = r#"xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02""#;
    let with_beams = format!(
        r#"<object id="1">{}</object>"#,
        tetra()
            .replace("</mesh>", r#"<b:beamlattice radius="1"><b:beams/></b:beamlattice></mesh>"#)
    );
    let error = with_attributes(lattice, &with_beams, &item(1)).unwrap_err().to_string();
    assert!(error.contains("object 1 needs the beam lattice extension"), "{error}");

    let unknown = r#"<object id="1"><u:blob xmlns:u="http://example.com/blobs"/></object>"#;
    let error = with_attributes("", unknown, &item(1)).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "object 1 has no triangles, but data of the extension http://example.com/blobs, which \
             is not supported"
        ),
        "{error}"
    );

    let slices = r#"xmlns:s="http://schemas.microsoft.com/3dmanufacturing/slice/2015/07""#;
    let sliced = format!(r#"<object id="1" s:slicestackid="9">{}</object>"#, tetra());
    let model = with_attributes(slices, &sliced, &item(1)).unwrap();
    assert_eq!(warnings(&model), ["slices of objects with a mesh: not used"]);
    let coarse = sliced.replace("stackid=\"9\"", "stackid=\"9\" s:meshresolution=\"lowres\"");
    assert!(with_attributes(slices, &coarse, &item(1)).is_err());
    let empty = r#"<object id="1" s:slicestackid="9"><mesh/></object>"#;
    assert!(with_attributes(slices, empty, &item(1)).is_err());
}

#[test]
fn elements_belong_to_their_namespace() {
    // Triangles, objects and items of a vendor.
    let vendor = r#"xmlns:v="http://example.com/v""#;
    let resources = format!(
        r#"<v:object id="1"/><object id="1">{}</object>"#,
        tetra().replace("</triangles>", r#"<v:triangle v1="0" v2="1" v3="2"/></triangles>"#)
    );
    let build = item(1) + r#"<v:item objectid="1"/>"#;
    let model = with_attributes(vendor, &resources, &build).unwrap();
    assert_eq!(model.triangle_count(), 4);
    assert_eq!(warnings(&model), ["data of the extension http://example.com/v: not used"]);
    // The core specification with a prefix, and materials without.
    let text = format!(
        r##"<c:model xmlns:c="{CORE}"><c:resources><colorgroup xmlns="{MATERIALS}" id="3">
        <color color="#010203"/></colorgroup><c:object id="1" pid="3" pindex="0">{}</c:object>
        </c:resources><c:build><c:item objectid="1"/></c:build></c:model>"##,
        ["mesh", "vertices", "vertex", "triangles", "triangle"].iter().fold(
            tetra(),
            |text, name| {
                ["<", "</"].iter().fold(text, |text, start| {
                    [" ", ">", "/>"].iter().fold(text, |text, end| {
                        text.replace(
                            &format!("{start}{name}{end}"),
                            &format!("{start}c:{name}{end}"),
                        )
                    })
                })
            }
        )
    );
    let model = read_entries(&[("3D/3dmodel.model", &text)]).unwrap();
    assert_eq!((model.triangle_count(), &model.materials[0].name[..]), (4, "#010203"));
    assert!(model.warnings.is_empty());
    let foreign = r#"<model xmlns="http://example.com/model"/>"#;
    let error = read_entries(&[("3D/3dmodel.model", foreign)]).unwrap_err().to_string();
    assert!(error.contains("<model> is not a 3MF model"), "{error}");
}

// 3MFConsortium/spec_core#60
#[test]
fn an_empty_build_is_named() {
    let object = format!(r#"<object id="1">{}</object>"#, tetra());
    for text in [
        format!(
            "<model><resources>{object}{}</resources></model>",
            object.replace("\"1\">", "\"2\">")
        ),
        format!("<model><resources>{object}</resources><build/></model>"),
        "<model/>".into(),
    ] {
        let error = read_entries(&[("3D/3dmodel.model", &text)]).unwrap_err().to_string();
        assert!(error.starts_with("3D/3dmodel.model: build is empty: "), "{error}");
    }
    let sliced = [("3D/3dmodel.model", "<model/>"), ("Metadata/plate_1.gcode", "G28")];
    assert!(read_entries(&sliced).unwrap_err().to_string().contains("G-code of a print"));
}

// bambulab/BambuStudio: attribute printable
#[test]
fn items_that_are_not_printable_are_named() {
    let resources =
        format!(r#"<object id="1" name="lid">{0}</object><object id="2">{0}</object>"#, tetra());
    let items = r#"<item objectid="1" printable="0"/><item objectid="2" printable="1"/>
        <item objectid="2" printable="false"/>"#;
    let model = read_model(&resources, items).unwrap();
    assert_eq!(model.bodies.len(), 1);
    assert_eq!(
        warnings(&model),
        ["objects that are marked printable=\"0\" (lid, object 2): not used"]
    );
    assert!(
        refused(&resources, r#"<item objectid="1" printable="0"/>"#).contains("no printable items")
    );
}

#[test]
fn types_of_objects_decide_for_meshes_only() {
    // Section 4: the type of an object with components is ignored.
    let resources = format!(
        r#"<object id="1" type="surface" name="skin">{0}</object><object id="2">{0}</object>
        <object id="3" type="other"><components><component objectid="1"/>
        <component objectid="2"/></components></object><object id="4"><mesh/></object>"#,
        tetra()
    );
    let model = read_model(&resources, &(item(3) + &item(4))).unwrap();
    assert_eq!(model.bodies.len(), 1);
    assert_eq!(
        warnings(&model),
        [
            "objects of type surface (skin): not used",
            "objects without triangles (object 4): not used"
        ]
    );
    assert!(refused(r#"<object id="1" type="ghost"/>"#, "").contains("unknown type 'ghost'"));
    assert!(
        refused(r#"<object id="1"/><object id="1"/>"#, "").contains("id 1 is used by two objects")
    );
}

#[test]
fn other_documents_have_their_own_unit() {
    let millimetres = |resources: &str| {
        format!(
            r#"<model unit="millimeter" xmlns:p="{PRODUCTION}">
            <resources>{resources}</resources></model>"#
        )
    };
    let root = model(
        r#"<object id="1"><components><component p:path="/3D/a.model" objectid="7"
        transform="1 0 0 0 1 0 0 0 1 1 0 0"/></components></object>"#,
        r#"<item objectid="1"/><item objectid="7" p:path="/3D/a.model"/>"#,
    );
    let part = millimetres(&format!(r#"<object id="7">{}</object>"#, tetra()));
    let read = read_entries(&[("3D/3dmodel.model", &root), ("3D/a.model", &part)]).unwrap();
    let bounds: Vec<_> = read.bodies.iter().map(|body| body.mesh.bounds()).collect();
    assert!((bounds[0].min[0] - 25.4).abs() < 1e-9 && (bounds[0].max[0] - 26.4).abs() < 1e-9);
    assert!((bounds[1].max[0] - 1.0).abs() < 1e-9);
    assert_eq!((read.bodies[0].copy_of, read.bodies[1].copy_of), (Some(0), Some(0)));
    // Production extension, section 2: only the root document refers to others.
    let part = millimetres(
        r#"<object id="7"><components><component p:path="/3D/b.model" objectid="1"/></components>
        </object>"#,
    );
    let error = read_entries(&[("3D/3dmodel.model", &root), ("3D/a.model", &part)]).unwrap_err();
    assert!(
        error.to_string().contains("object 7 refers to 3D/b.model: only objects of"),
        "{error}"
    );
}

// andymai/gridfinity#1885
#[test]
fn a_colour_is_one_material_however_it_is_written() {
    let resources = format!(
        r##"<m:colorgroup id="5"><m:color color="#FF0000"/><m:color color="#ff0000ff"/>
        <m:color color="#FF000080"/></m:colorgroup>
        <m:colorgroup id="6"><m:color color="#Ff0000"/></m:colorgroup>
        <basematerials id="7"><base name="#ff0000" displaycolor="#FF0000FF"/>
        <base name="PLA" displaycolor="#FF0000"/></basematerials>
        <basematerials id="8"><base name="PLA" displaycolor="#ff0000ff"/></basematerials>
        <object id="1" pid="5" pindex="0">{0}</object><object id="2" pid="5" pindex="1">{0}</object>
        <object id="3" pid="5" pindex="2">{0}</object><object id="4" pid="6" pindex="0">{0}</object>
        <object id="9" pid="7" pindex="0">{0}</object>
        <object id="10" pid="7" pindex="1">{0}</object>
        <object id="11" pid="8" pindex="0">{0}</object>"##,
        tetra()
    );
    let build: String = [1, 2, 3, 4, 9, 10, 11].map(item).concat();
    let mut model = read_model(&resources, &build).unwrap();
    model.assign_materials(MaterialRule::Stated);
    let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["#FF0000", "PLA"]);
}

#[test]
fn mixed_materials_are_those_that_can_be_printed() {
    let resources = format!(
        r##"<basematerials id="5"><base name="A" displaycolor="#FF0000"/>
        <base name="B" displaycolor="#00FF00"/></basematerials>
        <m:compositematerials id="6" matid="5" matindices="0 1"><m:composite values="0.4 0.6"/>
        <m:composite values="0 0"/></m:compositematerials>
        <m:colorgroup id="7"><m:color color="#0000FF"/><m:color color="#FFFFFF"/></m:colorgroup>
        <m:multiproperties id="8" pids="6 7"><m:multi pindices="0 1"/><m:multi pindices="1"/>
        </m:multiproperties>
        <m:texture2d id="20" path="/a.png" contenttype="image/png"/>
        <m:texture2dgroup id="9" texid="20"><m:tex2coord u="0" v="0"/></m:texture2dgroup>
        <object id="1" pid="6" pindex="0">{0}</object><object id="2" pid="6" pindex="1">{0}</object>
        <object id="3" pid="8" pindex="0">{0}</object><object id="4" pid="8" pindex="1">{0}</object>
        <object id="10" pid="9" pindex="0">{0}</object>
        <object id="11" pid="7" pindex="0">{1}</object>"##,
        tetra(),
        TETRA.replace("p1=\"1\"", "p1=\"1\" p2=\"0\" p3=\"1\"")
    );
    let build: String = [1, 2, 3, 4, 10, 11].map(item).concat();
    let model = read_model(&resources, &build).unwrap();
    let name = |body: usize| {
        let material = model.bodies[body].material?;
        Some(model.materials[material].name.as_str())
    };
    assert_eq!(
        [0, 1, 2, 3, 4].map(name),
        [Some("B"), Some("A"), Some("#FFFFFF"), Some("#0000FF"), None]
    );
    assert_eq!(model.bodies[5].paint.len(), 4);
    assert_eq!(
        warnings(&model),
        [
            "textures: not used",
            "colour gradients: the first corner of each triangle counts",
            "composite materials: the largest constituent is used",
        ]
    );
}

#[test]
fn data_that_is_not_known_is_reported_once() {
    let object = format!(
        r#"<object id="1">{}</object>"#,
        tetra().replace("v3=", "face=\"1\" v3=").replace("<vertex ", "<vertex r=\"0.5\" ")
    );
    let model = read_model(&object, &item(1)).unwrap();
    assert_eq!(
        warnings(&model),
        ["attributes of vertices (r): not used", "attributes of triangles (face): not used"]
    );
}

#[test]
fn names_of_entries_are_compared_by_their_meaning() {
    let root = model(
        r#"<object id="1"><components><component p:path="/3D/my%20part.model" objectid="7"/>
        </components></object>"#,
        &item(1),
    );
    let other = model(&format!(r#"<object id="7">{}</object>"#, tetra()), "");
    let entries = [("3D\\3dmodel.model", &root[..]), ("3d/My part.model", &other)];
    assert_eq!(read_entries(&entries).unwrap().bodies.len(), 1);
}

#[test]
fn objects_that_only_other_programs_understand_are_refused() {
    let with = |metadata: &str| {
        format!(
            r#"<object id="1"><metadatagroup><metadata name="{metadata}">True</metadata>
            <metadata name="note">x</metadata></metadatagroup>{}</object>"#,
            tetra()
        )
    };
    let error = refused(&with("cura:support_mesh"), &item(1));
    assert!(error.ends_with("object 1 is marked as support mesh of Cura, which is not supported"));
    let model = read_model(&with("cura:extruder_nr"), &item(1)).unwrap();
    assert_eq!(warnings(&model), ["settings of objects (cura:extruder_nr): not used"]);

    let slic3r = r#"xmlns:slic3r="http://schemas.slic3r.org/3mf/2017/06""#;
    let volumes = r#"<slic3r:volumes><slic3r:volume ts="0" te="3" modifier="0"/></slic3r:volumes>"#;
    let object = format!(
        r#"<object id="1">{}</object>"#,
        tetra().replace("</mesh>", &format!("{volumes}</mesh>"))
    );
    assert_eq!(warnings(&with_attributes(slic3r, &object, &item(1)).unwrap()), [""; 0]);
    let object = object.replace(r#"modifier="0""#, r#"modifier="1""#);
    let error = with_attributes(slic3r, &object, &item(1)).unwrap_err().to_string();
    assert!(
        error.ends_with("object 1 has a modifier of Slic3r, which is not supported"),
        "{error}"
    );
}

// Core specification, section 2.3.2
#[test]
fn xml_that_the_specification_forbids_is_refused() {
    let text = model(&format!(r#"<object id="1">{}</object>"#, tetra()), &item(1));
    let marked = "\u{feff}".to_owned() + &text;
    assert_eq!(read_entries(&[("3D/3dmodel.model", &marked)]).unwrap().bodies.len(), 1);
    let with_dtd = text.replacen("<model", "<!DOCTYPE model [<!ENTITY e \"x\">]><model", 1);
    let error = read_entries(&[("3D/3dmodel.model", &with_dtd)]).unwrap_err().to_string();
    assert!(error.contains("document type definition"), "{error}");
    let utf16: Vec<u8> = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    writer.start_file("3D/3dmodel.model", SimpleFileOptions::default()).unwrap();
    writer.write_all(&utf16).unwrap();
    let bytes = writer.finish().unwrap().into_inner();
    let limits = ReadLimits::default();
    let error = Model::read(Format::ThreeMf, &bytes, &limits, &Control::default()).unwrap_err();
    assert_eq!(error.to_string(), "3D/3dmodel.model, byte 0: XML is UTF-16, expected UTF-8");
}
