//! Emitted programs pass; programs with a fault are refused.

use beadwork_base::{CancelToken, Control, Interrupted};
use beadwork_gcode::{
    Command, Event, Feature, Heater, Line, LinearMove, Number, Program, TraceError, Wait,
};
use beadwork_grid::{Layout, LayoutSpec, Path, Region, RegionShape, Zones, cover};
use proptest::prelude::*;

use super::*;
use crate::Frame;
use crate::print::{
    CrossSection, Flavour, Layer, Nozzles, PrimeTower, Print, Printer, Process, Purge, Settings,
    SettingsError, Title, Tool,
};

const TITLE: Title<'_> = Title { part: "test", version: "0" };

/// Layers with their numbers, the frame, and the settings.
#[derive(Clone, Debug)]
struct Case {
    layers: Vec<(usize, Region, Zones, Path)>,
    frame: Frame,
    settings: Settings,
}

impl Case {
    fn layers(&self) -> Vec<Layer<'_>> {
        self.layers
            .iter()
            .map(|(number, region, zones, path)| Layer { number: *number, region, zones, path })
            .collect()
    }

    fn print(&self) -> Print {
        Print::new(TITLE, &self.layers(), &self.frame, &self.settings, &Control::default()).unwrap()
    }

    fn check(&self, program: &Program) -> Result<Report, CheckError> {
        // From the text, because that is what a printer gets.
        check(
            &program.emit().parse().unwrap(),
            &self.layers(),
            &self.frame,
            &self.settings,
            &Control::default(),
        )
    }
}

fn regions() -> impl Strategy<Value = Region> {
    let sides = || (1_u32..14, 1_u32..14);
    let masks =
        (sides(), 50_u32..100, any::<u64>()).prop_map(|((width, height), density, seed)| {
            let mut state = seed | 1;
            let mask = (0..width * height).map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) % 100 < u64::from(density)
            });
            Region::from_mask(width, height, mask.collect())
        });
    let shapes =
        (prop::sample::select(RegionShape::ALL.to_vec()), 5_u32..24, 5_u32..24, any::<u64>())
            .prop_map(|(shape, width, height, seed)| shape.region(width, height, seed));
    let rectangles = sides().prop_map(|(width, height)| Region::rectangle(width, height));
    prop_oneof![2 => masks, 2 => shapes, 1 => rectangles].prop_filter_map("no cells", Result::ok)
}

fn layouts() -> impl Strategy<Value = (LayoutSpec, u64)> {
    let layout = prop::sample::select(vec![
        Layout::LeftRight,
        Layout::Stripes,
        Layout::Checkerboard,
        Layout::TopBottom,
    ]);
    (layout, 1_u16..4, any::<u64>()).prop_map(|(layout, side, seed)| {
        let zones = if matches!(layout, Layout::LeftRight | Layout::TopBottom) { 2 } else { 3 };
        (LayoutSpec { side, zones, ..LayoutSpec::new(layout) }, seed)
    })
}

fn cases() -> impl Strategy<Value = Case> {
    let process = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>());
    let sizes = (0.2..1.2_f64, 0.05..0.2_f64, 0.0..20.0_f64);
    let layers = (regions(), prop::collection::vec(layouts(), 1..4));
    (layers, sizes, process, prop::option::of((0.0..3.0_f64, any::<bool>())), any::<[bool; 2]>())
        .prop_map(
            |(
                (region, layouts),
                (cell_mm, layer_mm, left),
                (oval, retracts, hops, klipper),
                purge,
                [heats, own],
            )| {
                let layers = layouts.into_iter().enumerate().map(|(number, (spec, seed))| {
                    let zones = spec.zones(&region, seed).unwrap();
                    (number, region.clone(), zones, cover(&region, &Control::default()).unwrap())
                });
                let frame = Frame {
                    left_mm: 60.0 + left,
                    back_mm: 100.0 - left,
                    cell_mm,
                    layer_mm,
                    width: region.width(),
                    height: region.height(),
                };
                let tool = |number: u8| Tool {
                    nozzle_c: if heats { 220.0 + f64::from(number) } else { 230.0 },
                    filament_mm: if heats { 2.85 } else { 1.75 },
                    ..Tool::default()
                };
                let flavour = if klipper { Flavour::Klipper } else { Flavour::Marlin };
                let settings = Settings {
                    // Small layers with many tool changes need a deep tower.
                    printer: Printer {
                        flavour,
                        nozzles: if own { Nozzles::Own } else { Nozzles::Shared },
                        bed_mm: [250.0, 5000.0, 210.0],
                        ..Printer::default()
                    },
                    tools: (0..3).map(tool).collect(),
                    process: Process {
                        cross_section: if oval {
                            CrossSection::Oval
                        } else {
                            CrossSection::Rectangle
                        },
                        retract_mm: if retracts { 0.8 } else { 0.0 },
                        z_hop_mm: if hops { 0.3 } else { 0.0 },
                        ..Process::default()
                    },
                    purge: purge.map(|(volume, has_tower)| {
                        let tower = PrimeTower {
                            left_mm: 5.0,
                            front_mm: 5.0,
                            width_mm: 50.0,
                            depth_mm: 4000.0,
                        };
                        Purge::uniform(3, volume, has_tower.then_some(tower))
                    }),
                };
                Case { layers: layers.collect(), frame, settings }
            },
        )
}

