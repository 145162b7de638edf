//! Programs of planned parts deposit every voxel once; other programs deposit the voxels that their
//! beads fill.

use std::fmt::Write;
use std::sync::{Arc, Mutex};

use beadwork_base::{CancelToken, Control, Interrupted, Progress};
use beadwork_gcode::{MotionLimits, Program};
use beadwork_grid::{Path, Region, Zones, cover};
use beadwork_part::Frame;
use beadwork_part::print::{self, PrimeTower, Print, Purge, Title, Tool};
use beadwork_part::slice::Voxels;
use ndarray::Array3;
use proptest::prelude::*;

use super::*;
use crate::simulation::Method;
use crate::{DepositionEvent, ProcessParameters, Simulation, ThermalMaterial};

/// A part in layers of two zones, each layer with a path.
#[derive(Debug)]
struct Planned {
    frame: Frame,
    layers: Vec<(Region, Zones, Path)>,
}

impl Planned {
    fn new(width: u32, height: u32, cell_mm: f64, masks: &[Vec<bool>]) -> Self {
        let frame = Frame {
            left_mm: 40.3,
            back_mm: 60.71,
            cell_mm,
            layer_mm: cell_mm / 2.0,
            width,
            height,
        };
        let layer = |mask: &Vec<bool>| {
            let region = Region::from_mask(width, height, mask.clone()).unwrap();
            let side = |cell: u32| u8::from(cell % width >= width / 2);
            let ids = (0..)
                .zip(mask)
                .map(|(cell, &inside)| if inside { side(cell) } else { Zones::OUTSIDE });
            let zones = Zones::new(&region, ids.collect()).unwrap();
            let path = cover(&region, &Control::default()).unwrap();
            (region, zones, path)
        };
        Self { frame, layers: masks.iter().map(layer).collect() }
    }

    fn block(width: u32, height: u32, depth: usize) -> Self {
        Self::new(width, height, 0.5, &vec![vec![true; (width * height) as usize]; depth])
    }

    fn voxels(&self) -> Voxels {
        let materials = self.layers.iter().flat_map(|(_, zones, _)| zones.ids()).copied().collect();
        let shape = (self.layers.len(), self.frame.height as usize, self.frame.width as usize);
        Voxels::new(self.frame, Array3::from_shape_vec(shape, materials).unwrap())
    }

    /// The voxels in the order of the paths.
    fn order(&self) -> Vec<[u32; 3]> {
        let of_layer = |(z, (region, _, path)): (usize, &(Region, Zones, Path))| {
            let voxel = |&cell: &u32| [region.xy(cell).0, region.xy(cell).1, z as u32];
            path.order().iter().map(voxel).collect::<Vec<_>>()
        };
        self.layers.iter().enumerate().flat_map(of_layer).collect()
    }

    fn print(&self) -> (Program, print::Settings) {
        let tower =
            Some(PrimeTower { left_mm: 100.0, front_mm: 20.0, width_mm: 20.0, depth_mm: 120.0 });
        let purge = Some(Purge::uniform(2, 4.0, tower));
        let tools = vec![Tool::default(); 2];
        let settings = print::Settings { tools, purge, ..print::Settings::default() };
        let layers: Vec<_> = self
            .layers
            .iter()
            .enumerate()
            .map(|(number, (region, zones, path))| print::Layer { number, region, zones, path })
            .collect();
        let title = Title { part: "part", version: "0" };
        let print =
            Print::new(title, &layers, &self.frame, &settings, &Control::default()).unwrap();
        // As in a file, with rounded coordinates.
        (print.program.emit().parse().unwrap(), settings)
    }
}

fn births(events: &[DepositionEvent]) -> Vec<[u32; 3]> {
    events.iter().filter_map(|event| event.voxel).collect()
}

/// The events of a program, with some voxels left out if `tolerated_share` allows it.
fn events_of(
    program: &Program,
    part: &Voxels,
    tolerated_share: f64,
) -> Result<ProgramEvents, ProgramError> {
    let settings = Settings { tolerated_share, ..Settings::default() };
    program_events(program, part, &settings, &Control::default())
}

fn masks(width: u32, height: u32) -> impl Strategy<Value = Vec<Vec<bool>>> {
    let mask = prop::collection::vec(prop::bool::weighted(0.8), (width * height) as usize);
    let filled = mask.prop_filter("no cell", |mask| mask.contains(&true));
    prop::collection::vec(filled, 1..4)
}

