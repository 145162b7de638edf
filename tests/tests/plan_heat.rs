//! `plan --objective heat` and `eval heat` as a user runs them.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use beadwork_tests::{fail, misused, run, text};
use serde_json::Value;

/// A box of 12 x 7 x 1 mm, as ASCII STL.
fn small_box(folder: &Path) -> PathBuf {
    let corner = |i: usize| [12 * (i & 1), 7 * (i >> 1 & 1), i >> 2 & 1];
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut stl = "solid box\n".to_owned();
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            stl += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                writeln!(stl, "vertex {x} {y} {z}").unwrap();
            }
            stl += "endloop\nendfacet\n";
        }
    }
    let path = folder.join("box.stl");
    fs::write(&path, stl + "endsolid box\n").unwrap();
    path
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is not a number in {value}"))
}

#[test]
fn an_even_plan_is_checked_gcode_within_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let part = small_box(folder.path());
    let (gcode, svg) = (folder.path().join("box.gcode"), folder.path().join("box.svg"));
    let plan = ["plan", text(&part), "--objective", "heat", "--max-time", "1.1"];
    let files = ["--out", text(&gcode), "--svg", text(&svg)];
    let summary = run(&[&plan[..], &files].concat());
    assert!(summary.contains("more even than the conventional order: "), "{summary}");
    assert!(summary.contains("checked from its text: 1344 cells, each printed once"), "{summary}");
    assert!(fs::read_to_string(&svg).unwrap().contains("layer 4"));
    let totals: Value =
        serde_json::from_slice(&fs::read(folder.path().join("box.gcode.json")).unwrap()).unwrap();
    let heat = &totals["heat"];
    assert_eq!(heat["planner"], "lines");
    assert!(number(heat, "reward") > number(heat, "conventional_reward"));
    let gain = 100.0 * (1.0 - number(heat, "reward") / number(heat, "conventional_reward"));
    assert!((number(heat, "gain_percent") - gain).abs() < 1e-9);
    let ratio = number(heat, "print_seconds") / number(heat, "conventional_print_seconds");
    assert!(ratio <= 1.1 + 1e-9, "{ratio}");
    for key in [
        "no_travel_gain_percent",
        "time_averaged_gain_percent",
        "warpage_mm",
        "conventional_warpage_mm",
        "planning_seconds",
    ] {
        assert!(number(heat, key).is_finite());
    }
    let [lines, any] = ["whole_lines_bound_percent", "bound_percent"].map(|key| number(heat, key));
    let gain = number(heat, "no_travel_gain_percent");
    assert!(gain < lines && lines < any && any < 100.0, "{gain} {lines} {any}");

    // The program is the same on one thread.
    let again = folder.path().join("again.gcode");
    run(&[&plan[..], &["--out", text(&again), "--threads", "1"]].concat());
    assert_eq!(fs::read(&gcode).unwrap(), fs::read(&again).unwrap());
}

#[test]
fn planners_and_weights_are_options() {
    let folder = tempfile::tempdir().unwrap();
    let part = small_box(folder.path());
    let plan = ["plan", text(&part), "--objective", "heat", "--json"];
    let heat = |more: &[&str]| -> Value {
        let json: Value = serde_json::from_str(&run(&[&plan[..], more].concat())).unwrap();
        json["heat"].clone()
    };
    let conventional = heat(&["--planner", "conventional"]);
    assert!(number(&conventional, "gain_percent").abs() < 1e-9);
    assert_eq!(conventional["orders"][3], "contour-zigzag-x-0");
    let constant = heat(&["--planner", "constant", "--max-time", "1"]);
    assert_eq!(constant["orders"][0], constant["orders"][3]);
    let greedy = heat(&["--planner", "greedy", "--even", "peak", "--thermal-material", "pla"]);
    assert_eq!(greedy["objective"], "peak=1");
}

#[test]
fn what_cannot_be_planned_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let part = small_box(folder.path());
    let heat = ["plan", text(&part), "--objective", "heat"];
    let with = |more: &[&'static str]| [&heat[..], more].concat();
    let message = fail(&["plan", "example:logo-plate", "--objective", "heat"]);
    assert!(message.contains("part has several materials"), "{message}");
    let message = fail(&with(&["--max-time", "0.2"]));
    assert!(message.contains("--max-time cannot be met"), "{message}");
    let message = fail(&with(&["--even", "warpage"]));
    assert!(message.contains("objective warpage is known only for a whole print"), "{message}");
    let message = fail(&with(&["--even", "peak"]));
    assert!(message.contains("use greedy"), "{message}");
    let message = misused(&["plan", "x.stl", "--max-time", "1.1"]);
    assert!(message.contains("--max-time requires --objective heat"), "{message}");
    let message = misused(&with(&["--max-time", "-1"]));
    assert!(message.contains("--max-time"), "{message}");
    let message = misused(&with(&["--fill", "beads", "--planner", "ppo"]));
    assert!(message.contains("--planner ppo plans cells: use --fill cells"), "{message}");
    let message = misused(&with(&["--fill", "beads", "--join"]));
    assert!(message.contains("--join does not go together with --objective heat"), "{message}");
    let message = fail(&with(&["--fill", "beads", "--max-time", "0.2"]));
    assert!(message.contains("--max-time cannot be met"), "{message}");
    let message = fail(&["plan", "example:logo-plate", "--objective", "heat", "--fill", "beads"]);
    assert!(message.contains("part has several materials"), "{message}");
    let message = misused(&with(&["--policy", "runs/general"]));
    assert!(message.contains("--policy requires --planner ppo"), "{message}");
    let message = misused(&with(&["--planner", "ppo", "--even", "peak"]));
    assert!(message.contains("--even does not go together with --planner ppo"), "{message}");
    // A build with networks misses the policy, one without misses networks.
    let message = fail(&with(&["--planner", "ppo"]));
    let helps = ["no policy in 'models/ppo-small'", "cargo xtask plan ... --planner ppo"];
    assert!(helps.iter().any(|help| message.contains(help)), "{message}");
    let message = misused(&with(&["--planner", "best"]));
    assert!(message.contains("best"), "{message}");
}

