//! Faults of programs of beads, and the errors that name them.

use beadwork_base::{CancelToken, Control, Interrupted};
use beadwork_gcode::Feature;

use super::bead_cases::Case;
use super::*;
use crate::print::{Process, Settings, SettingsError, Tool};
use crate::slice::FillRule;
use crate::{Area, Bead, BeadLayer, ExtrusionMove, Frame};

fn square(at: [f64; 2], side: f64) -> Area {
    let [x, y] = at;
    let ring = vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
    Area::from_rings(&[ring], FillRule::NonZero)
}

fn bead(tool: u8, feature: Feature, corners: &[[f64; 2]]) -> Bead {
    let step = |&to_mm| ExtrusionMove { to_mm, width_mm: 0.5, feature };
    Bead { tool, start_mm: corners[0], moves: corners[1..].iter().map(step).collect() }
}

/// Two layers of two squares, one for each tool: a wall and a line of infill.
fn small() -> Case {
    let part = |tool: u8| {
        let (left, right) = (50.25 + 20.0 * f64::from(tool), 59.75 + 20.0 * f64::from(tool));
        let corners = [[left, 50.25], [right, 50.25], [right, 59.75], [left, 59.75], [left, 50.25]];
        [
            bead(tool, Feature::OuterWall, &corners),
            bead(tool, Feature::Infill, &[[left + 2.0, 52.0], [left + 2.0, 58.0]]),
        ]
    };
    let layer = |number| BeadLayer { number, beads: [part(0), part(1)].concat() };
    let outlines = vec![(0, square([50.0, 50.0], 10.0)), (1, square([70.0, 50.0], 10.0))];
    let process = Process {
        outer_wall_mm_s: Some(15.0),
        infill_mm_s: Some(40.0),
        wipe_mm: 2.0,
        ..Process::default()
    };
    Case {
        layers: vec![layer(0), layer(1)],
        outlines: vec![outlines; 2],
        frame: Frame {
            left_mm: 0.0,
            back_mm: 0.0,
            cell_mm: 0.5,
            layer_mm: 0.2,
            width: 0,
            height: 0,
        },
        settings: Settings { tools: vec![Tool::default(); 2], process, ..Settings::default() },
        limits: BeadLimits::default(),
    }
}

/// The error after the text is changed.
fn error_of(change: impl FnOnce(&str) -> String) -> CheckError {
    let case = small();
    let text = case.print().program.emit();
    assert!(case.check_text(&text).is_ok());
    let changed = change(&text);
    assert_ne!(changed, text);
    case.check_text(&changed).unwrap_err()
}

/// The error after the first occurrence of a text is replaced, as text without its line number.
fn replaced(from: &str, to: &str) -> String {
    let text = error_of(|text| text.replacen(from, to, 1)).to_string();
    match text.strip_prefix("line ").map(|text| text.trim_start_matches(char::is_numeric)) {
        Some(text) => text.to_owned(),
        None => text,
    }
}

#[test]
fn faults_are_named() {
    let report = small().check(&small().print().program).unwrap();
    assert_eq!((report.layers, report.beads, report.motions), (2, 8, 20));
    assert_eq!((report.dropped_beads, report.tool_changes), (0, 3));
    assert!((report.part_mm3 - 4.0 * 44.0 * 0.1).abs() < 1e-4);
    for (from, to, expected) in [
        (
            "G1 Y59.75 E0.39497\n",
            "",
            ", layer 0: extrudes from (59.75, 50.25) to (50.25, 50.25) mm \
             where bead 0 runs from (59.75, 50.25) to (59.75, 59.75) mm",
        ),
        (
            "G1 X52.25 Y52 ",
            "G1 X52.25 Y52.001 ",
            ", layer 0: extrudes from (52.25, 52.001) to (52.25, 58) mm \
             where bead 1 runs from (52.25, 52) to (52.25, 58) mm",
        ),
        (
            ";TYPE:Internal infill",
            ";TYPE:Solid infill",
            ", layer 0: bead 1 is marked as Solid infill instead of Internal infill",
        ),
        (" F900\n", " F901\n", ": extrudes at 15.016666666666667 mm/s, the maximum is 15"),
        ("\nT1\n", "\n", ", layer 0: bead 2 is printed with tool 0 instead of 1"),
    ] {
        assert_eq!(replaced(from, to), expected);
    }
    let is_volume = matches!(
        error_of(|text| text.replacen("E0.39497", "E0.39499", 1)),
        CheckError::Volume { .. }
    );
    assert!(is_volume);
    let error = error_of(|text| text.replacen("E0.39497", "E0.39497\nG1 X58 E0.07", 1));
    assert!(matches!(error, CheckError::OffBead { bead: 0, layer: 0, .. }), "{error}");
}

