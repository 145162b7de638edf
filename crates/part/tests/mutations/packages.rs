//! Valid 3MF archives, those of slicers included.

use std::fmt::Write as _;

use beadwork_mesh::{Format, Mesh, Solid};
use zip::CompressionMethod;

use crate::meshes::{cube, sphere};
use crate::seed::{Seed, pack};

/// A mesh in 3MF; `paint` is added to every third triangle.
fn mesh_xml(mesh: &Mesh, paint: &str) -> String {
    let mut text = String::from("<mesh><vertices>");
    for [x, y, z] in mesh.vertices() {
        write!(text, "<vertex x=\"{x:.3}\" y=\"{y:.3}\" z=\"{z:.3}\"/>").unwrap();
    }
    text.push_str("</vertices><triangles>");
    for (number, [a, b, c]) in mesh.triangles().iter().enumerate() {
        let paint = if number % 3 == 0 { paint } else { "" };
        write!(text, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"{paint}/>").unwrap();
    }
    text + "</triangles></mesh>"
}

pub(crate) fn threemf_seeds() -> Vec<Seed> {
    const LIST: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?><Relationships \
        xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship \
        Id=\"rel0\" Target=\"/3D/parts.model\" \
        Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let model = |resources: &str, build: &str| {
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?><model unit=\"millimeter\" \
             xml:lang=\"en-US\" \
             xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
             xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" \
             xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\">\
             <resources>{resources}</resources><build>{build}</build></model>"
        )
    };
    let part = |name: &str, text: String| (name.to_owned(), text.into_bytes());
    let simple = model(
        &format!(r#"<object id="1" type="model" name="cube">{}</object>"#, mesh_xml(&cube(), "")),
        r#"<item objectid="1"/>"#,
    );
    let groups = "<basematerials id=\"5\"><base name=\"PLA &amp; co\" displaycolor=\"#FF0000FF\"/>\
        <base name=\"ABS\" displaycolor=\"#00FF00\"/></basematerials><m:colorgroup id=\"6\">\
        <m:color color=\"#0000FF\"/><m:color color=\"#808080\"/></m:colorgroup>";
    let painted = model(
        &format!(
            "{groups}<object id=\"1\" pid=\"5\" pindex=\"0\" name=\"a\">{}</object><object \
             id=\"2\" pid=\"6\">{}</object><object id=\"3\" pid=\"5\" pindex=\"1\"><components>\
             <component objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 20 0 0\"/><component \
             objectid=\"2\"/></components></object>",
            mesh_xml(&cube(), r#" p1="1""#),
            mesh_xml(&sphere(), r#" pid="5" p1="1""#)
        ),
        r#"<item objectid="3" transform="1 0 0 0 1 0 0 0 1 0 0 2"/><item objectid="1"/>"#,
    );
    let root = model(
        "<object id=\"1\"><components><component p:path=\"/3D/other.model\" objectid=\"7\"/>\
         <component p:path=\"/3d/Other.model\" objectid=\"8\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 \
         0\"/></components></object>",
        r#"<item objectid="1" transform=".5 0 0 0 .5 0 0 0 .5 1 2 3"/>"#,
    );
    let other = model(
        &format!(
            "{groups}<object id=\"7\" pid=\"5\">{}</object><object id=\"8\" type=\"solidsupport\">\
             {}</object>",
            mesh_xml(&cube(), r#" pid="6" p1="0""#),
            mesh_xml(&Solid::Frustum { sides_mm: [4.0, 2.0], height_mm: 5.0 }.mesh(), "")
        ),
        "",
    );
    let in_parts = vec![
        part("_rels/.rels", LIST.to_owned()),
        part("3D/parts.model", root),
        part("3D/other.model", other),
    ];
    let stored = pack(&in_parts, CompressionMethod::Stored);
    let mut seeds = vec![Seed::mesh("stored.3mf", Format::ThreeMf, stored)];
    seeds.extend(Seed::package("simple.3mf", vec![part("3D/3dmodel.model", simple)]));
    seeds.extend(Seed::package("painted.3mf", vec![part("3D/3dmodel.model", painted)]));
    seeds.extend(Seed::package("parts.3mf", in_parts));
    seeds.extend(project_seeds(model));
    seeds
}

/// Projects of slicers, and materials that are mixed; `model` writes a document.
fn project_seeds(model: impl Fn(&str, &str) -> String) -> Vec<Seed> {
    let part = |name: &str, text: String| (name.to_owned(), text.into_bytes());
    let paint = |text: &str| format!(" slic3rpe:mmu_segmentation=\"{text}\"");
    let prusa = vec![
        part(
            "3D/3dmodel.model",
            model(
                &format!(
                    "<object id=\"1\" xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\">{}\
                     </object><object id=\"2\"><components><component objectid=\"1\"/>\
                     </components></object>",
                    mesh_xml(&cube(), &paint("480C48463"))
                ),
                "<item objectid=\"1\" printable=\"1\"/><item objectid=\"2\" \
                 transform=\"1 0 0 0 1 0 0 0 1 20 0 0\"/><item objectid=\"2\" printable=\"0\"/>",
            ),
        ),
        part(
            "Metadata/Slic3r_PE_model.config",
            "<config><object id=\"1\" instances_count=\"2\"><metadata type=\"object\" \
             key=\"name\" value=\"x\"/><metadata type=\"object\" key=\"extruder\" value=\"2\"/>\
             <volume firstid=\"0\" lastid=\"11\"><metadata type=\"volume\" key=\"volume_type\" \
             value=\"ModelPart\"/><metadata type=\"volume\" key=\"extruder\" value=\"0\"/></volume>\
             </object></config>"
                .to_owned(),
        ),
        part(
            "Metadata/Slic3r_PE.config",
            "; filament_colour = #FF0000;#00FF00;#0000FF\n; extruder_colour = \"\";#112233\n\
             ; wiping_volumes_matrix = 0,70,80,90,0,60,50,40,0\n; filament_type = PLA;PETG\n"
                .to_owned(),
        ),
    ];
    let bambu = vec![
        part(
            "3D/3dmodel.model",
            model(
                "<object id=\"9\"><components><component p:path=\"/3D/Objects/o_1.model\" \
                 objectid=\"1\"/><component p:path=\"/3D/Objects/o_1.model\" objectid=\"2\" \
                 transform=\"1 0 0 0 1 0 0 0 1 2 0 0\"/></components></object>",
                "<item objectid=\"9\" printable=\"1\"/><item objectid=\"9\" \
                 transform=\"1 0 0 0 1 0 0 0 1 300 0 0\"/>",
            ),
        ),
        part(
            "3D/Objects/o_1.model",
            model(
                &format!(
                    "<object id=\"1\">{}</object><object id=\"2\" type=\"other\">{}</object>",
                    mesh_xml(&sphere(), " paint_color=\"1C4811\" paint_seam=\"4\""),
                    mesh_xml(&cube(), "")
                ),
                "",
            ),
        ),
        part(
            "Metadata/model_settings.config",
            "<config><object id=\"9\"><metadata key=\"extruder\" value=\"1\"/><part id=\"1\" \
             subtype=\"normal_part\"><metadata key=\"extruder\" value=\"3\"/></part><part id=\"2\" \
             subtype=\"negative_part\"/></object><plate><metadata key=\"plater_id\" value=\"1\"/>\
             <model_instance><metadata key=\"object_id\" value=\"9\"/><metadata \
             key=\"instance_id\" value=\"0\"/></model_instance></plate><plate><metadata \
             key=\"plater_id\" value=\"2\"/><model_instance><metadata key=\"object_id\" \
             value=\"9\"/><metadata key=\"instance_id\" value=\"1\"/></model_instance></plate>\
             </config>"
                .to_owned(),
        ),
        part(
            "Metadata/project_settings.config",
            "{\"filament_colour\": [\"#FF0000\", \"#00FF00FF\"], \"filament_type\": [\"PLA\"], \
             \"flush_multiplier\": [\"1\", \"1\"], \"flush_volumes_matrix\": [\"0\", \"280\", \
             \"140\", \"0\", \"0\", \"280\", \"140\", \"0\"], \"layer_height\": \"0.2\"}"
                .to_owned(),
        ),
    ];
    let mixed = model(
        &format!(
            "<basematerials id=\"5\"><base name=\"A\" displaycolor=\"#FF0000FF\"/><base name=\"B\" \
             displaycolor=\"#00FF00\"/></basematerials><m:compositematerials id=\"6\" matid=\"5\" \
             matindices=\"0 1\"><m:composite values=\"0.3 0.7\"/></m:compositematerials>\
             <m:colorgroup id=\"7\"><m:color color=\"#0000FF80\"/><m:color color=\"#808080\"/>\
             </m:colorgroup><m:multiproperties id=\"8\" pids=\"6 7\" blendmethods=\"multiply\">\
             <m:multi pindices=\"0 1\"/><m:multi/></m:multiproperties><object id=\"1\" pid=\"8\" \
             pindex=\"0\">{}</object>",
            mesh_xml(&cube(), " p1=\"1\" p2=\"0\" p3=\"1\"")
        ),
        "<item objectid=\"1\"/>",
    );
    [
        Seed::package("prusa.3mf", prusa),
        Seed::package("bambu.3mf", bambu),
        Seed::package("mixed.3mf", vec![part("3D/3dmodel.model", mixed)]),
    ]
    .into_iter()
    .flatten()
    .collect()
}
