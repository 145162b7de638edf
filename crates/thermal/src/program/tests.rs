//! Programs of planned parts give every voxel once; those of others give what their beads fill.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::{Path, Region, Zones, cover};
use beadwork_part::print::{self, PrimeTower, Print, Purge, Settings, Title, Tool};
use ndarray::Array3;
use proptest::prelude::*;

use super::*;
use crate::{Material, Method, Process, Simulation};

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
            let place = |&cell: &u32| [region.xy(cell).0, region.xy(cell).1, z as u32];
            path.order().iter().map(place).collect::<Vec<_>>()
        };
        self.layers.iter().enumerate().flat_map(of_layer).collect()
    }

    fn print(&self) -> (Program, Settings) {
        let tower =
            Some(PrimeTower { left_mm: 100.0, front_mm: 20.0, width_mm: 20.0, depth_mm: 120.0 });
        let purge = Some(Purge::uniform(2, 4.0, tower));
        let settings = Settings { tools: vec![Tool::default(); 2], purge, ..Settings::default() };
        let layers: Vec<_> = self
            .layers
            .iter()
            .enumerate()
            .map(|(number, (region, zones, path))| print::Layer { number, region, zones, path })
            .collect();
        let title = Title { part: "part", version: "0" };
        let print =
            Print::new(title, &layers, &self.frame, &settings, &Control::default()).unwrap();
        // As files have it: places are rounded.
        (print.program.emit().parse().unwrap(), settings)
    }
}

