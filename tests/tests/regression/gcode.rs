//! `simulate --gcode` with programs of other slicers, for other firmware and in other encodings.

use std::fmt::Write;
use std::fs;

use beadwork_tests::{beadwork, text};
use serde_json::Value;

/// A block of 10 x 5 mm in beads 0.5 mm wide, with layers of these heights.
fn block(heights_mm: &[f64]) -> String {
    let mut program = "; extrusion_width = 0.5\n; layer_height = 0.2\nG21\nG90\nM83\n\
        M140 S60\nM104 S215\nG28\nM190 S60\nM109 S215\n;PRIME\n"
        .to_owned();
    let mut z = 0.0;
    for height in heights_mm {
        z += height;
        write!(program, ";LAYER_CHANGE\nG1 Z{z:.2} F6000\nG1 X100.25 Y100.25\nG1 F1800\n").unwrap();
        for row in 0..10 {
            let [y, x] =
                [100.25 + 0.5 * f64::from(row), if row % 2 == 0 { 109.75 } else { 100.25 }];
            write!(program, "G1 Y{y:.2} E0.02\nG1 X{x:.2} E0.38\n").unwrap();
        }
    }
    program + "M104 S0\nM140 S0\n"
}

/// Result on stdout, `None` if the run failed, and the lines on stderr.
fn simulate(program: &[u8]) -> (Option<Value>, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("block.gcode");
    fs::write(&file, program).unwrap();
    let arguments = ["simulate", "--json", "--gcode", text(&file)];
    let output = beadwork().args(arguments).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(!errors.contains("panicked"), "{errors}");
    if !output.status.success() {
        assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{errors}");
        return (None, errors);
    }
    let mut value: Value = serde_json::from_slice(&output.stdout).unwrap();
    value.as_object_mut().unwrap().remove("seconds");
    (Some(value), errors)
}

fn plain() -> (String, Value) {
    let program = block(&[0.2; 5]);
    let (value, errors) = simulate(program.as_bytes());
    assert_eq!(errors, "");
    (program, value.unwrap())
}

#[test]
fn other_spellings_give_the_same_result() {
    let (program, expected) = plain();
    assert_eq!((&expected["voxels"], &expected["depth"]), (&1000.into(), &5.into()));
    let modal = program.replace("\nG1 Y", "\nY").replace("E0.02\nG1 X", "E0.02\nX");
    let utf16 = |order: fn(u16) -> [u8; 2]| {
        format!("\u{feff}{program}").encode_utf16().flat_map(order).collect::<Vec<u8>>()
    };
    let spellings = [
        // Commands combined on a line.
        program.replace("G21\nG90\nM83\n", "G90 G21 M83\n").into_bytes(),
        // chilipeppr/tinyg#33
        modal.into_bytes(),
        program.replace("G1 ", "g01").to_lowercase().into_bytes(),
        // Duet3D/RepRapFirmware#1112
        program.replace(";PRIME", "T0 S1 L0 D0").into_bytes(),
        program.replace("M109 S215", "M109 S215 T0\nM104 S150 T1 ; preheat").into_bytes(),
        program
            .replace("M104 S215", "SET_HEATER_TEMPERATURE HEATER=extruder TARGET=215")
            .replace("M109 S215", "TEMPERATURE_WAIT SENSOR=extruder MINIMUM=213")
            .into_bytes(),
        program.replace("M104 S215", "G10 P0 S215 R180").replace("M109 S215", "M116").into_bytes(),
        program.replace('\n', "\r\n").into_bytes(),
        program.replace('\n', "\r").into_bytes(),
        [b"\xef\xbb\xbf; pi\xe8ce\n", program.as_bytes()].concat(),
        utf16(u16::to_le_bytes),
        utf16(u16::to_be_bytes),
    ];
    for spelling in spellings {
        let (value, errors) = simulate(&spelling);
        let shown = String::from_utf8_lossy(&spelling[..spelling.len().min(300)]);
        assert_eq!((value.as_ref(), errors.as_str()), (Some(&expected), ""), "{shown}");
    }
}

