//! Damaged files: random changes of valid files must lead to a result or an error, not to a panic,
//! a hang or excessive memory.
//!
//! Every case takes a seed (a small file made here, or one of `../shared/parts` if that folder
//! exists), changes it in one to eight positions and runs all steps on it: meshes are read,
//! repaired, given materials, placed on the bed and sliced; G-code is read, emitted and read again,
//! traced, timed and checked.
//! 3MF archives are changed both as bytes and before they are packed, because checksums hide most
//! of the reader from changes of the bytes.
//!
//! A case depends only on its seed and its number.
//! Manual runs:
//!
//! ```text
//! BEADWORK_MUTATIONS=300000 cargo test --release -p beadwork-part --test mutations -- --nocapture
//! BEADWORK_MUTATION_CASE='cube.obj 1234' \
//!     cargo test -p beadwork-part --test mutations -- --nocapture
//! ```
//!
//! The first runs 300,000 cases instead of a few thousand; the second repeats one case.
//! No files are written.
//!
//! # Hangs and memory
//! A watchdog thread aborts the process with the name of the case if a case takes more than 20 s:
//! on any machine, input of a few KB that takes this long is a hang.
//! On Linux the peak memory of the process must stay below 1 GiB, with the default limits of the
//! readers.
#![allow(clippy::unwrap_used, reason = "a test may fail")]
#![allow(clippy::print_stderr, reason = "skipped folders and failing cases are reported")]

use std::fmt::Write as _;
use std::io::{Cursor, Read as _, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path as FilePath;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use beadwork_base::Control;
use beadwork_gcode::{Event, Program};
use beadwork_grid::{Layout, LayoutSpec, Path, Region, Zones, cover};
use beadwork_mesh::{
    Format, MaterialRule, Mesh, Model, Placement, ReadLimits, RepairSettings, Solid, Transform,
};
use beadwork_part::print::{self, Flavour, PrimeTower, Print, Printer, Purge, Title, Tool};
use beadwork_part::{Frame, slice};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Number of cases without `BEADWORK_MUTATIONS`.
const CASES: u64 = 4_000;
/// Time after which a case counts as a hang.
const HANG: Duration = Duration::from_secs(20);
/// Maximum peak memory of the process in KiB.
const MAX_KIB: u64 = 1 << 20;
/// Number of tests that share the cases.
const TESTS: u64 = 4;

/// A valid file.
struct Seed {
    name: String,
    content: Content,
}

enum Content {
    Mesh(Format, Vec<u8>),
    /// The parts of a 3MF archive, changed before they are packed.
    Parts(Vec<(String, Vec<u8>)>),
    Gcode(Vec<u8>),
}

impl Seed {
    fn mesh(name: &str, format: Format, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.to_owned(), content: Content::Mesh(format, bytes.into()) }
    }

    fn gcode(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.to_owned(), content: Content::Gcode(bytes.into()) }
    }

    /// Two seeds of an archive: one changed as bytes, one changed before it is packed.
    fn package(name: &str, parts: Vec<(String, Vec<u8>)>) -> [Self; 2] {
        let bytes = pack(&parts, CompressionMethod::Deflated);
        let unpacked = Self { name: format!("{name}/parts"), content: Content::Parts(parts) };
        [Self::mesh(name, Format::ThreeMf, bytes), unpacked]
    }

    /// Relative number of cases: large files take longer and get fewer.
    fn weight(&self) -> f64 {
        let bytes = match &self.content {
            // Unpacked it is about eight times as large.
            Content::Mesh(Format::ThreeMf, bytes) => 8 * bytes.len(),
            Content::Mesh(_, bytes) | Content::Gcode(bytes) => bytes.len(),
            Content::Parts(parts) => parts.iter().map(|(_, bytes)| bytes.len()).sum(),
        };
        (8192.0 / bytes as f64).clamp(0.005, 1.0)
    }

    /// Runs all steps on a changed file; returns whether the last one was reached.
    fn run(&self, number: u64) -> bool {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(number);
        match &self.content {
            Content::Mesh(format, bytes) => mesh_steps(*format, &changed(bytes, &mut rng), number),
            Content::Parts(parts) => {
                let mut parts = parts.clone();
                let part = rng.random_range(0..parts.len());
                parts[part].1 = changed(&parts[part].1, &mut rng);
                let method = if rng.random() {
                    CompressionMethod::Stored
                } else {
                    CompressionMethod::Deflated
                };
                mesh_steps(Format::ThreeMf, &pack(&parts, method), number)
            }
            Content::Gcode(bytes) => gcode_steps(&changed(bytes, &mut rng)),
        }
    }
}