fn births(slots: &[Slot]) -> Vec<[u32; 3]> {
    slots.iter().filter_map(|slot| slot.voxel).collect()
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
    fn a_planned_part_is_born_in_the_order_of_its_paths(planned in planned()) {
        let (program, settings) = planned.print();
        let limits = settings.printer.limits();
        let part = planned.voxels();
        let how = ProgramSettings { limits, ..ProgramSettings::default() };
        let done = program_slots(&program, &part, &how).unwrap();
        prop_assert_eq!(births(&done.slots), planned.order());
        prop_assert!(done.missed.is_empty());

        let total: f64 = done.slots.iter().map(|slot| slot.seconds).sum();
        let expected = program.print_seconds(limits, &Control::default()).unwrap();
        prop_assert!((total - expected).abs() < 1e-9 * expected, "{} s, not {}", total, expected);

        // As slow as the speed, and no slower than stopping twice in a cell.
        let frame = part.frame;
        for slot in done.slots.iter().filter(|slot| slot.voxel.is_some()) {
            let fastest = 0.98 * frame.cell_mm / 30.0;
            prop_assert!((fastest..0.2).contains(&slot.seconds), "{slot:?}");
        }
        prop_assert!(done.slots.windows(2).all(|pair| pair[0].voxel.is_some() || pair[1].voxel.is_some()));

        let mut cells = 0;
        for (z, &end) in done.layer_ends.iter().enumerate() {
            cells += part.cells(z).count();
            prop_assert_eq!(births(&done.slots[..end]).len(), cells);
            prop_assert!(done.slots[end - 1].voxel.is_some());
        }
    }

    #[test]
    fn a_program_of_cells_shows_its_part(planned in planned()) {
        let (program, _) = planned.print();
        let Frame { cell_mm, layer_mm, .. } = planned.frame;
        let found = program_voxels(&program, cell_mm, layer_mm).unwrap();
        let voxels = |part: &Voxels| {
            let of_layer = |z: usize| {
                let place = move |cell: u32| [cell % part.frame.width, cell / part.frame.width];
                part.cells(z).map(place).map(move |[x, y]| (z, part.material(x, y, z), part.frame.centre(x, y)))
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
    let done = program_slots(&planned.print().0, &part, &ProgramSettings::default()).unwrap();
    let mut simulation =
        Simulation::new(Arc::new(part), &Material::abs(), &Process::default(), Method::default())
            .unwrap();
    simulation.run(&done.slots).unwrap();
    assert_eq!(simulation.layer_c(2).count(), 96);
}

#[test]
fn voxels_left_out_are_named_and_may_be_tolerated() {
    let (program, _) = Planned::block(6, 4, 2).print();
    let higher = Planned::block(6, 4, 3).voxels();
    let refused = program_slots(&program, &higher, &ProgramSettings::default());
    let expected = ProgramError::Missed { voxel: [0, 0, 2], layer: 3, missed: 24, voxels: 72 };
    assert_eq!(refused, Err(expected));
    let tolerant = ProgramSettings { tolerated_share: 0.34, ..ProgramSettings::default() };
    let done = program_slots(&program, &higher, &tolerant).unwrap();
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

fn slots(text: &str) -> Vec<Slot> {
    let tolerant = ProgramSettings { tolerated_share: 1.0, ..ProgramSettings::default() };
    program_slots(&text.parse().unwrap(), &plate(), &tolerant).unwrap().slots
}

#[test]
fn a_bead_passes_cells_at_its_own_pace() {
    // 4 mm along the front row from rest, up to 30 mm/s within 0.45 mm.
    let found =
        slots("M83\nM204 S1000\nG1 X10 Y10.25 Z0.25 F6000\nG4 P1\nG1 X14 E1 F1800\nG1 X10 F6000");
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
        slots(&format!("M83\nG1 X10 Y10.25 Z0.25 F6000\nG1 F1800\n{text}"))
    };
    let (long, short) = (bead(4.0), bead(0.008));
    assert_eq!(births(&long), births(&short));
    assert!(
        long.iter().zip(&short).all(|(a, b)| (a.seconds - b.seconds).abs() < 1e-4),
        "{short:?}"
    );
}

#[test]
fn beads_beside_the_part_and_on_it_are_pauses() {
    let begin = "M83\nG1 X10 Y10.25 Z0.25 F6000\n";
    let once = slots(&format!("{begin}G1 X12 E1 F1800\n"));
    let twice = slots(&format!("{begin}G1 X12 E1 F1800\nG1 X10 E1\n"));
    assert_eq!(births(&once), births(&twice));
    assert!(twice.last().unwrap().voxel.is_none());
    for bead in ["G1 X60 Y60\nG1 X62 E1", ";TYPE:Skirt\nG1 X12 E1", "G1 Z0.5\nG1 X12 E1", "G1 X12"]
    {
        let found = slots(&format!("{begin}{bead}\n"));
        assert!(found.len() == 1 && found[0].voxel.is_none(), "{bead}: {found:?}");
    }
    // The same place, but the head is elsewhere in between: what belongs to one bead only is one
    // slot.
    let back = slots(&format!("{begin}G1 X10.25 E1 F1800\nG4 P100\nG1 X10.5 E1\n"));
    assert_eq!(births(&back), [[0, 5, 0]]);
    assert_eq!(back.len(), 3);
}

#[test]
fn slanted_beads_fill_what_they_cover() {
    // Lines half a millimetre apart at 45°, far beyond the part on all sides.
    let line = |i: i32| {
        let x = 0.5 * 2.0_f64.sqrt() * f64::from(i);
        format!("G1 X{:.3} Y5 F6000\nG1 X{:.3} Y18 E1 F1800\n", x, x + 13.0)
    };
    let text: String = (-10..30).map(line).collect();
    let found = slots(&format!("M83\nG1 Z0.25 F6000\n{text}"));
    let mut cells = births(&found);
    cells.sort_unstable();
    cells.dedup();
    assert_eq!(cells.len(), 48);
    assert_eq!(births(&found).len(), 48);
}

#[test]
fn programs_without_a_part_are_refused() {
    let refused = |text: &str| program_voxels(&text.parse().unwrap(), 0.5, 0.25).unwrap_err();
    assert_eq!(refused("G1 X10 F600"), VoxelsError::Nothing);
    assert_eq!(refused("M83\nG1 X10 E1 F600"), VoxelsError::Low { line: 2, z_mm: 0.0 });
    assert!(matches!(refused("G20"), VoxelsError::Trace(_)));
    let far = "M83\nG1 Z0.25\nG1 X100000 E1 F600";
    assert!(matches!(refused(far), VoxelsError::TooLarge { .. }));
    let program = "M83\nG1 Z0.25\nG1 X10 E1 F600".parse().unwrap();
    assert!(matches!(program_voxels(&program, 0.0, 0.25), Err(VoxelsError::Size { .. })));
    let row = program_voxels(&program, 0.5, 0.25).unwrap();
    assert_eq!((row.frame.width, row.frame.height, row.depth, row.count()), (20, 1, 1, 20));
}
