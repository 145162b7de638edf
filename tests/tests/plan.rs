//! `plan` as a user runs it: from meshes to checked G-code.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::print_stderr, reason = "whoever runs the tests must learn what was skipped")]

use std::fs;
use std::path::{Path, PathBuf};

use beadwork_base::Control;
use beadwork_gcode::{Event, Feature, Program};
use beadwork_tests::{beadwork, fail, misused, run, text};
use serde_json::Value;

/// The folder of real parts; `None`, with a message, if it is absent.
fn parts() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/parts");
    let found = folder.canonicalize().ok().filter(|folder| folder.join("yin_yang.3mf").exists());
    if found.is_none() {
        eprintln!("skipped: no real parts in {}", folder.display());
    }
    found
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&run(arguments)).unwrap()
}

#[test]
fn a_part_becomes_gcode_with_totals_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let (gcode, svg) = (folder.path().join("logo.gcode"), folder.path().join("logo.svg"));
    let arguments = [
        "plan",
        "example:logo-plate",
        "--objective",
        "tools",
        "--out",
        text(&gcode),
        "--svg",
        text(&svg),
    ];
    let summary = run(&arguments);
    assert!(summary.contains("4 tool changes (proven minimum)"), "{summary}");
    assert!(summary.contains("checked from its text: 76800 cells"), "{summary}");
    assert!(fs::read_to_string(&svg).unwrap().contains("layer 5"));

    let totals: Value =
        serde_json::from_slice(&fs::read(folder.path().join("logo.gcode.json")).unwrap()).unwrap();
    assert_eq!(totals["tool_changes"], 4);
    assert_eq!(totals["bounds"]["tool_changes"], 4);
    assert_eq!(totals["layers"], 8);
    assert_eq!(totals["materials"], serde_json::json!(["white", "blue"]));

    // The totals in the file equal those of its motions.
    let program = Program::from_bytes(&fs::read(&gcode).unwrap(), &Control::default()).unwrap();
    let (mut changes, mut part_mm) = (0, 0.0);
    for event in program.trace() {
        match event.unwrap() {
            Event::ToolChange { from: Some(_), .. } => changes += 1,
            Event::Motion(motion)
                if motion.is_extrusion() && motion.feature == Feature::SolidInfill =>
            {
                part_mm += motion.length_mm();
            }
            _ => {}
        }
    }
    assert_eq!(changes, 4);
    // 76,800 cells of half a millimetre.
    assert!((part_mm - 38_400.0).abs() < 1.0, "{part_mm}");
    assert!((totals["extrusion_mm"].as_f64().unwrap() - part_mm).abs() < 1.0);

    // Only the G-code is written to a pipe.
    #[cfg(unix)]
    assert!(
        run(&["plan", "example:u-shape", "--objective", "tools", "--out", "/dev/stdout"])
            .starts_with("; generated")
    );

    // One thread writes the same bytes.
    let again = folder.path().join("again.gcode");
    run(&[
        "plan",
        "example:logo-plate",
        "--objective",
        "tools",
        "--out",
        text(&again),
        "--threads",
        "1",
    ]);
    assert_eq!(fs::read(&gcode).unwrap(), fs::read(&again).unwrap());
}

#[test]
fn modes_constraints_and_flavours_are_obeyed() {
    let plan = |more: &[&str]| {
        let arguments =
            [&["plan", "example:palette", "--objective", "tools", "--json"], more].concat();
        json(&arguments)
    };
    let free = plan(&["--mode", "free"]);
    assert_eq!((&free["tool_changes"], &free["lifts"]), (&88.into(), &88.into()));
    let continuous = plan(&["--mode", "continuous"]);
    assert_eq!((&continuous["lifts"], &continuous["continuous_layers"]), (&0.into(), &8.into()));
    assert_eq!(free["fixed_order"]["tool_changes"], 95);
    let same = plan(&["--same-order", "--first-tool", "2", "--before", "4:3"]);
    assert_eq!(same["tool_changes"], 95);

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("u.gcode");
    let klipper =
        ["--flavour", "klipper", "--tower", "none", "--stacking", "keep", "--out", text(&file)];
    run(&[&["plan", "example:u-shape", "--objective", "tools"], &klipper[..]].concat());
    let gcode = fs::read_to_string(&file).unwrap();
    assert!(gcode.contains("SET_VELOCITY_LIMIT") && !gcode.contains("M204"));
}