fn mesh_steps(format: Format, bytes: &[u8], number: u64) -> bool {
    let Ok(mut model) = Model::read(format, bytes, &ReadLimits::default(), &Control::default())
    else {
        return false;
    };
    let is_finite = |model: &Model| {
        model.bodies.iter().all(|body| body.mesh.vertices().iter().flatten().all(|v| v.is_finite()))
    };
    assert!(model.triangle_count() > 0 && is_finite(&model));
    for body in &mut model.bodies {
        // A body that cannot be repaired stays as it is: later steps must handle that too.
        _ = body.repair(&RepairSettings::default(), &Control::default());
        assert!(body.paint.is_empty() || body.paint.len() == body.mesh.triangles().len());
    }
    let rules = [MaterialRule::Stated, MaterialRule::PerBody, MaterialRule::Single];
    model.assign_materials(rules[(number % 3) as usize]);
    let settings =
        slice::Settings { cell_mm: 1.0, layer_mm: 1.0, max_cells: 1 << 18, ..Default::default() };
    _ = slice::slice(&model, &settings, &Control::default());
    if Placement::default().apply(&mut model).is_err() {
        return false;
    }
    assert!(is_finite(&model));
    let Ok(layers) = slice::slice(&model, &settings, &Control::default()) else { return false };
    assert_eq!(layers.voxels().count() as u64, layers.cell_count());
    true
}

fn gcode_steps(bytes: &[u8]) -> bool {
    let Ok(program) = Program::from_bytes(bytes, &Control::default()) else { return false };
    assert_eq!(program.emit().parse().as_ref(), Ok(&program));
    for event in program.trace() {
        match event {
            Ok(Event::Motion(motion)) => {
                assert!(motion.length_mm().is_finite() && motion.extruded_mm.is_finite());
                assert!(motion.feed_mm_s > 0.0);
            }
            Ok(Event::Pause { seconds, .. }) => assert!(seconds >= 0.0),
            _ => {}
        }
    }
    let plan = Plan::new();
    let settings = Plan::settings(Flavour::Marlin);
    _ = print::check(&program, &plan.layers(), &plan.frame, &settings, &Control::default());
    let Ok(seconds) = program.print_seconds(settings.printer.limits(), &Control::default()) else {
        return false;
    };
    assert!(seconds >= 0.0 && seconds.is_finite(), "{seconds} s");
    true
}

/// Text that may break readers: limits of number ranges, and characters with a special meaning.
const TEXTS: [&[u8]; 64] = [
    b"0",
    b"9",
    b"-",
    b"-0",
    b"e",
    b".",
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"1e39",
    b"1e400",
    b"255",
    b"256",
    b"65536",
    b"4294967295",
    b"4294967296",
    b"9223372036854775807",
    b"-9223372036854775808",
    b"9223372036854.775807",
    b"1000000000",
    b"0.0000005",
    b" ",
    b"\n",
    b"\r",
    b"\r\n",
    b"\t",
    b"\0",
    b"\xff",
    b"\xc3\xa9",
    b"\xef\xbb\xbf",
    b"\xc2\xa0",
    b"\\",
    b"\\\n",
    b"/",
    b"//",
    b"#",
    b";",
    b"(",
    b")",
    b"*",
    b"N1 ",
    b"<",
    b">",
    b"/>",
    b"</",
    b"\"",
    b"'",
    b"&",
    b"&amp;",
    b"&#x110000;",
    b"<!--",
    b"<![CDATA[",
    b"<?",
    b"=",
    b"endsolid\n",
    b"solid\n",
    b"G91\n",
    b"G92\n",
    b"M82\n",
    b"G2 I1\n",
    b"T1\n",
];

/// Critical values of little-endian numbers of four bytes: counts, indices, and floats.
const WORDS: [u32; 10] = [
    0,
    1,
    0xff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7f80_0000,
    0x7fc0_0000,
    0x7f7f_ffff,
];

