//! Emitted prints pass; prints with a fault are turned away.

use beadwork_grid::{Layout, LayoutSpec, Path, Region, Shape, Zones, cover};
use proptest::prelude::*;

use super::*;
use crate::gcode::{
    Command, CrossSection, Flavour, Line, Number, Print, Printer, Process, Purge, Title, Tool, Tower,
};

const TITLE: Title<'_> = Title { part: "test", version: "0" };

/// Layers with their numbers, and what they are printed with.
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
        Print::new(TITLE, &self.layers(), &self.frame, &self.settings).unwrap()
    }

    fn check(&self, program: &Program) -> Result<Report, CheckError> {
        // Through the text, for that is what a printer gets.
        Program::parse(&program.emit()).unwrap().check(&self.layers(), &self.frame, &self.settings)
    }
}

fn regions() -> impl Strategy<Value = Region> {
    let sides = || (1_u32..14, 1_u32..14);
    let masks = (sides(), 50_u32..100, any::<u64>()).prop_map(|((width, height), density, seed)| {
        let mut state = seed | 1;
        let mask = (0..width * height).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % 100 < u64::from(density)
        });
        Region::from_mask(width, height, mask.collect())
    });
    let shapes = (prop::sample::select(Shape::ALL.to_vec()), 5_u32..24, 5_u32..24, any::<u64>())
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
    (layers, sizes, process, prop::option::of((0.0..3.0_f64, any::<bool>())), any::<bool>()).prop_map(
        |((region, layouts), (cell_mm, layer_mm, left), (oval, retracts, hops, klipper), purge, heats)| {
            let layers = layouts.into_iter().enumerate().map(|(number, (spec, seed))| {
                let zones = spec.zones(&region, seed).unwrap();
                (number, region.clone(), zones, cover(&region))
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
                // Small cells with a change each take a long tower.
                printer: Printer { flavour, bed_mm: [250.0, 5000.0, 210.0], ..Printer::default() },
                tools: (0..3).map(tool).collect(),
                process: Process {
                    cross_section: if oval { CrossSection::Oval } else { CrossSection::Rectangle },
                    retract_mm: if retracts { 0.8 } else { 0.0 },
                    z_hop_mm: if hops { 0.3 } else { 0.0 },
                    ..Process::default()
                },
                purge: purge.map(|(volume, has_tower)| {
                    let tower = Tower { left_mm: 5.0, front_mm: 5.0, width_mm: 50.0, depth_mm: 4000.0 };
                    Purge::uniform(3, volume, has_tower.then_some(tower))
                }),
            };
            Case { layers: layers.collect(), frame, settings }
        },
    )
}

/// Numbers of the lines, from 0, that lay down the part.
fn part_lines(program: &Program) -> Vec<usize> {
    let line = |event| match event {
        Ok(Event::Motion(motion)) if motion.is_stroke() && motion.feature == Feature::SolidInfill => {
            Some(motion.line - 1)
        }
        _ => None,
    };
    program.trace().filter_map(line).collect()
}