/// Numbers, from 0, of the lines that extrude a feature.
fn extrusions_of(program: &Program, feature: Feature) -> Vec<usize> {
    let line = |event| match event {
        Ok(Event::Motion(motion)) if motion.is_extrusion() && motion.feature == feature => {
            Some(motion.line - 1)
        }
        _ => None,
    };
    program.trace().filter_map(line).collect()
}

fn part_lines(program: &Program) -> Vec<usize> {
    extrusions_of(program, Feature::SolidInfill)
}

/// The program with lines inserted before line `at`.
fn with_lines(program: &Program, at: usize, text: &str) -> Program {
    let mut program = program.clone();
    program.lines.splice(at..at, text.parse::<Program>().unwrap().lines);
    program
}

/// The program with one move changed.
fn changed(program: &Program, at: usize, change: impl FnOnce(&mut LinearMove)) -> Program {
    let mut program = program.clone();
    let Some(Command::Move(mut motion)) = program.lines[at].command().cloned() else {
        panic!("line {at} is not a move")
    };
    change(&mut motion);
    program.lines[at] = Line::from(Command::Move(motion));
    program
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 600,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn emitted_programs_pass(case in cases()) {
        let print = case.print();
        let report = case.check(&print.program);
        prop_assert!(report.is_ok(), "{report:?}\n{}", print.program.emit());
        let report = report.unwrap();
        let cells: u64 =
            case.layers.iter().map(|(_, region, _, _)| u64::from(region.cell_count())).sum();
        prop_assert_eq!((report.cells, report.layers), (cells, case.layers.len()));
        prop_assert_eq!(report.tool_changes, print.totals.tool_changes);
        // Rounding loses nothing, however many moves there are.
        let expected =
            cells as f64 * case.frame.cell_mm * case.settings.process.bead_mm2(&case.frame);
        prop_assert!((report.part_mm3 - expected).abs() < 1e-3, "{} {expected}", report.part_mm3);
        let length = cells as f64 * case.frame.cell_mm;
        prop_assert!((print.totals.extrusion_mm - length).abs() < 1e-3 * (cells as f64 + 1.0));
        let volume: f64 = print.totals.tools.iter().map(|tool| tool.volume_mm3).sum();
        prop_assert!(
            (volume - report.part_mm3 - report.prime_tower_mm3).abs() < 1e-6 * volume.max(1.0)
        );
    }

    #[test]
    fn a_missing_line_is_found(case in cases(), at: prop::sample::Index) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let mut program = print.program.clone();
        program.lines.remove(lines[at.index(lines.len())]);
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_repeated_line_is_found(case in cases(), at: prop::sample::Index) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let at = lines[at.index(lines.len())];
        let mut program = print.program.clone();
        program.lines.insert(at, program.lines[at].clone());
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_shifted_position_is_found(
        case in cases(),
        at: prop::sample::Index,
        along_x: bool,
        cells in 0.2..3.0_f64,
    ) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let by = Number::from_f64(cells * case.frame.cell_mm, 3).unwrap().millionths();
        let shifted = |value: Option<Number>| {
            value.map(|value| Number::from_millionths(value.millionths() + by))
        };
        let program = changed(&print.program, lines[at.index(lines.len())], |motion| {
            if motion.y.is_none() || (along_x && motion.x.is_some()) {
                motion.x = shifted(motion.x);
            } else {
                motion.y = shifted(motion.y);
            }
        });
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn too_much_or_too_little_filament_is_found(
        case in cases(),
        at: prop::sample::Index,
        share in 0.0..0.7_f64,
        more: bool,
    ) {
        let print = case.print();
        let lines = part_lines(&print.program);
        // For the smallest cells, smaller changes vanish in the decimals of a file.
        let share = if more { 2.0 - share } else { share };
        let program = changed(&print.program, lines[at.index(lines.len())], |motion| {
            motion.e = motion.e.map(|e| Number::from_f64(e.to_f64() * share, 5).unwrap());
        });
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_wrong_or_missing_tool_is_found(
        case in cases(),
        at: prop::sample::Index,
        to in 0_u8..4,
        is_missing: bool,
    ) {
        let print = case.print();
        let tools: Vec<_> = (0..print.program.lines.len())
            .filter(|&at| matches!(print.program.lines[at].command(), Some(Command::Tool(_))))
            .collect();
        let at = tools[at.index(tools.len())];
        let mut program = print.program.clone();
        if is_missing {
            let first = program.lines.remove(at);
            // Tool 0 is selected by default.
            prop_assume!(first.command() != Some(&Command::Tool(0)) || tools[0] != at);
        } else {
            prop_assume!(program.lines[at].command() != Some(&Command::Tool(to)));
            program.lines[at] = Line::from(Command::Tool(to));
        }
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn missing_retraction_and_unretraction_are_found(case in cases(), at: prop::sample::Index) {
        let print = case.print();
        let last_extrusion = *part_lines(&print.program).last().unwrap();
        let in_place: Vec<_> = (0..last_extrusion)
            .filter(|&at| match print.program.lines[at].command() {
                Some(Command::Move(motion)) => {
                    motion.e.is_some() && motion.x.or(motion.y).is_none()
                }
                _ => false,
            })
            .collect();
        prop_assume!(!in_place.is_empty());
        let mut program = print.program.clone();
        program.lines.remove(in_place[at.index(in_place.len())]);
        let is_found = matches!(case.check(&program), Err(CheckError::Retraction { .. }));
        prop_assert!(is_found);
    }

    #[test]
    fn travel_to_a_forbidden_position_is_found(
        case in cases(),
        at: prop::sample::Index,
        by in 0.01..0.1_f64,
        side in 0..5,
    ) {
        let print = case.print();
        let first_extrusion = print
            .program
            .trace()
            .find_map(|event| match event {
                Ok(Event::Motion(motion)) if motion.is_extrusion() => Some(motion),
                _ => None,
            })
            .unwrap();
        let at = first_extrusion.line + at.index(print.program.lines.len() - first_extrusion.line);
        let text = match side {
            0 => format!("G1 Z{:.3}", (first_extrusion.to_mm[2] - by).max(0.0)),
            1 => format!("G1 X{:.3}", -by),
            2 => format!("G1 X{:.3}", 250.0 + by),
            3 => format!("G1 Y{:.3}", 5000.0 + by),
            _ => format!("G1 Z{:.3}", 210.0 + by),
        };
        let error = case.check(&with_lines(&print.program, at, &text)).unwrap_err();
        let is_named = matches!(error, CheckError::NozzleTooLow { .. } | CheckError::OffBed { .. });
        prop_assert!(is_named, "{error}");
    }

    #[test]
    fn missing_travel_is_found(case in cases(), at: prop::sample::Index) {
        // Without travel to the tower, only its shape suffers.
        let case = Case { settings: Settings { purge: None, ..case.settings }, ..case };
        let print = case.print();
        let last_extrusion = *part_lines(&print.program).last().unwrap();
        // After a tool change some moves lead to where the nozzle is anyway: skip short moves.
        let across: Vec<_> = print
            .program
            .trace()
            .filter_map(|event| match event {
                Ok(Event::Motion(motion)) => {
                    let [x, y] = [0, 1].map(|axis| motion.to_mm[axis] - motion.from_mm[axis]);
                    let counts = motion.line <= last_extrusion
                        && motion.extruded_mm.abs() <= 0.0
                        && x.hypot(y) > 0.05;
                    counts.then_some(motion.line - 1)
                }
                _ => None,
            })
            .collect();
        let mut program = print.program.clone();
        program.lines.remove(across[at.index(across.len())]);
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_cold_print_or_one_that_does_not_wait_is_found(
        case in cases(),
        at: prop::sample::Index,
        cools: bool,
    ) {
        let print = case.print();
        let waits = |line: &Line| match line.command() {
            Some(Command::NozzleTemperature { wait, .. }) => *wait != Wait::No,
            Some(Command::BedTemperature { wait, .. }) => *wait,
            _ => false,
        };
        let all = &print.program.lines;
        let lines: Vec<_> = (0..all.len()).filter(|&at| waits(&all[at])).collect();
        let at = lines[at.index(lines.len())];
        let mut program = print.program.clone();
        if cools {
            let lower = |celsius: Number| Number::from_f64(celsius.to_f64() - 0.5, 3).unwrap();
            program.lines[at] = Line::from(match all[at].command() {
                Some(&Command::NozzleTemperature { celsius, tool, wait }) => {
                    Command::NozzleTemperature { celsius: lower(celsius), tool, wait }
                }
                Some(&Command::BedTemperature { celsius, wait }) => {
                    Command::BedTemperature { celsius: lower(celsius), wait }
                }
                _ => unreachable!("only these wait"),
            });
        } else {
            program.lines.remove(at);
        }
        let error = case.check(&program).unwrap_err();
        let is_named =
            matches!(error, CheckError::Temperature { .. } | CheckError::NotWaited { .. });
        prop_assert!(is_named, "{error}");
    }

    #[test]
    fn heaters_and_motors_switched_off_are_found(
        case in cases(),
        at: prop::sample::Index,
        what in 0_usize..5,
    ) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let text = ["M104 S0", "M140 S0", "TURN_OFF_HEATERS", "M84", "M18"][what];
        let error = case
            .check(&with_lines(&print.program, lines[at.index(lines.len())], text))
            .unwrap_err();
        let is_named =
            matches!(error, CheckError::Temperature { .. } | CheckError::MotorsOff { .. });
        prop_assert!(is_named, "{error}");
    }

    #[test]
    fn a_faulty_prime_tower_is_found(
        case in cases(),
        at: prop::sample::Index,
        share in 0.0..0.7_f64,
        change in 0..4,
    ) {
        let tower = PrimeTower { left_mm: 5.0, front_mm: 5.0, width_mm: 50.0, depth_mm: 4000.0 };
        let purge = Some(Purge::uniform(3, 0.1 + share, Some(tower)));
        let case = Case { settings: Settings { purge, ..case.settings }, ..case };
        let print = case.print();
        let lines = extrusions_of(&print.program, Feature::PrimeTower);
        prop_assume!(!lines.is_empty());
        let at = lines[at.index(lines.len())];
        let program = changed(&print.program, at, |motion| match change {
            0 => motion.e = motion.e.map(|e| Number::from_f64(e.to_f64() * share, 5).unwrap()),
            1 => {
                motion.e =
                    motion.e.map(|e| Number::from_f64(e.to_f64() * (2.0 - share), 5).unwrap());
            }
            2 => motion.x = Some(Number::from_f64(60.0 + share, 3).unwrap()),
            _ => motion.f = Some(Number::whole(1801)),
        });
        let error = case.check(&program).unwrap_err();
        let is_named = match change {
            0 | 1 => matches!(error, CheckError::Volume { .. } | CheckError::Purge { .. }),
            2 => matches!(error, CheckError::PrimeTowerOutside { .. }),
            _ => matches!(error, CheckError::Speed { .. }),
        };
        prop_assert!(is_named, "{error}");
    }
}

/// Two layers of 3 x 2 cells, half of them in each of two zones, with a prime tower.
fn small() -> Case {
    let region = Region::rectangle(3, 2).unwrap();
    let zones = Zones::new(&region, vec![0, 0, 1, 0, 1, 1]).unwrap();
    let path = Path::hamiltonian(&region, vec![0, 1, 2, 5, 4, 3]).unwrap();
    let frame =
        Frame { left_mm: 60.0, back_mm: 60.0, cell_mm: 0.5, layer_mm: 0.2, width: 3, height: 2 };
    let tower = PrimeTower { left_mm: 70.0, front_mm: 50.0, width_mm: 10.0, depth_mm: 10.0 };
    let settings = Settings {
        tools: vec![Tool::default(); 2],
        purge: Some(Purge::uniform(2, 2.0, Some(tower))),
        ..Settings::default()
    };
    Case {
        layers: vec![(0, region.clone(), zones.clone(), path.clone()), (1, region, zones, path)],
        frame,
        settings,
    }
}

fn error_of(change: impl FnOnce(String) -> String) -> CheckError {
    let case = small();
    let text = case.print().program.emit();
    let changed = change(text.clone());
    assert_ne!(changed, text);
    let changed = changed.parse::<Program>().unwrap();
    check(&changed, &case.layers(), &case.frame, &case.settings, &Control::default()).unwrap_err()
}

#[test]
fn faults_are_named() {
    let case = small();
    let report = case.check(&case.print().program).unwrap();
    assert_eq!((report.layers, report.cells, report.tool_changes), (2, 12, 4));
    assert!((report.part_mm3 - 12.0 * 0.05).abs() < 1e-4);

    let error = error_of(|text| text.replacen("TYPE:Wipe tower", "TYPE:Solid infill", 1));
    assert!(
        matches!(error, CheckError::OffCentre { .. } | CheckError::OutsidePart { .. }),
        "{error}"
    );
    let error = error_of(|text| text.replacen("TYPE:Solid infill", "TYPE:Wipe tower", 1));
    assert!(matches!(error, CheckError::PrimeTowerOutside { .. }), "{error}");
    let error = error_of(|text| text.replace("Z0.4", "Z0.5"));
    assert!(
        matches!(error, CheckError::Height { z_mm, .. } if (z_mm - 0.5).abs() < 1e-9),
        "{error}"
    );
    let error = error_of(|text| text.replace("Z0.4", "Z0.2").replace("F1800", "F1200"));
    assert!(
        matches!(error, CheckError::PrintedTwice { position: CellPosition { layer: 0, .. }, .. }),
        "{error}"
    );
    let error = error_of(|text| {
        let end = text.find(";Z:0.4").unwrap();
        text[..end].to_owned()
    });
    assert_eq!(error.to_string(), "layer 1, cell (0, 0) is incomplete: the printed share is 0");
    let mut more = case.clone();
    more.settings.purge.as_mut().unwrap().volume_mm3[1][0] = 9.0;
    let error = more.check(&case.print().program).unwrap_err();
    assert!(matches!(error, CheckError::Purge { from: 1, to: 0, .. }), "{error}");
    let error = error_of(|text| text.replacen("G90", "G90\nT9", 1));
    assert!(matches!(error, CheckError::UnknownTool { tool: 9, tools: 2, .. }), "{error}");
    let error = error_of(|text| text.replacen("M83", "G20", 1));
    assert!(matches!(error, CheckError::Trace(TraceError::Inches { .. })), "{error}");
}

#[test]
fn layers_of_another_size_are_refused() {
    let mut case = small();
    let program = case.print().program;
    case.frame.width = 4;
    let error = check(&program, &case.layers(), &case.frame, &case.settings, &Control::default())
        .unwrap_err();
    assert!(
        matches!(error, CheckError::Settings(SettingsError::LayerSize { layer: 0, .. })),
        "{error}"
    );
}

#[test]
fn faults_of_travel_heat_and_modes_are_named() {
    // Lines before the second layer.
    let between = |lines: &str| {
        error_of(|text| {
            text.replace(";LAYER_CHANGE\n;Z:0.4", &format!("{lines}\n;LAYER_CHANGE\n;Z:0.4"))
        })
    };
    let error = between("G1 Z0.1");
    assert!(
        matches!(error, CheckError::NozzleTooLow { z_mm, .. } if (z_mm - 0.1).abs() < 1e-9),
        "{error}"
    );
    assert!(matches!(between("G1 X-3"), CheckError::OffBed { .. }));
    assert!(matches!(between("M84"), CheckError::MotorsOff { .. }));
    let error = between("M104 S0");
    assert!(matches!(error, CheckError::Temperature { heater: Heater::Nozzle(_), .. }), "{error}");
    let error = between("M104 S0\nM104 S230");
    assert!(matches!(error, CheckError::NotWaited { heater: Heater::Nozzle(_), .. }), "{error}");
    let error = error_of(|text| text.replace("M190 S80\n", ""));
    assert!(matches!(error, CheckError::NotWaited { heater: Heater::Bed, .. }), "{error}");
    let error = error_of(|text| text.replacen(" F1200", " F1201", 1));
    assert!(matches!(error, CheckError::Speed { .. }), "{error}");
    let error = error_of(|text| text.replace("G90\nM83", "M83\nG90"));
    assert!(matches!(error, CheckError::AmbiguousExtrusion { .. }), "{error}");
}

#[test]
fn each_nozzle_must_be_hot() {
    let mut case = small();
    case.settings.tools[1].nozzle_c = 220.0;
    let check = |case: &Case, from: &str, to: &str| {
        let text = case.print().program.emit();
        assert!(text.contains(from));
        case.check(&text.replace(from, to).parse().unwrap()).unwrap_err()
    };
    // `M109 S` waits only while the nozzle heats up: Marlin would continue too hot.
    let error = check(&case, "M109 R220", "M109 S220");
    assert!(matches!(error, CheckError::NotWaited { heater: Heater::Nozzle(1), .. }), "{error}");
    case.settings.printer.nozzles = Nozzles::Own;
    let error = check(&case, "M109 T1 S220\n", "");
    assert!(matches!(error, CheckError::NotWaited { heater: Heater::Nozzle(1), .. }), "{error}");
    case.settings.printer.flavour = Flavour::Klipper;
    let error = check(&case, "M109 T1 S220", "M109 T1 R220");
    assert!(matches!(error, CheckError::Temperature { heater: Heater::Nozzle(1), .. }), "{error}");
}

#[test]
fn a_prime_tower_must_begin_on_the_bed() {
    let mut case = small();
    let (_, region, zones, _) = &mut case.layers[0];
    *zones = Zones::new(region, vec![0; 6]).unwrap();
    let program = case.print().program;
    assert_eq!(case.check(&program).map(|report| report.tool_changes), Ok(2));
    let text = program.emit();
    let (before, after) = text.split_at(text.find(";LAYER_CHANGE\n;Z:0.4").unwrap());
    let mut in_tower = false;
    let without = before.lines().filter(|line| {
        in_tower = if line.starts_with(";TYPE") { line.contains("tower") } else { in_tower };
        !(in_tower && line.contains(" E0") && (line.contains(" X") || line.contains(" Y")))
    });
    let text = without.collect::<Vec<_>>().join("\n") + "\n" + after;
    let error = case.check(&text.parse().unwrap()).unwrap_err();
    assert!(matches!(error, CheckError::PrimeTowerInAir { layer: 1, .. }), "{error}");
    case.settings.purge = None;
    let error = case.check(&program).unwrap_err();
    assert!(matches!(error, CheckError::PrimeTowerOutside { .. }), "{error}");
}

#[test]
fn writing_and_checking_can_be_cancelled_and_report_layers() {
    let case = small();
    let program = case.print().program;
    let cancel = CancelToken::new();
    let seen = std::sync::Mutex::new(Vec::new());
    let observe = |progress: beadwork_base::Progress| {
        seen.lock().unwrap().push((progress.done, progress.total));
    };
    let control = Control { cancel: Some(&cancel), progress: Some(&observe), ..Control::default() };
    let print = || Print::new(TITLE, &case.layers(), &case.frame, &case.settings, &control);
    let check = || check(&program, &case.layers(), &case.frame, &case.settings, &control);
    assert!(print().is_ok() && check().is_ok());
    assert_eq!(seen.lock().unwrap()[..], [(1, 2), (2, 2), (1, 2), (2, 2)]);
    cancel.cancel();
    assert_eq!(print(), Err(Interrupted::Cancelled.into()));
    assert_eq!(check(), Err(Interrupted::Cancelled.into()));
}