/// A copy with one to eight changes.
fn changed(bytes: &[u8], rng: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    // Mostly few changes, so that many files are read completely and reach later steps.
    let most = [1, 1, 2, 8][rng.random_range(0..4_usize)];
    for _ in 0..rng.random_range(1..=most) {
        change(&mut bytes, rng);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, rng: &mut Xoshiro256PlusPlus) {
    if bytes.is_empty() {
        bytes.push(rng.random());
        return;
    }
    let at = rng.random_range(0..bytes.len());
    // Mostly short: after a long change, little of the file is left to read.
    let longest = [4, 16, 64, 4096][rng.random_range(0..4_usize)];
    let end = bytes.len().min(at + rng.random_range(1..=longest));
    let text = TEXTS[rng.random_range(0..TEXTS.len())];
    match rng.random_range(0..48) {
        0..4 => bytes[at] = rng.random(),
        4..8 => bytes[at] ^= 1 << rng.random_range(0..8),
        8..12 => drop(bytes.splice(at..at, text.iter().copied())),
        12..15 => drop(bytes.splice(at..(at + text.len()).min(bytes.len()), text.iter().copied())),
        15..18 => drop(bytes.drain(at..end)),
        18..21 => {
            let again = bytes[at..end].to_vec();
            let to = rng.random_range(0..=bytes.len());
            bytes.splice(to..to, again);
        }
        21..23 => {
            let other = rng.random_range(0..bytes.len());
            for step in 0..(end - at).min(bytes.len() - other) {
                bytes.swap(at + step, other + step);
            }
        }
        23..25 => {
            let word = WORDS[rng.random_range(0..WORDS.len())].to_le_bytes();
            bytes.iter_mut().skip(at).zip(word).for_each(|(byte, new)| *byte = new);
        }
        25..31 => {
            // Replaces the next number.
            let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.');
            let from = bytes[at..].iter().position(is_part).map_or(at, |skip| at + skip);
            let length = bytes[from..].iter().take_while(|byte| is_part(byte)).count();
            let number = TEXTS[rng.random_range(0..24_usize)];
            bytes.splice(from..from + length, number.iter().copied());
        }
        31..47 => {
            // Another digit: the syntax stays valid, the meaning changes.
            let digit =
                bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |skip| at + skip);
            bytes[digit] = b'0' + rng.random_range(0..10_u8);
        }
        _ => bytes.truncate(at),
    }
}

/// The plan that programs are checked against; its own program is a seed.
struct Plan {
    frame: Frame,
    region: Region,
    zones: Zones,
    path: Path,
}

impl Plan {
    fn new() -> Self {
        let region = Region::rectangle(8, 5).unwrap();
        let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0).unwrap();
        let path = cover(&region, &Control::default()).unwrap();
        let frame = Frame {
            left_mm: 100.0,
            back_mm: 100.0,
            cell_mm: 0.5,
            layer_mm: 0.2,
            width: 8,
            height: 5,
        };
        Self { frame, region, zones, path }
    }

    fn layers(&self) -> [print::Layer<'_>; 2] {
        let Self { region, zones, path, .. } = self;
        [0, 1].map(|number| print::Layer { number, region, zones, path })
    }

    fn settings(flavour: Flavour) -> print::Settings {
        let tower = PrimeTower { left_mm: 120.0, front_mm: 50.0, width_mm: 10.0, depth_mm: 30.0 };
        let purge = Some(Purge::uniform(2, 2.0, Some(tower)));
        let printer = Printer { flavour, ..Printer::default() };
        print::Settings {
            tools: vec![Tool::default(); 2],
            purge,
            printer,
            ..print::Settings::default()
        }
    }

    fn print(&self, flavour: Flavour) -> String {
        let title = Title { part: "plate", version: "0" };
        Print::new(
            title,
            &self.layers(),
            &self.frame,
            &Self::settings(flavour),
            &Control::default(),
        )
        .unwrap()
        .program
        .emit()
    }
}

fn cube() -> Mesh {
    Solid::Cuboid { size_mm: [6.0, 5.0, 4.0] }.mesh()
}