/// The program with one line written anew.
fn changed(program: &Program, at: usize, change: impl FnOnce(&mut crate::gcode::Move)) -> Program {
    let mut program = program.clone();
    let Some(Command::Move(mut motion)) = program.lines[at].command().cloned() else { panic!("no move") };
    change(&mut motion);
    program.lines[at] = Line::from(Command::Move(motion));
    program
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_passes(case in cases()) {
        let print = case.print();
        let report = case.check(&print.program);
        prop_assert!(report.is_ok(), "{report:?}\n{}", print.program.emit());
        let report = report.unwrap();
        let cells: u64 = case.layers.iter().map(|(_, region, _, _)| u64::from(region.cell_count())).sum();
        prop_assert_eq!((report.cells, report.layers), (cells, case.layers.len()));
        prop_assert_eq!(report.tool_changes, print.totals.tool_changes);
        // Nothing is lost by rounding, however many strokes there are.
        let expected = cells as f64 * case.frame.cell_mm * case.settings.process.bead_mm2(&case.frame);
        prop_assert!((report.part_mm3 - expected).abs() < 1e-3, "{} {expected}", report.part_mm3);
        let way = cells as f64 * case.frame.cell_mm;
        prop_assert!((print.totals.extrusion_mm - way).abs() < 1e-3 * (cells as f64 + 1.0));
        let volume: f64 = print.totals.tools.iter().map(|tool| tool.volume_mm3).sum();
        prop_assert!((volume - report.part_mm3 - report.tower_mm3).abs() < 1e-6 * volume.max(1.0));
    }

    #[test]
    fn a_line_that_lacks_is_found(case in cases(), at: prop::sample::Index) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let mut program = print.program.clone();
        program.lines.remove(lines[at.index(lines.len())]);
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_line_written_twice_is_found(case in cases(), at: prop::sample::Index) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let at = lines[at.index(lines.len())];
        let mut program = print.program.clone();
        program.lines.insert(at, program.lines[at].clone());
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_shifted_place_is_found(case in cases(), at: prop::sample::Index, along_x: bool, cells in 0.2..3.0_f64) {
        let print = case.print();
        let lines = part_lines(&print.program);
        let by = Number::from_f64(cells * case.frame.cell_mm, 3).unwrap().millionths();
        let shifted = |value: Option<Number>| value.map(|value| Number::from_millionths(value.millionths() + by));
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
    fn filament_too_much_or_too_little_is_found(case in cases(), at: prop::sample::Index, share in 0.0..0.7_f64, more: bool) {
        let print = case.print();
        let lines = part_lines(&print.program);
        // Of the smallest cells, the decimals of a file tell no less.
        let share = if more { 2.0 - share } else { share };
        let program = changed(&print.program, lines[at.index(lines.len())], |motion| {
            motion.e = motion.e.map(|e| Number::from_f64(e.to_f64() * share, 5).unwrap());
        });
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_wrong_or_lacking_tool_is_found(case in cases(), at: prop::sample::Index, to in 0_u8..4, lacks: bool) {
        let print = case.print();
        let tools: Vec<_> = (0..print.program.lines.len())
            .filter(|&at| matches!(print.program.lines[at].command(), Some(Command::Tool(_))))
            .collect();
        let at = tools[at.index(tools.len())];
        let mut program = print.program.clone();
        if lacks {
            let first = program.lines.remove(at);
            // The first tool is there without being asked for.
            prop_assume!(first.command() != Some(&Command::Tool(0)) || tools[0] != at);
        } else {
            prop_assume!(program.lines[at].command() != Some(&Command::Tool(to)));
            program.lines[at] = Line::from(Command::Tool(to));
        }
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn filament_left_drawn_back_is_found(case in cases(), at: prop::sample::Index) {
        let print = case.print();
        let last_stroke = *part_lines(&print.program).last().unwrap();
        let in_place: Vec<_> = (0..last_stroke).filter(|&at| match print.program.lines[at].command() {
            Some(Command::Move(motion)) => motion.e.is_some() && motion.x.or(motion.y).is_none(),
            _ => false,
        }).collect();
        prop_assume!(!in_place.is_empty());
        let mut program = print.program.clone();
        program.lines.remove(in_place[at.index(in_place.len())]);
        let is_found = matches!(case.check(&program), Err(CheckError::Drawn { .. }));
        prop_assert!(is_found);
    }
}

/// Two layers of 3 x 2 cells, half of them of either zone, with a tower.
fn small() -> Case {
    let region = Region::rectangle(3, 2).unwrap();
    let zones = Zones::new(&region, vec![0, 0, 1, 0, 1, 1]).unwrap();
    let path = Path::hamiltonian(&region, vec![0, 1, 2, 5, 4, 3]).unwrap();
    let frame = Frame { left_mm: 60.0, back_mm: 60.0, cell_mm: 0.5, layer_mm: 0.2, width: 3, height: 2 };
    let tower = Tower { left_mm: 70.0, front_mm: 50.0, width_mm: 10.0, depth_mm: 10.0 };
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

fn fault(change: impl FnOnce(String) -> String) -> CheckError {
    let case = small();
    let text = case.print().program.emit();
    let changed = change(text.clone());
    assert_ne!(changed, text);
    Program::parse(&changed).unwrap().check(&case.layers(), &case.frame, &case.settings).unwrap_err()
}

#[test]
fn faults_are_named() {
    let case = small();
    let report = case.check(&case.print().program).unwrap();
    assert_eq!((report.layers, report.cells, report.tool_changes), (2, 12, 4));
    assert!((report.part_mm3 - 12.0 * 0.05).abs() < 1e-4);

    let error = fault(|text| text.replacen("TYPE:Wipe tower", "TYPE:Solid infill", 1));
    assert!(matches!(error, CheckError::OffCentre { .. } | CheckError::Outside { .. }), "{error}");
    let error = fault(|text| text.replacen("TYPE:Solid infill", "TYPE:Wipe tower", 1));
    assert!(matches!(error, CheckError::Tower { .. }), "{error}");
    let error = fault(|text| text.replace("Z0.4", "Z0.5"));
    assert!(matches!(error, CheckError::Height { z_mm, .. } if (z_mm - 0.5).abs() < 1e-9), "{error}");
    let error = fault(|text| text.replace("Z0.4", "Z0.2"));
    assert!(matches!(error, CheckError::Again { place: Place { layer: 0, .. }, .. }), "{error}");
    let error = fault(|text| {
        let end = text.find(";Z:0.4").unwrap();
        text[..end].to_owned()
    });
    assert_eq!(error.to_string(), "layer 1, cell (0, 0) is printed to 0 of it");
    let error = fault(|text| {
        let tower = text.rfind("TYPE:Wipe tower").unwrap();
        let (before, after) = text.split_at(tower);
        let mut strokes = 0;
        let lines = after.lines().filter(|line| {
            let is_stroke = line.contains(" E") && line.contains(" X");
            strokes += usize::from(is_stroke);
            !is_stroke || strokes != 1
        });
        before.to_owned() + &lines.collect::<Vec<_>>().join("\n")
    });
    assert!(matches!(error, CheckError::Purge { from: 1, to: 0, .. }), "{error}");
    let error = fault(|text| text.replacen("G90", "G90\nT9", 1));
    assert!(matches!(error, CheckError::Tool { tool: 9, tools: 2, .. }), "{error}");
    let error = fault(|text| text.replacen("M83", "G20", 1));
    assert!(matches!(error, CheckError::Trace(TraceError::Inches { .. })), "{error}");
}

#[test]
fn layers_of_other_planes_are_refused() {
    let mut case = small();
    let program = case.print().program;
    case.frame.width = 4;
    let error = program.check(&case.layers(), &case.frame, &case.settings).unwrap_err();
    assert!(matches!(error, CheckError::Settings(SettingsError::Layer { layer: 0, .. })), "{error}");
}