#[test]
fn what_cannot_be_read_is_refused_by_name() {
    let (program, _) = plain();
    for (line, message) in [
        ("G20 (Units: Inches)", "line 11: inches (G20) are not supported"),
        ("M83 G20", "line 11: inches (G20) are not supported"),
        ("G18", "line 11: arcs outside the xy plane"),
        ("G5 X105 Y101 I1 J0 P-1 Q0 E0.2", "line 11: G5 is not supported: curves"),
        ("G55", "line 11: G55 is not supported"),
        ("G0 G90 X5", "line 11: G90 is not supported: words of a motion"),
        ("X105", "line 11: words without a command"),
    ] {
        let (value, errors) = simulate(program.replace(";PRIME", line).as_bytes());
        assert!(value.is_none() && errors.contains(message), "{line}: {errors}");
    }
    for (bytes, message) in [
        (&b"GCDE\x01\0\0\0"[..], "binary G-code (.bgcode)"),
        (b"PK\x03\x04", "ZIP archive"),
        (b"G1 X1\n\0\0", "line 2: byte 6 of the file is zero"),
        (b"\n; only comments\n", "contains no G-code command"),
    ] {
        let (value, errors) = simulate(bytes);
        assert!(value.is_none() && errors.contains(message), "{errors}");
    }
}

// A prime line hotter and higher than the first layer.
#[test]
fn a_prime_line_is_left_out() {
    let (program, expected) = plain();
    let prime = "M109 S250\nG1 X5 Y5 Z0.28 F6000\nG1 X60 E5 F1200\nM109 S215";
    let (value, errors) = simulate(program.replace(";PRIME", prime).as_bytes());
    let value = value.unwrap();
    for key in ["voxels", "depth", "width", "process"] {
        assert_eq!(value[key], expected[key], "{key}");
    }
    assert!(errors.contains("55 mm of beads before or below the first layer"), "{errors}");
}

#[test]
fn changes_of_temperature_and_unknown_commands_are_reported() {
    let (program, _) = plain();
    let hotter = program
        .replace("M109 S215", "M109 S225\nM600")
        .replace(";LAYER_CHANGE\nG1 Z0.40", ";LAYER_CHANGE\nM104 S215\nG1 Z0.40");
    let (value, errors) = simulate(hotter.as_bytes());
    assert_eq!(value.unwrap()["process"]["nozzle_c"], 215.0);
    assert!(errors.contains("(215 °C for 80.0 %, 225 °C for 20.0 % of the beads)"), "{errors}");
    assert!(errors.contains("1 command of the program has no effect here: M600"), "{errors}");

    let by_macro = program
        .replace("M104 S215\n", "START_PRINT BED_TEMP=60 EXTRUDER_TEMP=205\n")
        .replace("M109 S215\n", "");
    let (value, errors) = simulate(by_macro.as_bytes());
    assert_eq!(value.unwrap()["process"]["nozzle_c"], 205.0);
    assert!(errors.contains("START_PRINT"), "{errors}");
}

// PrusaSlicer, first_layer_height = 0.3, and variable layer heights
#[test]
fn layers_of_several_heights_are_mapped_to_voxels() {
    let (value, errors) = simulate(block(&[0.3, 0.2, 0.2, 0.2, 0.2]).as_bytes());
    let value = value.unwrap();
    assert_eq!((&value["depth"], &value["voxels"]), (&5.into(), &1000.into()));
    assert_eq!(value["layers"].as_array().unwrap().len(), 5);
    assert_eq!(value["layer_fit"]["layers"], 5);
    assert!(errors.contains("5 layers of 1.100 mm together become 5 rows"), "{errors}");

    let (value, errors) = simulate(block(&[0.2, 0.12, 0.08, 0.15, 0.25, 0.2]).as_bytes());
    let value = value.unwrap();
    assert_eq!((&value["depth"], &value["voxels"]), (&5.into(), &1000.into()));
    assert!(errors.contains("1 layer is too thin to fill a row"), "{errors}");

    // A layer of three rows.
    let (value, errors) = simulate(
        block(&[0.3, 0.1, 0.1]).replace("layer_height = 0.2", "layer_height = 0.1").as_bytes(),
    );
    let value = value.unwrap();
    assert_eq!((&value["depth"], &value["voxels"]), (&5.into(), &1000.into()));
    assert!(errors.contains("off by up to 0.000 mm, the volume by +0.0 %"), "{errors}");
}