fn sphere() -> Mesh {
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

fn stl_seeds() -> Vec<Seed> {
    let stl = |name, bytes| Seed::mesh(name, Format::Stl, bytes);
    vec![
        stl("cube.stl", stl_binary(&cube())),
        stl("sphere.stl", stl_binary(&sphere())),
        stl("cube-text.stl", stl_text("a cube", &cube()).into_bytes()),
        stl("two-text.stl", (stl_text("a cube", &cube()) + &stl_text("", &sphere())).into_bytes()),
        stl("many-text.stl", stl_text("c", &cube()).repeat(6).into_bytes()),
    ]
}

fn obj_seeds() -> Vec<Seed> {
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

fn pack(parts: &[(String, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        writer
            .start_file(name.as_str(), SimpleFileOptions::default().compression_method(method))
            .unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn unpack(bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut parts = Vec::new();
    for number in 0..archive.len() {
        let mut part = archive.by_index(number).ok()?;
        let name = part.name().ok()?.into_owned();
        let mut bytes = Vec::new();
        part.read_to_end(&mut bytes).ok()?;
        if [".model", ".rels"].iter().any(|ending| name.ends_with(ending)) {
            parts.push((name, bytes));
        }
    }
    (!parts.is_empty()).then_some(parts)
}

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

fn threemf_seeds() -> Vec<Seed> {
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

fn gcode_seeds() -> Vec<Seed> {
    const PRUSA: &str = "\
        ; generated by PrusaSlicer\nM73 P0 R12\nM201 X1000 Y1000 Z200 E5000\nM204 P1250 T1250\n\
        M205 X8.00 Y8.00 Z0.40 E4.50\nM104 S215\nM190 S60 ; wait\nM109 S215\nG28 W\nG80\nG21\n\
        G90\nM83\nM900 K0.05\nG92 E0.0\n;LAYER_CHANGE\n;Z:0.2\n;HEIGHT:0.2\nG1 E-.8 F2100\n\
        G1 Z.2 F10800\n;TYPE:External perimeter\n;WIDTH:0.45\nG1 X97.7 Y97.7\nG1 E.8 F2100\n\
        G1 X110.25 Y97.7 E.41 F1200\nG3 X112.3 Y99.75 I0 J2.05 E.1\n\
        G2 X110.25 Y101.8 R2.05 E.1\nG1 X97.7 E.41\nG4 P250\nT1\n;TYPE:Wipe tower\n\
        G1 X150 Y150 F7200\nG1 X160 E.3 F1800\nM106 S127.5\nM117 Layer 1 (of 2)\nG10\nG11\n\
        M107\nM84 X Y E\n";
    const CURA: &str = "\
        ;FLAVOR:Marlin\n;TIME:6666\n;LAYER_COUNT:2\nT0\nM82 ;absolute\nG92 E0\nG1 F1500 E-6.5\n\
        ;LAYER:-1\n;LAYER:0\nM205 X20 Y20\nG0 F3600 X98.1 Y98.1 Z0.3\n;TYPE:WALL-INNER\n\
        G1 F1500 E0\nG1 F1800 X101.9 Y98.1 E0.1\nG1 X101.9 Y101.9 E0.2\nG91\nG1 Z1 X-.5\nG90\n\
        G92 X10 Y10\n;TYPE:SKIN\nG1 X11 Y10.5 E0.21\nG92\nM140 S0\n";
    const KLIPPER: &str = "\
        N1 START_PRINT BED_TEMP=60 EXTRUDER_TEMP=210*33\n\
        N2 set_velocity_limit ACCEL=3000 SQUARE_CORNER_VELOCITY=5\n\
        (by hand) g1x10y10f6000 (on)\nSET_PRESSURE_ADVANCE ADVANCE=0.04\ng28 x y\nG2 I10\n\
        G3 X5 Y5 I-2.5 J2 Z3 E1\nSET_VELOCITY_LIMIT VELOCITY=200\nM104 T1 S200\nEND_PRINT\n";
    let plan = Plan::new();
    vec![
        Seed::gcode("marlin.gcode", plan.print(Flavour::Marlin)),
        Seed::gcode("klipper.gcode", plan.print(Flavour::Klipper)),
        Seed::gcode("prusa.gcode", PRUSA),
        Seed::gcode("cura.gcode", CURA),
        Seed::gcode("by-hand.gcode", KLIPPER),
    ]
}

/// The files of `../shared/parts` in a format, if the folder is there.
fn shared_seeds(format: Format) -> Vec<Seed> {
    let root = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/parts");
    let mut seeds = Vec::new();
    for folder in [root.clone(), root.join("broken")] {
        let Ok(entries) = folder.read_dir() else {
            eprintln!("skipped: folder {} does not exist", folder.display());
            continue;
        };
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        // Sorted, so that cases do not depend on the order in which the folder lists them.
        names.sort_unstable();
        for name in names.into_iter().filter(|name| Format::from_file_name(name) == Some(format)) {
            let bytes = std::fs::read(folder.join(&name)).unwrap();
            match unpack(&bytes).filter(|_| format == Format::ThreeMf) {
                Some(parts) => seeds.extend(Seed::package(&name, parts)),
                None => seeds.push(Seed::mesh(&name, format, bytes)),
            }
        }
    }
    seeds
}

/// Ends the process if a case takes too long.
struct Watchdog(Arc<Mutex<Option<(String, Instant)>>>);

impl Watchdog {
    fn new() -> Self {
        let current: Arc<Mutex<Option<(String, Instant)>>> = Arc::default();
        let watched = Arc::downgrade(&current);
        std::thread::spawn(move || {
            while let Some(current) = watched.upgrade() {
                if let Some((case, begun)) = &*current.lock().unwrap()
                    && begun.elapsed() > HANG
                {
                    eprintln!("the case '{case}' hangs");
                    std::process::abort();
                }
                drop(current);
                std::thread::sleep(Duration::from_millis(200));
            }
        });
        Self(current)
    }

    fn set(&self, case: Option<String>) {
        *self.0.lock().unwrap() = case.map(|case| (case, Instant::now()));
    }
}

fn run(title: &str, seeds: &[Seed]) {
    let watchdog = Watchdog::new();
    let case = |seed: &Seed, number: u64| {
        let name = format!("{} {number}", seed.name);
        watchdog.set(Some(name.clone()));
        let begun = Instant::now();
        let Ok(whole) = catch_unwind(AssertUnwindSafe(|| seed.run(number))) else {
            panic!("the case '{name}' fails");
        };
        watchdog.set(None);
        (begun.elapsed(), name, whole)
    };
    if let Ok(wanted) = std::env::var("BEADWORK_MUTATION_CASE") {
        let (name, number) = wanted.rsplit_once(' ').unwrap();
        if let Some(seed) = seeds.iter().find(|seed| seed.name == name) {
            let (time, ..) = case(seed, number.parse().unwrap());
            eprintln!("{title}: the case '{wanted}' passes, {time:.1?}");
        }
        return;
    }
    let all = std::env::var("BEADWORK_MUTATIONS").map_or(CASES, |count| count.parse().unwrap());
    let weights: f64 = seeds.iter().map(Seed::weight).sum();
    let begun = Instant::now();
    let (mut count, mut whole) = (0, 0);
    let mut slowest = (Duration::ZERO, String::new());
    for seed in seeds {
        let share = (all as f64 / TESTS as f64 * seed.weight() / weights).ceil() as u64;
        for number in 0..share {
            let (time, name, is_whole) = case(seed, number);
            slowest = slowest.max((time, name));
            whole += u64::from(is_whole);
        }
        count += share;
    }
    let peak = peak_kib();
    let (longest, name) = slowest;
    eprintln!(
        "{title}: {count} cases in {:.1?}, {whole} of them through all steps; \
         '{name}' took {longest:.1?}; peak {} MiB",
        begun.elapsed(),
        peak.unwrap_or(0) >> 10
    );
    assert!(peak.is_none_or(|kib| kib < MAX_KIB), "{peak:?} KiB");
}

/// Peak memory of the process in KiB, on systems that report it.
fn peak_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_ascii_whitespace().next()?.parse().ok()
}

#[test]
fn damaged_stl() {
    let mut seeds = stl_seeds();
    seeds.extend(shared_seeds(Format::Stl));
    run("STL", &seeds);
}

#[test]
fn damaged_obj() {
    run("OBJ", &obj_seeds());
}

#[test]
fn damaged_3mf() {
    let mut seeds = threemf_seeds();
    seeds.extend(shared_seeds(Format::ThreeMf));
    run("3MF", &seeds);
}

#[test]
fn damaged_gcode() {
    run("G-code", &gcode_seeds());
}

/// All seeds pass all steps: changes of an invalid file would test only its first error.
#[test]
fn seeds_are_valid() {
    for seed in stl_seeds().iter().chain(&obj_seeds()).chain(&threemf_seeds()).chain(&gcode_seeds())
    {
        let read = |format, bytes: &[u8]| {
            let model =
                Model::read(format, bytes, &ReadLimits::default(), &Control::default()).unwrap();
            model.bodies.into_iter().for_each(|mut body| {
                _ = body.repair(&RepairSettings::default(), &Control::default()).unwrap();
            });
        };
        match &seed.content {
            Content::Mesh(format, bytes) => read(*format, bytes),
            Content::Parts(parts) => {
                read(Format::ThreeMf, &pack(parts, CompressionMethod::Deflated));
            }
            Content::Gcode(bytes) => {
                let program = Program::from_bytes(bytes, &Control::default()).unwrap();
                program.trace().for_each(|event| _ = event.unwrap());
            }
        }
    }
}
