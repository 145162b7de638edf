//! `plan` on projects of slicers: painted facets, roles of parts, and purge volumes.

use std::fmt::Write as _;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::Path;

use beadwork_tests::{beadwork, fail, text};
use serde_json::Value;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// The corners of the 12 facets of a box; bit 0 of a corner is x, bit 1 is y, bit 2 is z.
const FACETS: [[u32; 3]; 12] = [
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

/// The mesh of a box in mm; `attribute` returns more of each facet.
fn mesh(min: [u32; 3], size: [u32; 3], attribute: impl Fn(usize) -> String) -> String {
    let mut mesh = String::from("<mesh><vertices>");
    for corner in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|axis| min[axis] + (corner >> axis & 1) * size[axis]);
        write!(mesh, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#).unwrap();
    }
    mesh += "</vertices><triangles>";
    for (number, [a, b, c]) in FACETS.into_iter().enumerate() {
        let more = attribute(number);
        write!(mesh, r#"<triangle v1="{a}" v2="{b}" v3="{c}"{more}/>"#).unwrap();
    }
    mesh + "</triangles></mesh>"
}

fn document(resources: &str, build: &str) -> String {
    format!(
        r#"<model unit="millimeter"
        xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>{resources}</resources><build>{build}</build></model>"#
    )
}

fn write(path: &Path, entries: &[(&str, &str)]) {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in entries {
        writer.start_file(*name, SimpleFileOptions::default()).unwrap();
        writer.write_all(text.as_bytes()).unwrap();
    }
    fs::write(path, writer.finish().unwrap().into_inner()).unwrap();
}

/// The JSON document and the standard error of a plan.
fn plan(path: &Path, more: &[&str]) -> (Value, String) {
    let arguments = [&["plan", text(path), "--objective", "tools", "--json"], more].concat();
    let output = beadwork().args(&arguments).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    (serde_json::from_slice(&output.stdout).unwrap(), stderr)
}

fn volumes(plan: &Value) -> Vec<f64> {
    let tools = plan["tools"].as_array().unwrap();
    tools.iter().map(|tool| tool["volume_mm3"].as_f64().unwrap().round()).collect()
}

#[test]
fn the_purge_volumes_of_a_project_are_used_unless_flags_state_others() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.3mf");
    let cube = |id: u32, x: u32| {
        format!(r#"<object id="{id}">{}</object>"#, mesh([x, 0, 0], [6, 6, 1], |_| String::new()))
    };
    let resources = cube(1, 0)
        + &cube(2, 9)
        + r#"<object id="3"><components><component objectid="1"/><component objectid="2"/>
        </components></object>"#;
    let settings = r#"<config><object id="3"><metadata key="extruder" value="1"/>
        <part id="2" subtype="normal_part"><metadata key="extruder" value="3"/></part></object>
        </config>"#;
    let project = r##"{"filament_colour": ["#FF0000", "#00FF00", "#0000FF"],
        "filament_type": ["PLA", "PLA", "PETG"], "flush_multiplier": ["0.5"],
        "flush_volumes_matrix": ["0", "1", "400", "1", "0", "1", "200", "1", "0"]}"##;
    write(
        &file,
        &[
            ("3D/3dmodel.model", &document(&resources, r#"<item objectid="3"/>"#)),
            ("Metadata/model_settings.config", settings),
            ("Metadata/project_settings.config", project),
        ],
    );
    let (stated, stderr) = plan(&file, &[]);
    assert_eq!(stated["materials"], serde_json::json!(["filament 1 (PLA)", "filament 3 (PETG)"]));
    assert!(stderr.contains("purge volumes are those of the project"), "{stderr}");
    // Four layers: two changes of 200 mm³ and two of 100 mm³.
    assert_eq!((&stated["tool_changes"], &stated["tool_cost"]), (&4.into(), &600.into()));

    let (flag, stderr) = plan(&file, &["--purge", "50"]);
    assert_eq!(flag["tool_cost"], 200);
    assert!(!stderr.contains("purge volumes"), "{stderr}");

    let profile = folder.path().join("printer.toml");
    fs::write(&profile, "[purge]\nvolume_mm3 = [[0.0, 30.0], [30.0, 0.0]]\n").unwrap();
    let (own, stderr) = plan(&file, &["--profile", text(&profile)]);
    assert_eq!(own["tool_cost"], 120);
    assert!(!stderr.contains("purge volumes"), "{stderr}");
}

// prusa3d/PrusaSlicer#12502, #15694
#[test]
fn painted_facets_and_negative_parts_are_planned() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("painted.3mf");
    // The left side is filament 2, and half of it by two painted halves of its facets.
    let paint = |facet: usize| match facet {
        8 => r#" paint_color="8""#.to_owned(),
        9 => r#" paint_color="88883""#.to_owned(),
        _ => String::new(),
    };
    let negative = mesh([14, 0, 0], [6, 10, 6], |_| String::new());
    let resources = format!(
        r#"<object id="1">{}</object><object id="2" type="other">{negative}</object>
        <object id="3"><components><component objectid="1"/><component objectid="2"/></components>
        </object>"#,
        mesh([0, 0, 0], [20, 10, 6], paint)
    );
    let settings = r#"<config><object id="3"><part id="1" subtype="normal_part"/>
        <part id="2" subtype="negative_part"/></object></config>"#;
    let root = document(&resources, r#"<item objectid="3"/>"#);
    let entries = [("3D/3dmodel.model", &root[..]), ("Metadata/model_settings.config", settings)];
    write(&file, &entries);
    let (plan, _) = plan(&file, &["--purge", "0", "--tower", "none"]);
    let volumes = volumes(&plan);
    assert!((volumes.iter().sum::<f64>() - 840.0).abs() <= 1.0, "{volumes:?}");
    // The cells that are nearest to the left side: a triangle of 10 x 5 mm, and less near the top
    // and the bottom.
    assert!((80.0..150.0).contains(&volumes[1]), "{volumes:?}");

    write(&file, &[entries[0], (entries[1].0, &settings.replace("negative", "hologram"))]);
    let error = fail(&["plan", text(&file), "--objective", "tools", "--json"]);
    assert!(error.contains("unknown type of a part: 'hologram_part'"), "{error}");
}