#[test]
fn profiles_are_read_and_their_faults_reported() {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/plan/example.toml");
    let plan = ["plan", "example:logo-plate", "--objective", "tools", "--json", "--profile"];
    let value = json(&[&plan[..], &[text(&example)]].concat());
    assert_eq!(value["materials"], serde_json::json!(["white ABS", "black ABS"]));
    assert_eq!(value["tool_cost"], 2 * 90 + 2 * 180);
    let tower = folder.path().join("tower.toml");
    let place = "[purge]\nvolume_mm3 = [[0, 90], [180, 0]]\n\
        tower = { left_mm = 10, front_mm = 20, width_mm = 40, depth_mm = 80 }\n";
    fs::write(&tower, place).unwrap();
    for purge in [&[][..], &["--purge", "70"]] {
        let value = json(&[&plan[..], &[text(&tower)], purge].concat());
        assert_eq!(value["tower"]["front_mm"], 20.0, "{purge:?}");
    }
    let wrong = folder.path().join("wrong.toml");
    fs::write(&wrong, "[printer]\nspeed = 3\n").unwrap();
    let error = fail_lines(&[&plan[..], &[text(&wrong)]].concat());
    assert!(error.contains("wrong.toml") && error.contains("speed"), "{error}");
    fs::write(&wrong, "[process]\nprint_mm_s = -3\n").unwrap();
    let error = fail(&[&plan[..], &[text(&wrong)]].concat());
    assert!(error.contains("process.print_mm_s is -3"), "{error}");
    fs::write(&wrong, "[purge]\nvolume_mm3 = [[0]]\n").unwrap();
    let error = fail(&[&plan[..], &[text(&wrong)]].concat());
    assert!(error.contains("purge matrix covers 1 tools, the part has 2 materials"), "{error}");
}

/// The message of a failure, which may have several lines, as for a TOML file.
fn fail_lines(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn bad_input_is_reported_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.gcode");
    let refused = |name: &str, bytes: &[u8], more: &[&str]| {
        let input = tempfile::tempdir().unwrap();
        let file = input.path().join(name);
        fs::write(&file, bytes).unwrap();
        let arguments =
            [&["plan", text(&file), "--objective", "tools", "--out", text(&out)], more].concat();
        let error = fail(&arguments);
        assert!(
            fs::read_dir(folder.path()).unwrap().next().is_none(),
            "{name}: something was written"
        );
        error
    };
    let error = refused("empty.stl", b"", &[]);
    assert!(error.contains("empty.stl") && error.ends_with("file is empty"), "{error}");
    let error = refused("empty.3mf", b"", &[]);
    assert!(error.ends_with("file is empty"), "{error}");
    let error = refused("noise.3mf", &[7; 3000], &[]);
    assert!(error.ends_with("not a valid 3MF file: not a ZIP archive"), "{error}");
    let nan = "solid x\nfacet normal 0 0 1\nouter loop\n\
        vertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    let error = refused("nan.stl", nan.as_bytes(), &[]);
    assert!(error.ends_with("line 4: 'nan' is not a finite number"), "{error}");
    let error = refused("part.step", b"x", &[]);
    assert!(error.ends_with("unknown extension; expected .stl, .3mf or .obj"), "{error}");

    let plan = |more: &[&str]| {
        fail(
            &[&["plan", "example:palette", "--objective", "tools", "--out", text(&out)], more]
                .concat(),
        )
    };
    assert!(plan(&["--bead", "0"]).ends_with("the bead width is 0 mm: it must be more than 0"));
    assert!(
        plan(&["--bead", "-0.4"]).ends_with("the bead width is -0.4 mm: it must be more than 0")
    );
    assert!(
        plan(&["--layer", "nan"]).ends_with("the layer height is NaN mm: it must be more than 0")
    );
    assert!(plan(&["--scale", "10"]).contains("model of 600.0 x 450.0 x 20.0 mm does not fit"));
    assert!(plan(&["--bed", "70,60,50"]).contains("prime tower: no room beside the part"));
    assert!(plan(&["--tower", "100,80,30,30"]).ends_with("purge.tower overlaps the part"));
    assert!(
        plan(&["--first-tool", "12"])
            .ends_with("tool 12 does not exist: costs are given for 12 tools")
    );
    assert!(plan(&["--mode", "continuous", "--same-order"]).contains("no order can be imposed"));
    assert!(!out.exists());
    assert!(
        fail(&["plan", "example:cube", "--objective", "tools"]).contains("unknown example 'cube'")
    );
    assert!(
        fail(&["plan", "/no/such/file.stl", "--objective", "tools"])
            .contains("cannot read '/no/such/file.stl'")
    );
    assert!(
        fail(&["plan", "example:u-shape", "--objective", "tools", "--out", text(folder.path())])
            .ends_with("is a folder")
    );
    let twice = [
        "plan",
        "example:u-shape",
        "--objective",
        "tools",
        "--out",
        text(&out),
        "--svg",
        text(&out),
    ];
    assert!(misused(&twice).contains("the same file"));
    assert!(misused(&["plan", "example:palette", "--objective"]).contains("--objective"));
    assert!(misused(&["plan", "--objective", "tools"]).contains("PART"));
    assert!(
        misused(&["plan", "x.stl", "--objective", "tools", "--rotate", "90"])
            .contains("expected 3 numbers")
    );
    assert!(
        misused(&["plan", "x.stl", "--objective", "tools", "--before", "2"])
            .contains("numbered from 0")
    );
}

