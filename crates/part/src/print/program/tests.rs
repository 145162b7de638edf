//! Programs of small layers, refused settings, and totals.

use std::path::PathBuf;

use beadwork_base::Control;
use beadwork_grid::{Path, Region, Zones, cover};

use super::*;
use crate::print::{CrossSection, Flavour, Nozzles, PrimeTower, Printer, Process, Purge};

const TITLE: Title<'_> = Title { part: "golden", version: "0.0.0" };

const FRAME: Frame =
    Frame { left_mm: 100.0, back_mm: 100.0, cell_mm: 0.5, layer_mm: 0.25, width: 4, height: 3 };

struct Part {
    region: Region,
    zones: Zones,
    path: Path,
}

impl Part {
    fn new(width: u32, height: u32, ids: &[u8], order: &[u32]) -> Self {
        let inside = ids.iter().map(|&id| id != Zones::OUTSIDE).collect();
        let region = Region::from_mask(width, height, inside).unwrap();
        let zones = Zones::new(&region, ids.to_vec()).unwrap();
        let path = Path::in_pieces(&region, order.to_vec()).unwrap();
        Self { region, zones, path }
    }

    fn layer(&self, number: usize) -> Layer<'_> {
        Layer { number, region: &self.region, zones: &self.zones, path: &self.path }
    }
}

/// Two tools; a zigzag with two crossings, and above it a layer of two pieces, one of them a single
/// cell.
fn parts() -> [Part; 2] {
    let out = Zones::OUTSIDE;
    [
        Part::new(
            4,
            3,
            &[0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1],
            &[0, 1, 2, 3, 7, 6, 5, 4, 8, 9, 10, 11],
        ),
        Part::new(4, 3, &[1, 1, 1, out, 1, 0, 1, out, out, out, out, 1], &[4, 0, 1, 2, 6, 5, 11]),
    ]
}

fn settings(flavour: Flavour) -> Settings {
    let tool = |name: &str, colour, nozzle_c| Tool {
        name: name.to_owned(),
        colour,
        nozzle_c,
        ..Tool::default()
    };
    let tower = PrimeTower { left_mm: 110.0, front_mm: 90.0, width_mm: 6.0, depth_mm: 20.0 };
    Settings {
        printer: Printer { flavour, ..Printer::default() },
        tools: vec![tool("white", [255; 3], 230.0), tool("black", [0; 3], 220.0)],
        process: Process { fan: 0.5, z_hop_mm: 0.2, ..Process::default() },
        purge: Some(Purge { volume_mm3: vec![vec![0.0, 1.0], vec![1.5, 0.0]], tower: Some(tower) }),
    }
}

fn print(settings: &Settings) -> Result<Print, PrintError> {
    let [first, second] = parts();
    Print::new(TITLE, &[first.layer(0), second.layer(1)], &FRAME, settings, &Control::default())
}

/// Compares a text with a committed file; writes the file if the variable `BEADWORK_BLESS` is set.
pub(super) fn golden(name: &str, text: &str) {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/print/golden").join(name);
    if std::env::var_os("BEADWORK_BLESS").is_some() {
        std::fs::write(&file, text).unwrap();
    }
    let expected = std::fs::read_to_string(&file).unwrap_or_default();
    let differs = text.lines().zip(expected.lines()).position(|(a, b)| a != b);
    assert_eq!(
        text, expected,
        "{name} differs from line {differs:?} on; BEADWORK_BLESS=1 updates it"
    );
}

#[test]
fn two_flavours_of_a_small_print() {
    for (flavour, name) in [(Flavour::Marlin, "marlin.gcode"), (Flavour::Klipper, "klipper.gcode")]
    {
        let print = print(&settings(flavour)).unwrap();
        let text = print.program.emit();
        golden(name, &text);
        assert_eq!(text.parse(), Ok(print.program));
    }
}

#[test]
fn totals_of_a_small_print() {
    let totals = print(&settings(Flavour::Marlin)).unwrap().totals;
    assert_eq!((totals.layers, totals.tool_changes, totals.lifts), (2, 5, 1));
    assert!((totals.extrusion_mm - 19.0 * 0.5).abs() < 1e-6);
    let part: f64 = totals.tools.iter().map(|tool| tool.filament_mm - tool.purge_mm).sum();
    assert!((part * Tool::default().filament_mm2() - 19.0 * FRAME.cell_mm3()).abs() < 1e-4);
    // 3 changes from tool 0 to 1 and 2 back, each in whole rows of 10 cells; outline and sparse
    // columns come on top.
    assert!(totals.prime_tower_mm > 5.0 * 10.0 * 0.5);
    assert!(totals.print_seconds > totals.prime_tower_mm / 30.0 && totals.travel_mm > 0.0);
    let grams = totals.tools[0].volume_mm3 * 1.24e-3;
    assert!((totals.tools[0].grams - grams).abs() < 1e-9);
}

