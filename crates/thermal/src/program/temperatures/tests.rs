//! Temperatures of tools that print, preheat, stand by or prime.

use super::*;

fn nozzle(text: &str) -> Vec<(f64, f64)> {
    let program: Program = text.parse().unwrap();
    let found = program_temperatures(&program, &Control::default()).unwrap();
    found.nozzle.iter().map(|one| (one.celsius, (one.share * 1e3).round() / 1e3)).collect()
}

const BEADS: &str = "G1 X0 Y0 Z0.2 F6000\nG1 X100 E5\n";

// Preheating of the next tool, as Orca does for Klipper.
#[test]
fn only_the_tool_that_prints_counts() {
    for heat in [
        "M109 S215 T0\nM104 S150 T1",
        "M104 S150 T1\nM104 S215 T0",
        "T1\nM104 S150\nT0\nM109 S215",
        "G10 P1 S150 R100\nG10 P0 S215 R180\nT0",
        "M568 P0 S215 R180 A2\nM568 P1 S240 R180",
        "SET_HEATER_TEMPERATURE HEATER=extruder TARGET=215\n\
            SET_HEATER_TEMPERATURE HEATER=extruder1 TARGET=150",
        "M104 S250\nM104 S215",
        "M104 S215\nM104 S0",
    ] {
        assert_eq!(nozzle(&format!("M83\n{heat}\n{BEADS}")), [(215.0, 1.0)], "{heat}");
    }
}

// Tools that share a nozzle, as with a Prusa MMU.
#[test]
fn a_tool_that_is_never_heated_has_the_shared_nozzle() {
    assert_eq!(nozzle(&format!("M83\nT0\nM109 S215\nT1\n{BEADS}")), [(215.0, 1.0)]);
    let text = format!("M83\nT0\nM109 S215\n{BEADS}T1\nM104 S240\n{BEADS}T0\n{BEADS}");
    let shares = nozzle(&text);
    assert_eq!(shares.iter().map(|one| one.0).collect::<Vec<_>>(), [215.0, 240.0]);
}

#[test]
fn temperatures_are_weighted_by_length() {
    let line = "G1 X300 Y5 Z0.3 F6000\nG1 X0 E9\n";
    // Without comments, a prime line counts like any bead.
    let text = format!("M83\nM109 S250\n{line}M109 S215\n{BEADS}{BEADS}");
    assert_eq!(
        nozzle(&text),
        [(215.0, 0.4), (250.0, 0.6)].map(|one| one).into_iter().rev().collect::<Vec<_>>()
    );
    let many = "G1 X0 E5\nG1 X100 E5\n".repeat(9);
    let text = format!("M83\nM109 S250\n{line}M109 S215\n;LAYER_CHANGE\n{BEADS}{many}");
    assert_eq!(nozzle(&text), [(215.0, 1.0)], "before the first layer");
    let text = format!("M83\nM109 S220\n{BEADS}M104 S215\n{many}");
    assert_eq!(nozzle(&text), [(215.0, 0.947), (220.0, 0.053)]);
    let text = format!("M83\nM109 S220\n;TYPE:Skirt\n{line};TYPE:Perimeter\nM104 S215\n{BEADS}");
    assert_eq!(nozzle(&text), [(215.0, 1.0)]);
    assert_eq!(nozzle(BEADS), []);
}

#[test]
fn a_plate_that_is_off_has_no_temperature() {
    let plate = |text: &str| {
        let program: Program = text.parse().unwrap();
        program_temperatures(&program, &Control::default()).unwrap().plate
    };
    let share = |celsius, share| TemperatureShare { celsius, share };
    let text = format!("M83\nM190 S60\n{BEADS}M140 S0\nG1 X0 E5\nG1 X100 E5\nG1 X0 E5\n");
    assert_eq!(plate(&text), [share(0.0, 0.75), share(60.0, 0.25)]);
    assert_eq!(plate(&format!("M83\n{BEADS}")), []);
    let text = format!("M83\nM140 S60\nTURN_OFF_HEATERS\n{BEADS}");
    assert_eq!(plate(&text), [share(0.0, 1.0)]);
}