#[test]
fn several_files_are_several_materials_in_one_frame() {
    let folder = tempfile::tempdir().unwrap();
    let block = |name: &str, x: f64| {
        let file = folder.path().join(name);
        let corner = |at: usize| {
            [
                x + 4.0 * f64::from(at as u32 & 1),
                4.0 * f64::from(at as u32 >> 1 & 1),
                f64::from(at as u32 >> 2),
            ]
        };
        let line = |[x, y, z]: [f64; 3]| format!("v {x} {y} {z}\n");
        let corners = (0..8).map(corner).map(line).collect::<Vec<_>>().concat();
        let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\n";
        fs::write(&file, corners + faces).unwrap();
        file
    };
    let (left, right) = (block("left.obj", 0.0), block("right.obj", 4.0));
    let plan = ["plan", text(&left), text(&right), "--objective", "tools", "--json"];
    let value = json(&plan);
    assert_eq!(value["materials"], serde_json::json!(["left", "right"]));
    assert_eq!(
        (&value["width"], &value["height"], &value["layers"]),
        (&16.into(), &8.into(), &4.into())
    );
    assert_eq!(value["tool_changes"], 4);
    let inches =
        json(&[&plan[..], &["--unit", "in", "--scale", "0.5", "--materials", "one"]].concat());
    assert!((inches["size_mm"][0].as_f64().unwrap() - 101.6).abs() < 1e-9);
    assert_eq!(inches["tool_changes"], 0);
}

#[test]
fn real_parts_are_planned_and_broken_ones_refused() {
    let Some(parts) = parts() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.gcode");
    let plan = |name: &str, more: &[&str]| {
        let file = parts.join(name);
        json(
            &[&["plan", text(&file), "--objective", "tools", "--json", "--out", text(&out)], more]
                .concat(),
        )
    };
    let yin_yang = plan("yin_yang.3mf", &["--rotate", "90,0,0"]);
    assert_eq!((&yin_yang["layers"], &yin_yang["tool_changes"]), (&20.into(), &20.into()));
    let extruders = plan("8_extruders.3mf", &["--mode", "free"]);
    assert_eq!((&extruders["layers"], &extruders["tool_changes"]), (&40.into(), &280.into()));
    let bearing = plan("Bearing.3mf", &["--materials", "bodies", "--mode", "continuous"]);
    assert_eq!(
        (&bearing["layers"], &bearing["bounds"]["layers_optimal"]),
        (&60.into(), &60.into())
    );

    let refused = |name: &str| {
        let file = parts.join("broken").join(name);
        let error = fail(&[
            "plan",
            text(&file),
            "--objective",
            "tools",
            "--out",
            text(&folder.path().join("no.gcode")),
        ]);
        assert!(error.contains(name) && !folder.path().join("no.gcode").exists(), "{error}");
    };
    [
        "empty_file.3mf",
        "empty_file.stl",
        "random_bits.3mf",
        "random_bits.stl",
        "text_file.stl",
        "zero_size_cube.stl",
    ]
    .into_iter()
    .for_each(refused);
    for (name, repair) in [
        ("missing_triangle.stl", "1 hole closed"),
        ("inverted_face.stl", "1 triangle turned outwards"),
    ] {
        let file = parts.join("broken").join(name);
        let output =
            beadwork().args(["plan", text(&file), "--objective", "tools"]).output().unwrap();
        assert!(output.status.success(), "{name}");
        let output = String::from_utf8_lossy(&output.stderr);
        assert!(output.contains(repair), "{output}");
    }
}