#[test]
fn missing_and_additional_layers_are_named() {
    let cut = |text: &str, from: &str| text[..text.find(from).unwrap()].to_owned();
    let error = error_of(|text| cut(text, ";LAYER_CHANGE\n;Z:0.4"));
    let expected = "layer 1, bead 0 is incomplete: the move to (59.75, 50.25) mm is missing";
    assert_eq!(error.to_string(), expected);
    let mut one = small();
    let program = one.print().program;
    one.layers.pop();
    let error = one.check(&program).unwrap_err();
    assert_eq!(error, CheckError::OutlineLayers { expected: 1, got: 2 });
    one.outlines.pop();
    let error = one.check(&program).unwrap_err();
    assert!(matches!(error, CheckError::Height { .. }), "{error}");
    let mut fewer = small();
    fewer.layers[0].beads.pop();
    let error = fewer.check(&program).unwrap_err();
    assert!(matches!(error, CheckError::AfterBeads { layer: 0, .. }), "{error}");
    assert!(error.to_string().ends_with(" mm after the last bead"));
    let mut other = small();
    other.layers[1].beads.swap(2, 3);
    let error = other.check(&program).unwrap_err();
    assert!(matches!(error, CheckError::OffBead { layer: 1, bead: 2, .. }), "{error}");
}

#[test]
fn beads_beyond_their_outline_are_named() {
    let case = small();
    let program = case.print().program;
    // 5 % of the width and 2 µm are allowed.
    for (at, is_allowed) in [(50.026, true), (50.028, false)] {
        let mut case = case.clone();
        case.outlines[1][0].1 = square([at, 50.0], 10.0);
        let error = case.check(&program).err();
        assert_eq!(error.is_none(), is_allowed, "{error:?}");
        if let Some(error) = error {
            let text = error.to_string();
            let expected = "layer 1: bead 0 is 0.5 mm wide from (50.25, 50.25) to (59.75, 50.25) \
                            mm, beyond the outline of tool 0";
            assert!(text.ends_with(expected), "{text}");
        }
    }
    let is_outside = |case: &Case| {
        matches!(case.check(&program), Err(CheckError::OutsideOutline { bead: 0, tool: 0, .. }))
    };
    // No outline, the outline of the other tool, a hole around the bead, and one in the bead.
    let mut without = case.clone();
    without.outlines[0].remove(0);
    assert!(is_outside(&without));
    let mut other = case.clone();
    other.outlines[0].swap(0, 1);
    let [(a, _), (b, _)] = &mut other.outlines[0][..] else { panic!("two outlines") };
    std::mem::swap(a, b);
    assert!(is_outside(&other));
    let mut around = case.clone();
    around.outlines[0][0].1 = square([40.0, 40.0], 30.0).difference(&square([50.0, 50.0], 10.0));
    assert!(is_outside(&around));
    let mut speck = case.clone();
    speck.outlines[0][0].1 = square([50.0, 50.0], 10.0).difference(&square([55.0, 50.24], 0.02));
    assert!(is_outside(&speck));
    let mut twice = case.clone();
    twice.outlines[0][1].0 = 0;
    let error = twice.check(&program).unwrap_err();
    assert_eq!(error, CheckError::TwoOutlines { layer: 0, tool: 0 });
}