#[test]
fn beads_are_planned_and_measured_from_their_text() {
    let folder = tempfile::tempdir().unwrap();
    let part = small_box(folder.path());
    let (gcode, svg) = (folder.path().join("box.gcode"), folder.path().join("box.svg"));
    let plan = ["plan", text(&part), "--objective", "heat", "--fill", "beads"];
    let more = ["--density", "100", "--perimeters", "1", "--max-time", "1.2"];
    let files = ["--out", text(&gcode), "--svg", text(&svg)];
    let summary = run(&[&plan[..], &more, &files].concat());
    assert!(summary.contains("more even than the conventional order: "), "{summary}");
    assert!(summary.contains("each printed once, within the outlines"), "{summary}");
    let totals: Value =
        serde_json::from_slice(&fs::read(folder.path().join("box.gcode.json")).unwrap()).unwrap();
    let heat = &totals["heat"];
    assert!(number(heat, "gain_percent") > 3.0 && number(heat, "no_travel_gain_percent") > 3.0);
    let ratio = number(heat, "print_seconds") / number(heat, "conventional_print_seconds");
    assert!(1.0 < ratio && ratio <= 1.2, "{ratio}");
    assert!(heat["bound_percent"].is_null());
    assert_eq!(heat["orders"].as_array().unwrap().len(), 4);

    // The listed order is the program of the planner of beads.
    let listed = folder.path().join("listed.gcode");
    let conventional = ["--planner", "conventional", "--out", text(&listed)];
    run(&[&plan[..], &more, &conventional].concat());
    let beads = folder.path().join("beads.gcode");
    run(&["plan", text(&part), "--density", "100", "--perimeters", "1", "--out", text(&beads)]);
    assert_eq!(fs::read(&listed).unwrap(), fs::read(&beads).unwrap());

    // The same moves, in another order.
    let filament = |path: &Path| {
        let totals = fs::read(path.with_extension("gcode.json")).unwrap();
        let totals: Value = serde_json::from_slice(&totals).unwrap();
        (number(&totals, "extrusion_mm"), number(&totals, "beads"))
    };
    let (length, count) = filament(&gcode);
    let (listed_length, listed_count) = filament(&listed);
    assert!((length / listed_length - 1.0).abs() < 1e-6 && count > listed_count);

    // The program is the same on one thread.
    let again = folder.path().join("again.gcode");
    run(&[&plan[..], &more, &["--out", text(&again), "--threads", "1"]].concat());
    assert_eq!(fs::read(&gcode).unwrap(), fs::read(&again).unwrap());
}

#[test]
fn planners_are_compared_on_files() {
    let folder = tempfile::tempdir().unwrap();
    let part = small_box(folder.path());
    let pictures = folder.path().join("pictures");
    let eval = ["eval", "heat", text(&part), "--bead", "0.6", "--planner", "conventional"];
    let more = ["--planner", "greedy", "--max-time", "1.1", "--json"];
    let output = run(&[&eval[..], &more, &["--pictures", text(&pictures)]].concat());
    let json: Value = serde_json::from_str(&output).unwrap();
    let part = &json["parts"][0];
    assert_eq!((&part["part"], &part["layers"]), (&Value::from("box"), &Value::from(4)));
    assert_eq!((&part["voxels"], &part["max_components"]), (&Value::from(960), &Value::from(1)));
    let plans = part["plans"].as_array().unwrap();
    assert_eq!(plans.len(), 2);
    // The plan of the conventional order is measured as the baseline is.
    let deviations = |row: &Value| number(&row["plane_deviations"][1]["along_x"], "central_k");
    assert!((deviations(&plans[0]) - deviations(part)).abs() < 1e-9 && deviations(part) > 0.0);
    assert!(number(&plans[1], "reward") >= number(part, "reward"));
    let svg = fs::read_to_string(pictures.join("box.svg")).unwrap();
    assert!(svg.contains("End of layer 4") && svg.contains("greedy: "), "{svg}");
    // The middle and the last layer, of two plans.
    assert_eq!(svg.matches("<image").count(), 4);
    // Two files of one name would have one picture.
    let twin = folder.path().join("twin");
    fs::create_dir(&twin).unwrap();
    let twin = small_box(&twin);
    let message = fail(&[&eval[..], &[text(&twin), "--pictures", text(&pictures)]].concat());
    assert!(message.contains("two parts are named 'box'"), "{message}");
}
