//! Programs of beads: text, speeds, merged moves, refused beads.

use beadwork_base::Control;
use beadwork_gcode::Feature;

use super::tests::golden;
use super::*;
use crate::print::{CrossSection, PrimeTower, Process, Purge};
use crate::{Bead, ExtrusionMove};

const TITLE: Title<'_> = Title { part: "beads", version: "0.0.0" };

const FRAME: Frame =
    Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.2, width: 0, height: 0 };

/// A bead of one feature, along corners with the width of the move that ends there.
fn bead(tool: u8, feature: Feature, start_mm: [f64; 2], ends: &[([f64; 2], f64)]) -> Bead {
    let step = |&(to_mm, width_mm)| ExtrusionMove { to_mm, width_mm, feature };
    Bead { tool, start_mm, moves: ends.iter().map(step).collect() }
}

fn square(tool: u8, feature: Feature, at: f64, side: f64) -> Bead {
    let (low, high) = (at, at + side);
    let corners = [[high, low], [high, high], [low, high], [low, low]];
    bead(tool, feature, [low, low], &corners.map(|corner| (corner, 0.5)))
}

fn settings() -> Settings {
    let tower = PrimeTower { left_mm: 80.0, front_mm: 60.0, width_mm: 6.0, depth_mm: 20.0 };
    Settings {
        tools: vec![Tool::default(); 2],
        process: Process {
            outer_wall_mm_s: Some(15.0),
            infill_mm_s: Some(40.0),
            gap_fill_mm_s: Some(12.0),
            small_perimeter_mm_s: Some(10.0),
            wipe_mm: 1.5,
            z_hop_mm: 0.2,
            fan: 1.0,
            ..Process::default()
        },
        purge: Some(Purge::uniform(2, 1.0, Some(tower))),
        ..Settings::default()
    }
}

fn layer(number: usize) -> BeadLayer {
    let beads = vec![
        square(0, Feature::OuterWall, 50.25, 19.5),
        square(0, Feature::InnerWall, 53.25, 5.5),
        bead(0, Feature::Infill, [60.0, 60.0], &[([65.0, 65.0], 0.45), ([65.0, 60.0], 0.45)]),
        bead(
            1,
            Feature::GapFill,
            [61.0, 51.0],
            &[
                ([62.0, 51.0], 0.3),
                ([62.0004, 51.0], 0.3),
                ([62.5, 51.0], 0.35),
                ([64.0, 51.25], 0.4),
            ],
        ),
        bead(1, Feature::ThinWall, [64.0, 51.25], &[([64.0, 56.0], 0.4)]),
        bead(1, Feature::SolidInfill, [55.0, 55.0], &[([55.0, 55.0], 0.4)]),
    ];
    BeadLayer { number, beads }
}

fn print(layers: &[BeadLayer], settings: &Settings) -> Result<Print, PrintError> {
    Print::of_beads(TITLE, layers, &FRAME, settings, &Control::default())
}

#[test]
fn a_small_print_of_beads() {
    let print = print(&[layer(0), layer(1)], &settings()).unwrap();
    golden("beads.gcode", &print.program.emit());
    // The last bead of each layer has no length; the gap fill leads on to the thin wall.
    assert_eq!(print.dropped_beads, 2);
    let totals = &print.totals;
    assert_eq!((totals.layers, totals.tool_changes, totals.lifts), (2, 3, 4));
    let area = |tool| {
        let layer = layer(0);
        let beads = layer.beads.iter().filter(|bead| bead.tool == tool);
        beads.map(Bead::area_mm2).sum::<f64>()
    };
    for tool in [0, 1] {
        let used = &totals.tools[usize::from(tool)];
        let part_mm3 = (used.filament_mm - used.purge_mm) * Tool::default().filament_mm2();
        assert!((part_mm3 - 2.0 * 0.2 * area(tool)).abs() < 1e-4, "{part_mm3}");
    }
}

#[test]
fn ovals_need_less_filament() {
    let mut settings = settings();
    let layers = [BeadLayer { number: 0, beads: vec![square(0, Feature::OuterWall, 50.0, 10.0)] }];
    let volume = |settings: &Settings| print(&layers, settings).unwrap().totals.tools[0].volume_mm3;
    assert!((volume(&settings) - 40.0 * 0.1).abs() < 1e-4);
    settings.process.cross_section = CrossSection::Oval;
    let oval_mm2 = 0.3 * 0.2 + std::f64::consts::PI * 0.01;
    assert!((volume(&settings) - 40.0 * oval_mm2).abs() < 1e-4);
}

#[test]
fn beads_are_checked() {
    type Change<'a> = &'a dyn Fn(&mut BeadLayer);
    let error = |change: Change<'_>| {
        let mut layer = layer(0);
        change(&mut layer);
        print(&[layer], &settings()).unwrap_err().to_string()
    };
    let cases: [(&str, Change<'_>); 10] = [
        ("layer 0 has no beads: the layers above would have nothing to rest on", &|layer| {
            layer.beads.clear();
        }),
        ("layer 0 has no beads: the layers above would have nothing to rest on", &|layer| {
            layer.beads.drain(..5);
        }),
        ("layer 2 has nothing to rest on: the layer below has no cells", &|layer| {
            layer.number = 2;
        }),
        ("layer 0, bead 1: unknown tool 2: the settings define 2", &|layer| {
            layer.beads[1].tool = 2;
        }),
        (
            "layer 0, bead 1: feature is Wipe tower: it must be a wall, infill or gap fill",
            &|layer| layer.beads[1].moves[0].feature = Feature::PrimeTower,
        ),
        ("layer 0, bead 0: width_mm is NaN: it must be from 0.01 to 10000", &|layer| {
            layer.beads[0].moves[2].width_mm = f64::NAN;
        }),
        ("layer 0, bead 0: width_mm is 0: it must be from 0.01 to 10000", &|layer| {
            layer.beads[0].moves[0].width_mm = 0.0;
        }),
        ("layer 0, bead 2: y is inf: it must be on the bed", &|layer| {
            layer.beads[2].start_mm[1] = f64::INFINITY;
        }),
        ("the part reaches from (-0.25, 50) to (70, 70) mm, beyond the bed", &|layer| {
            layer.beads[0].moves[3].to_mm[0] = 0.0;
        }),
        ("purge.tower overlaps the part", &|layer| layer.beads[0].moves[1].to_mm[0] = 82.0),
    ];
    for (expected, change) in cases {
        assert_eq!(error(change), expected);
    }
    assert_eq!(print(&[], &settings()), Err(SettingsError::NoLayers.into()));
    let mut fast = settings();
    fast.process.small_perimeter_mm_s = Some(300.0);
    let text = print(&[layer(0)], &fast).unwrap_err().to_string();
    assert_eq!(text, "process.small_perimeter_mm_s is 300: printer.max_speed_mm_s is 200");
    fast.process.small_perimeter_mm_s = Some(0.0);
    assert!(print(&[layer(0)], &fast).is_err());
}