#[test]
fn separate_nozzles_are_hot_from_the_start() {
    let mut settings = settings(Flavour::Marlin);
    settings.printer.nozzles = Nozzles::Own;
    settings.process.z_hop_mm = 0.0;
    settings.tools[1].nozzle_c = settings.tools[0].nozzle_c;
    let text = print(&settings).unwrap().program.emit();
    golden("own-nozzles.gcode", &text);
    settings.tools[1].nozzle_c = 210.0;
    let text = print(&settings).unwrap().program.emit();
    assert!(text.contains("\nM104 T0 S230\nM104 T1 S210\nG28\n"));
    assert!(
        text.contains("\nM109 T0 S230\nM109 T1 S210\nT0\n") && text.matches("M109").count() == 2
    );
}

#[test]
fn a_tool_change_without_a_tower_leaves_the_part() {
    let settings = Settings { purge: None, ..settings(Flavour::Marlin) };
    let text = print(&settings).unwrap().program.emit();
    let at = text.find("\nT1\n").unwrap();
    let before: Vec<_> = text[..at].lines().rev().take(3).collect();
    let expected = ["G1 Z1.25 F9000", "G1 E-0.8 F2100", "G1 X101 E0.05197 F1200"];
    assert_eq!(before, expected, "raised from the edge between the cells");
    let after: Vec<_> = text[at..].lines().skip(2).take(8).collect();
    let expected = [
        "G1 Z1.25 F9000",
        "G1 X101 Y99.75",
        "G1 Z0.25",
        "G1 E0.8 F2100",
        "G1 X101.75 E0.03898 F1200",
    ];
    assert_eq!(after[..3], ["G90", "M83", "M109 R220"]);
    assert_eq!(after[3..], expected);
    assert!(!text.contains("Wipe tower"));

    let mut low = settings;
    low.printer.bed_mm[2] = 1.0;
    let text = print(&low).unwrap().program.emit();
    let heights =
        text.lines().filter_map(|line| line.strip_prefix("G1 Z")?.split(' ').next()?.parse().ok());
    assert!(heights.fold(0.0, f64::max) <= 1.0);
}

#[test]
fn junction_deviation_is_one_that_marlin_accepts() {
    for (corner, expected) in
        [(1.0, "M205 X1 Y1 J0.01\n"), (8.0, "J0.02651\n"), (50.0, "M205 X50 Y50 J0.3\n")]
    {
        let mut settings = settings(Flavour::Marlin);
        settings.printer.square_corner_mm_s = corner;
        let text = print(&settings).unwrap().program.emit();
        assert!(text.contains(expected), "{corner}");
    }
}

#[test]
fn rounding_errors_of_filament_do_not_add_up() {
    let region = Region::rectangle(61, 47).unwrap();
    let zones = Zones::new(&region, vec![0; region.grid_len()]).unwrap();
    // Beads of a single cell: every one is rounded.
    let order: Vec<u32> =
        (0..2).flat_map(|odd| region.cells().filter(move |cell| cell % 2 == odd)).collect();
    let path = Path::in_pieces(&region, order).unwrap();
    let layer = Layer { number: 0, region: &region, zones: &zones, path: &path };
    let frame = Frame { cell_mm: 0.37, width: 61, height: 47, ..FRAME };
    let settings = Settings { tools: vec![Tool::default()], ..Settings::default() };
    let totals =
        Print::new(TITLE, &[layer], &frame, &settings, &Control::default()).unwrap().totals;
    let expected = 61.0 * 47.0 * frame.cell_mm3();
    assert!((totals.tools[0].volume_mm3 - expected).abs() < 1e-4, "{totals:?}");
    assert_eq!(totals.lifts, 61 * 47 - 1);
}

fn tower(settings: &mut Settings) -> &mut PrimeTower {
    settings.purge.as_mut().unwrap().tower.as_mut().unwrap()
}

