//! `plan` with beads, as a user runs it: insets, infill and skeletons as checked G-code.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;

use beadwork_tests::{fail, misused, run, text};
use serde_json::Value;

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&run(arguments)).unwrap()
}

#[test]
fn without_flags_a_part_is_printed_with_insets_and_infill() {
    let folder = tempfile::tempdir().unwrap();
    let (gcode, svg) = (folder.path().join("logo.gcode"), folder.path().join("logo.svg"));
    let summary = run(&["plan", "example:logo-plate", "--out", text(&gcode), "--svg", text(&svg)]);
    assert!(summary.contains("2 perimeters, 20 % lines"), "{summary}");
    assert!(summary.contains("4 tool changes (proven minimum)"), "{summary}");
    assert!(summary.contains("each printed once, within the outlines"), "{summary}");
    assert!(fs::read_to_string(&svg).unwrap().contains("<circle"));

    let program = fs::read_to_string(&gcode).unwrap();
    for feature in ["External perimeter", "Perimeter", "Internal infill", "Solid infill"] {
        assert!(program.contains(&format!(";TYPE:{feature}\n")), "{feature}");
    }
    let totals: Value =
        serde_json::from_slice(&fs::read(folder.path().join("logo.gcode.json")).unwrap()).unwrap();
    let number = |key: &str| totals[key].as_f64().unwrap();
    assert_eq!(totals["beads"], totals["bead_bound"], "proven");
    assert!(number("lifts") < number("beads"));
    assert!(number("extrusion_mm") > 1000.0 && number("travel_mm") > 0.0);
    assert_eq!(totals["layers"], 8);
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let programs = ["1", "3"].map(|threads| {
        let out = folder.path().join(threads);
        run(&["plan", "example:pyramid", "--join", "--threads", threads, "--out", text(&out)]);
        fs::read(&out).unwrap()
    });
    assert!(programs[0] == programs[1]);
}

#[test]
fn flags_change_what_is_printed() {
    let plan = |flags: &[&str]| {
        let arguments = [&["plan", "example:rectangular", "--json"], flags].concat();
        let value = json(&arguments);
        let number = |key: &str| value[key].as_f64().unwrap();
        (number("beads"), number("extrusion_mm"), value)
    };
    let (beads, sparse_mm, value) = plan(&[]);
    let travel = |key: &str| value[key].as_f64().unwrap();
    assert!(0.0 < travel("travel_bound_mm"));
    assert!(travel("travel_bound_mm") <= travel("bead_travel_mm"));
    assert!(travel("bead_travel_mm") <= travel("travel_mm"));
    let (_, solid_mm, _) = plan(&["--density", "100"]);
    let (_, hollow_mm, _) = plan(&["--density", "0", "--solid-layers", "0"]);
    assert!(hollow_mm < sparse_mm && sparse_mm < solid_mm);
    let (joined, ..) = plan(&["--join"]);
    assert!(joined < beads, "{joined} {beads}");
    let (one, ..) = plan(&["--perimeters", "1", "--solid-layers", "0"]);
    let (three, ..) = plan(&["--perimeters", "3", "--solid-layers", "0"]);
    assert!(one < three);
    for pattern in ["lines", "hexagons", "concentric"] {
        plan(&["--perimeters", "0", "--density", "100", "--pattern", pattern]);
    }
    for pattern in ["grid", "triangles", "hexagons", "hybrid", "concentric"] {
        let (_, length_mm, value) = plan(&["--pattern", pattern]);
        assert_eq!(value["pattern"], pattern);
        assert!(length_mm > hollow_mm, "{pattern}");
    }
    for seam in ["nearest", "rear", "random"] {
        plan(&["--seam", seam, "--order", "free"]);
    }
}

#[test]
fn an_objective_still_means_cells() {
    let cells = json(&["plan", "example:rectangular", "--objective", "tools", "--json"]);
    assert!(cells["cells"].is_number() && cells["bead_bound"].is_null());
    let same = json(&["plan", "example:rectangular", "--fill", "cells", "--json"]);
    assert_eq!(cells["cells"], same["cells"]);
    let beads =
        ["plan", "example:rectangular", "--objective", "tools", "--fill", "beads", "--json"];
    assert!(json(&beads)["bead_bound"].is_number());
}

#[test]
fn wrong_flags_are_refused() {
    for (flags, expected) in [
        (&["--density", "101"][..], "expected a number from 0 to 100"),
        (&["--density", "-1"], "--density"),
        (&["--density", "nan"], "expected a number from 0 to 100"),
        (&["--pattern", "gyroid"], "expected lines, grid"),
        (&["--seam", "hidden"], "expected aligned, nearest"),
        (&["--fill", "nonzero"], "beads"),
        (&["--perimeters", "many"], "--perimeters"),
    ] {
        let arguments = [&["plan", "example:rectangular", "--json"], flags].concat();
        let message = misused(&arguments);
        assert!(message.contains(expected), "{flags:?}: {message}");
    }
    let message = fail(&["plan", "example:rectangular", "--bead", "80", "--json"]);
    assert!(message.contains("thinner than a bead of 80 mm"), "{message}");
    let message = fail(&["plan", "example:rectangular", "--perimeters", "2000", "--json"]);
    assert!(message.contains("number of perimeters is 2000"), "{message}");
    misused(&["plan"]);
}