#[test]
fn skeletons_have_a_tolerance_of_their_own() {
    let mut case = small();
    case.layers.pop();
    case.outlines.pop();
    case.layers[0].beads = vec![bead(0, Feature::GapFill, &[[52.0, 50.2], [58.0, 50.2]])];
    let program = case.print().program;
    let check = |outside_skeleton| {
        let mut case = case.clone();
        case.limits.outside_skeleton = outside_skeleton;
        case.check(&program)
    };
    assert!(matches!(check(0.05), Err(CheckError::OutsideOutline { .. })));
    assert!(check(0.1).is_ok());
    for outside in [-0.1, 0.6, f64::NAN] {
        let error = check(outside).unwrap_err();
        assert!(matches!(error, CheckError::Settings(SettingsError::Value { .. })), "{error}");
    }
}

#[test]
fn fill_is_reported_and_limited() {
    let mut case = small();
    let program = case.print().program;
    let report = case.check(&program).unwrap();
    for fill in &report.fill {
        assert!((fill.extruded_mm2 - 44.0).abs() < 1e-6 && (fill.outline_mm2 - 200.0).abs() < 1e-4);
    }
    case.outlines[1][1].1 = square([70.0, 50.0], 20.0);
    let report = case.check(&program).unwrap();
    let [low, high] = [report.lowest_fill, report.highest_fill].map(Option::unwrap);
    assert_eq!((low.layer, low.tool), (1, 1));
    assert!((low.areas.ratio().unwrap() - 0.055).abs() < 1e-6);
    assert!((high.areas.ratio().unwrap() - 0.22).abs() < 1e-6);
    case.limits.layer_fill = Some([0.05, 0.23]);
    case.limits.total_fill = Some([0.08, 0.23]);
    assert!(case.check(&program).is_ok());
    case.limits.layer_fill = Some([0.06, 0.23]);
    let error = case.check(&program).unwrap_err();
    assert!(matches!(error, CheckError::Fill { layer: Some(1), tool: 1, .. }), "{error}");
    case.limits.layer_fill = None;
    case.limits.total_fill = Some([0.1, f64::INFINITY]);
    let error = case.check(&program).unwrap_err();
    assert!(matches!(error, CheckError::Fill { layer: None, tool: 1, .. }), "{error}");
    assert!(error.to_string().starts_with("tool 1 extrudes "), "{error}");
    case.limits.total_fill = Some([f64::NAN, 1.0]);
    assert!(case.check(&program).is_err());
}

#[test]
fn wipes_stay_on_the_bead() {
    // The wall ends with a move to the front: the wipe leads 2 mm back.
    let from = "G1 Y52.25 E-0.8 ";
    for to in ["G1 X50.26 Y52.25 E-0.8 ", "G1 Y52.26 E-0.8 ", "G1 Y50 E-0.8 ", "G1 Z0.3 E-0.8 "] {
        let error = error_of(|text| text.replacen(from, to, 1));
        assert!(matches!(error, CheckError::Wipe { .. }), "{to}: {error}");
    }
    let case = small();
    let text = case.print().program.emit();
    // Shorter, in two steps, or in place.
    for to in ["G1 Y51 E-0.8 ", "G1 Y51 E-0.3\nG1 Y52.25 E-0.5 ", "G1 E-0.8 "] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text);
        assert_eq!(case.check_text(&changed).err(), None, "{to}");
    }
    let mut none = small();
    none.settings.process.wipe_mm = 0.0;
    assert!(matches!(none.check_text(&text), Err(CheckError::Wipe { .. })));
    let error = error_of(|text| text.replacen(from, "G1 Y52.25 E-0.79 ", 1));
    assert!(matches!(error, CheckError::Retraction { .. }), "{error}");
}

#[test]
fn the_check_can_be_cancelled_and_reports_layers() {
    let case = small();
    let program = case.print().program;
    let cancel = CancelToken::new();
    let seen = std::sync::Mutex::new(Vec::new());
    let observe = |progress: beadwork_base::Progress| {
        seen.lock().unwrap().push((progress.done, progress.total));
    };
    let control = Control { cancel: Some(&cancel), progress: Some(&observe), ..Control::default() };
    let Case { layers, outlines, frame, settings, limits } = &case;
    let check = || check_beads(&program, layers, outlines, frame, settings, limits, &control);
    assert!(check().is_ok());
    assert_eq!(seen.lock().unwrap()[..], [(1, 2), (2, 2)]);
    cancel.cancel();
    assert_eq!(check(), Err(Interrupted::Cancelled.into()));
}