fn planned() -> impl Strategy<Value = Planned> {
    let sizes = (1..12_u32, 1..9_u32, prop::sample::select(vec![0.4, 0.42, 0.45, 0.5, 0.61]));
    sizes.prop_flat_map(|(width, height, cell_mm)| {
        masks(width, height).prop_map(move |masks| Planned::new(width, height, cell_mm, &masks))
    })
}

proptest! {
    #[test]
    fn a_planned_part_is_deposited_in_the_order_of_its_paths(planned in planned()) {
        let (program, settings) = planned.print();
        let limits = settings.printer.limits();
        let part = planned.voxels();
        let how = Settings { limits, ..Settings::default() };
        let done = program_events(&program, &part, &how, &Control::default()).unwrap();
        prop_assert_eq!(births(&done.events), planned.order());
        prop_assert!(done.missed.is_empty());

        let total: f64 = done.events.iter().map(|event| event.seconds).sum();
        let expected = program.print_seconds(limits, &Control::default()).unwrap();
        prop_assert!((total - expected).abs() < 1e-9 * expected, "{} s, not {}", total, expected);

        // Not faster than the speed, and not slower than with two stops in a cell.
        let frame = part.frame;
        for event in done.events.iter().filter(|event| event.voxel.is_some()) {
            let min_s = 0.98 * frame.cell_mm / 30.0;
            prop_assert!((min_s..0.2).contains(&event.seconds), "{event:?}");
        }
        let is_pause = |event: &DepositionEvent| event.voxel.is_none();
        prop_assert!(!done.events.windows(2).any(|pair| is_pause(&pair[0]) && is_pause(&pair[1])));

        let mut cells = 0;
        for (z, &end) in done.layer_ends.iter().enumerate() {
            cells += part.cells(z).count();
            prop_assert_eq!(births(&done.events[..end]).len(), cells);
            prop_assert!(done.events[end - 1].voxel.is_some());
        }
        let layers = done.layers();
        prop_assert_eq!(layers.concat(), &done.events[..done.layer_ends[part.depth - 1]]);
        for (z, layer) in (0..).zip(&layers) {
            prop_assert!(births(layer).iter().all(|voxel| voxel[2] == z));
        }
    }

    #[test]
    fn a_program_of_cells_shows_its_part(planned in planned()) {
        let (program, _) = planned.print();
        let Frame { cell_mm, layer_mm, .. } = planned.frame;
        let found = program_voxels(&program, cell_mm, layer_mm, &Control::default()).unwrap();
        let voxels = |part: &Voxels| {
            let of_layer = |z: usize| {
                let width = part.frame.width;
                part.cells(z).map(move |cell| {
                    let [x, y] = [cell % width, cell / width];
                    (z, part.material(x, y, z), part.frame.centre(x, y))
                })
            };
            (0..part.depth).flat_map(of_layer).collect::<Vec<_>>()
        };
        let (found, expected) = (voxels(&found), voxels(&planned.voxels()));
        prop_assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            prop_assert_eq!((found.0, found.1), (expected.0, expected.1));
            let [x, y] = [0, 1].map(|axis| (found.2[axis] - expected.2[axis]).abs());
            prop_assert!(x.max(y) < 0.005, "{found:?} {expected:?}");
        }
    }
}

#[test]
fn what_a_program_prints_can_be_simulated() {
    let planned = Planned::block(12, 8, 3);
    let part = planned.voxels();
    let done = events_of(&planned.print().0, &part, 0.0).unwrap();
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let mut simulation =
        Simulation::new(Arc::new(part), &material, &process, Method::default()).unwrap();
    simulation.run(&done.events, &Control::default()).unwrap();
    assert_eq!(simulation.cell_temperatures_c(2).count(), 96);
}

#[test]
fn voxels_left_out_are_named_and_may_be_tolerated() {
    let (program, _) = Planned::block(6, 4, 2).print();
    let higher = Planned::block(6, 4, 3).voxels();
    let refused = events_of(&program, &higher, 0.0);
    let expected = ProgramError::Missed { voxel: [0, 0, 2], layer: 3, missed: 24, voxels: 72 };
    assert_eq!(refused, Err(expected));
    let done = events_of(&program, &higher, 0.34).unwrap();
    assert_eq!((done.missed.len(), done.layer_ends[2]), (24, 0));
    assert_eq!(done.printed(&higher).count(), 48);
    assert_eq!(done.printed(&higher).cells(2).count(), 0);
}

/// A layer of 8 x 6 cells of 0.5 mm, its front left corner at 10, 10.
fn plate() -> Voxels {
    let frame =
        Frame { left_mm: 10.0, back_mm: 13.0, cell_mm: 0.5, layer_mm: 0.25, width: 8, height: 6 };
    Voxels::new(frame, Array3::zeros((1, 6, 8)))
}