#[test]
fn each_broken_setting_is_named() {
    type Change = fn(&mut Settings);
    let cases: [(&str, Change); 15] = [
        ("printer.bed_mm[1] is NaN: it must be from 1 to 10000", |s| {
            s.printer.bed_mm[1] = f64::NAN;
        }),
        ("process.print_mm_s is 0: it must be at least 0.001 and at most a million", |s| {
            s.process.print_mm_s = 0.0;
        }),
        ("process.travel_mm_s is 150: printer.max_speed_mm_s is 149", |s| {
            s.printer.max_speed_mm_s = 149.0;
        }),
        ("process.fan is 2: it must be from 0 to 1", |s| s.process.fan = 2.0),
        ("tools[1].filament_mm is -1: it must be from 0.5 to 20", |s| {
            s.tools[1].filament_mm = -1.0;
        }),
        ("purge.volume_mm3[1][0] is inf: it must be at least 0 and at most a million", |s| {
            s.purge.as_mut().unwrap().volume_mm3[1][0] = f64::INFINITY;
        }),
        ("purge.volume_mm3 has a row or column of 3 values: expected 2, one for each tool", |s| {
            s.purge.as_mut().unwrap().volume_mm3[1].push(1.0);
        }),
        ("purge.volume_mm3 has a row or column of 1 values: expected 2, one for each tool", |s| {
            s.purge.as_mut().unwrap().volume_mm3.truncate(1);
        }),
        ("layer 0: zone 1 has no tool: the settings define 1", |s| {
            s.tools.truncate(1);
            s.purge = None;
        }),
        ("the part reaches from (100, 98.5) to (102, 100) mm, beyond the bed", |s| {
            s.printer.bed_mm[0] = 101.0;
        }),
        ("the nozzle would rise to 1.25 mm: printer.bed_mm allows 1", |s| {
            s.printer.bed_mm[2] = 1.0;
            s.process.z_hop_mm = 0.75;
        }),
        ("purge.tower reaches beyond the bed", |s| tower(s).left_mm = 245.0),
        ("purge.tower overlaps the part", |s| tower(s).left_mm = 101.0),
        ("purge.tower.depth_mm is 1: the layer that purges most requires 4.5", |s| {
            tower(s).depth_mm = 1.0;
        }),
        ("purge.tower.width_mm is 1.2: it must be at least 1.5", |s| tower(s).width_mm = 1.2),
    ];
    for (expected, change) in cases {
        let mut settings = settings(Flavour::Marlin);
        change(&mut settings);
        let got = print(&settings).map(|_| ()).map_err(|error| error.to_string());
        assert_eq!(got, Err(expected.to_owned()));
    }
}

#[test]
fn layers_are_checked() {
    let [first, second] = parts();
    let settings = settings(Flavour::Marlin);
    let error = |layers: &[Layer<'_>], frame: &Frame| {
        Print::new(TITLE, layers, frame, &settings, &Control::default()).unwrap_err()
    };
    assert_eq!(error(&[], &FRAME), SettingsError::NoLayers.into());
    let twice = [first.layer(1), second.layer(1)];
    assert_eq!(error(&twice, &FRAME), SettingsError::LayerOrder { layer: 1, before: 1 }.into());
    for (layers, layer) in [(vec![first.layer(1)], 1), (vec![first.layer(0), second.layer(2)], 2)] {
        assert_eq!(error(&layers, &FRAME), SettingsError::Gap { layer }.into());
    }
    let wide = Frame { width: 5, ..FRAME };
    assert!(matches!(
        error(&[first.layer(0)], &wide),
        PrintError::Settings(SettingsError::LayerSize { layer: 0, .. })
    ));
    let path = cover(&second.region, &Control::default()).unwrap();
    let mixed = Layer { path: &path, ..first.layer(0) };
    assert!(matches!(
        error(&[mixed], &FRAME),
        PrintError::Settings(SettingsError::LayerCells { layer: 0, .. })
    ));
    let oval = Settings {
        process: Process { cross_section: CrossSection::Oval, ..Process::default() },
        ..settings.clone()
    };
    let high = Frame { layer_mm: 0.6, ..FRAME };
    let error =
        Print::new(TITLE, &[first.layer(0)], &high, &oval, &Control::default()).unwrap_err();
    assert_eq!(error, SettingsError::HighBead { layer_mm: 0.6, cell_mm: 0.5 }.into());
}

#[test]
fn names_stay_in_their_lines() {
    let mut settings = settings(Flavour::Marlin);
    settings.tools[0].name = "a\nM112\r\0".to_owned();
    let [first, _] = parts();
    let title = Title { part: "x\r\nM112", version: "1" };
    let text = Print::new(title, &[first.layer(0)], &FRAME, &settings, &Control::default())
        .unwrap()
        .program
        .emit();
    assert!(text.lines().all(|line| !line.starts_with("M112")));
    assert!(text.contains("; tool 0 = a M112  \n") && text.contains("; part = x  M112\n"));
}