fn events(text: &str) -> Vec<DepositionEvent> {
    events_of(&text.parse().unwrap(), &plate(), 1.0).unwrap().events
}

#[test]
fn a_bead_passes_cells_at_the_nozzles_speed() {
    // 4 mm along the front row from rest, up to 30 mm/s within 0.45 mm.
    let found =
        events("M83\nM204 S1000\nG1 X10 Y10.25 Z0.25 F6000\nG4 P1\nG1 X14 E1 F1800\nG1 X10 F6000");
    let cells: Vec<_> = (0..8).map(|x| [x, 5, 0]).collect();
    assert_eq!(births(&found), cells);
    let first = 0.03 + 0.05 / 30.0;
    assert!((found[1].seconds - first).abs() < 1e-6, "{:?}", found[1]);
    assert!((found[4].seconds - 0.5 / 30.0).abs() < 1e-6, "{:?}", found[4]);
    assert!(found[0].voxel.is_none() && found[9].voxel.is_none() && found.len() == 10);
}

#[test]
fn many_short_motions_are_one_bead() {
    let bead = |step: f64| {
        let steps = (4.0 / step).round() as usize;
        let motion = |i: usize| format!("G1 X{:.3} E0.01\n", 10.0 + step * i as f64);
        let text: String = (1..=steps).map(motion).collect();
        events(&format!("M83\nG1 X10 Y10.25 Z0.25 F6000\nG1 F1800\n{text}"))
    };
    let (long, short) = (bead(4.0), bead(0.008));
    assert_eq!(births(&long), births(&short));
    assert!(
        long.iter().zip(&short).all(|(a, b)| (a.seconds - b.seconds).abs() < 1e-4),
        "{short:?}"
    );
}

#[test]
fn beads_next_to_the_part_and_on_it_are_pauses() {
    let begin = "M83\nG1 X10 Y10.25 Z0.25 F6000\n";
    let once = events(&format!("{begin}G1 X12 E1 F1800\n"));
    let twice = events(&format!("{begin}G1 X12 E1 F1800\nG1 X10 E1\n"));
    assert_eq!(births(&once), births(&twice));
    assert!(twice.last().unwrap().voxel.is_none());
    for bead in ["G1 X60 Y60\nG1 X62 E1", ";TYPE:Skirt\nG1 X12 E1", "G1 Z0.5\nG1 X12 E1", "G1 X12"]
    {
        let found = events(&format!("{begin}{bead}\n"));
        assert!(found.len() == 1 && found[0].voxel.is_none(), "{bead}: {found:?}");
    }
    // Two beads in the same cell with a pause between them: only the first deposits the voxel.
    let back = events(&format!("{begin}G1 X10.25 E1 F1800\nG4 P100\nG1 X10.5 E1\n"));
    assert_eq!(births(&back), [[0, 5, 0]]);
    assert_eq!(back.len(), 3);
}

#[test]
fn slanted_beads_fill_what_they_cover() {
    // Lines at 45° that are half a millimetre apart and extend far beyond the part on all sides.
    let line = |i: i32| {
        let x = 0.5 * 2.0_f64.sqrt() * f64::from(i);
        format!("G1 X{:.3} Y5 F6000\nG1 X{:.3} Y18 E1 F1800\n", x, x + 13.0)
    };
    let text: String = (-10..30).map(line).collect();
    let found = events(&format!("M83\nG1 Z0.25 F6000\n{text}"));
    let mut cells = births(&found);
    cells.sort_unstable();
    cells.dedup();
    assert_eq!(cells.len(), 48);
    assert_eq!(births(&found).len(), 48);
}

fn voxels_of(program: &Program, cell_mm: f64) -> Result<Voxels, VoxelsError> {
    program_voxels(program, cell_mm, 0.25, &Control::default())
}

#[test]
fn programs_without_a_part_are_refused() {
    let refused = |text: &str| voxels_of(&text.parse().unwrap(), 0.5).unwrap_err();
    assert_eq!(refused("G1 X10 F600"), VoxelsError::Nothing);
    assert_eq!(refused("M83\nG1 X10 E1 F600"), VoxelsError::Low { line: 2, z_mm: 0.0 });
    assert!(matches!(refused("G20"), VoxelsError::Trace(_)));
    let far = "M83\nG1 Z0.25\nG1 X100000 E1 F600";
    assert!(matches!(refused(far), VoxelsError::TooLarge { .. }));
    let program = "M83\nG1 Z0.25\nG1 X10 E1 F600".parse().unwrap();
    assert!(matches!(voxels_of(&program, 0.0), Err(VoxelsError::Size { .. })));
    let row = voxels_of(&program, 0.5).unwrap();
    assert_eq!((row.frame.width, row.frame.height, row.depth, row.count()), (20, 1, 1, 20));
}

/// A program of many motions.
fn long_program() -> Program {
    let line = |i: usize| format!("G1 X{:.3} E0.01\n", 10.0 + 4e-4 * i as f64);
    let text: String = (1..=10_000).map(line).collect();
    format!("M83\nG1 X10 Y10.25 Z0.25 F6000\n{text}").parse().unwrap()
}

#[test]
fn programs_report_their_lines() {
    let program = long_program();
    let reports = Mutex::new(Vec::new());
    let report = |progress: Progress| reports.lock().unwrap().push(progress);
    let control = Control { progress: Some(&report), ..Control::default() };
    let settings = Settings { tolerated_share: 1.0, ..Settings::default() };
    program_events(&program, &plate(), &settings, &control).unwrap();
    let of_events = std::mem::take(&mut *reports.lock().unwrap());
    program_voxels(&program, 0.5, 0.25, &control).unwrap();
    let of_voxels = std::mem::take(&mut *reports.lock().unwrap());
    let lines = program.lines.len();
    for (reports, total) in [(of_events, lines), (of_voxels, 2 * lines)] {
        assert!(reports.len() > 9 && reports.iter().all(|progress| progress.total == total));
        assert!(reports.is_sorted_by_key(|progress| progress.done));
        assert_eq!(reports.last().unwrap().done, total);
    }
}

#[test]
fn programs_can_be_interrupted() {
    let program = long_program();
    let cancel = CancelToken::new();
    let report = |_: Progress| _ = cancel.cancel();
    let control = Control { cancel: Some(&cancel), progress: Some(&report), ..Control::default() };
    let events = program_events(&program, &plate(), &Settings::default(), &control);
    assert_eq!(events, Err(ProgramError::Interrupted(Interrupted::Cancelled)));
    let voxels = program_voxels(&program, 0.5, 0.25, &control);
    assert_eq!(voxels, Err(VoxelsError::Interrupted(Interrupted::Cancelled)));
}

proptest! {
    #[test]
    fn paths_visit_the_cells_that_their_program_deposits(
        points in prop::collection::vec((0..12_000_u32, 0..9_000_u32), 2..9),
    ) {
        let planned = Planned::block(20, 14, 1);
        let (frame, part) = (planned.frame, planned.voxels());
        let position = |&(x, y): &(u32, u32)| {
            [frame.left_mm - 1.0 + f64::from(x) / 1e3, frame.back_mm + 1.0 - f64::from(y) / 1e3]
        };
        let mut points: Vec<[f64; 2]> = points.iter().map(position).collect();
        points.dedup();
        prop_assume!(points.len() > 1);
        let speed = 25.0;
        let [x, y] = points[0];
        let mut text = format!("M83\nG1 X{x:.3} Y{y:.3} Z{} F1500\n", frame.layer_mm);
        for [x, y] in &points[1..] {
            writeln!(text, "G1 X{x:.3} Y{y:.3} E1").unwrap();
        }
        let lines = points.windows(2).map(|ends| {
            let [from, to] = [ends[0], ends[1]];
            ([from, to], f64::hypot(to[0] - from[0], to[1] - from[1]) / speed)
        });
        let total: f64 = lines.clone().map(|(_, seconds)| seconds).sum();
        let visits = path_visits(lines, &frame);
        let sum: f64 = visits.iter().map(|visit| visit.seconds).sum();
        prop_assert!((sum - total).abs() < 1e-9 * total);
        let limits = MotionLimits {
            acceleration_mm_s2: 1e12,
            square_corner_mm_s: 1e6,
            max_speed_mm_s: 1e6,
        };
        let settings = Settings { limits, tolerated_share: 1.0 };
        let control = Control::default();
        let program: Program = text.parse().unwrap();
        let events = program_events(&program, &part, &settings, &control).unwrap().events;
        // The program's first visits of each cell.
        let mut seen = std::collections::HashSet::new();
        let first = |visit: &PathVisit| visit.cell.filter(|&cell| seen.insert(cell));
        let expected: Vec<[u32; 2]> = visits.iter().filter_map(first).collect();
        let deposited: Vec<[u32; 2]> =
            events.iter().filter_map(|event| event.voxel.map(|[x, y, _]| [x, y])).collect();
        prop_assert_eq!(deposited, expected);
    }
}
