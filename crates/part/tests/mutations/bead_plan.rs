//! A plan of beads, whose program is changed and checked.

use beadwork_base::Control;
use beadwork_gcode::{Event, Feature, Program};
use beadwork_part::print::{
    self, BeadLimits, BeadReport, CheckError, Flavour, Nozzles, PrimeTower, Print, Printer,
    Process, Purge, Settings, Title, Tool,
};
use beadwork_part::slice::FillRule;
use beadwork_part::{Area, Bead, BeadLayer, ExtrusionMove, Frame};

/// Two layers of two squares side by side, one for each tool: a wall joined to infill, a line of
/// infill, and a gap bead of varying width.
pub(crate) struct BeadPlan {
    layers: Vec<BeadLayer>,
    outlines: Vec<Vec<(u8, Area)>>,
    frame: Frame,
}

const WIDTH_MM: f64 = 0.5;

/// Side of a square.
const SIDE_MM: f64 = 4.0;

impl BeadPlan {
    pub(crate) fn new() -> Self {
        let beads = |number: usize| [0, 1].into_iter().flat_map(move |tool| square(tool, number));
        let outline = |tool: u8| {
            let [x, y] = [100.0 + SIDE_MM * f64::from(tool), 100.0];
            let [right, back] = [x + SIDE_MM, y + SIDE_MM];
            let ring = vec![[x, y], [right, y], [right, back], [x, back]];
            (tool, Area::from_rings(&[ring], FillRule::NonZero))
        };
        let layers =
            (0..2).map(|number| BeadLayer { number, beads: beads(number).collect() }).collect();
        let frame = Frame {
            left_mm: 0.0,
            back_mm: 0.0,
            cell_mm: WIDTH_MM,
            layer_mm: 0.2,
            width: 0,
            height: 0,
        };
        Self { layers, outlines: vec![[0, 1].map(outline).to_vec(); 2], frame }
    }

    /// With Marlin a nozzle and a prime tower for both tools, with Klipper a nozzle for each tool.
    fn settings(flavour: Flavour) -> Settings {
        let tower = PrimeTower { left_mm: 120.0, front_mm: 50.0, width_mm: 8.0, depth_mm: 20.0 };
        let is_shared = flavour == Flavour::Marlin;
        let nozzles = if is_shared { Nozzles::Shared } else { Nozzles::Own };
        Settings {
            tools: vec![Tool::default(); 2],
            process: Process {
                outer_wall_mm_s: Some(20.0),
                wipe_mm: 1.0,
                z_hop_mm: 0.2,
                ..Process::default()
            },
            purge: Some(Purge::uniform(2, 1.0, is_shared.then_some(tower))),
            printer: Printer { flavour, nozzles, ..Printer::default() },
        }
    }

    pub(crate) fn print(&self, flavour: Flavour) -> String {
        let title = Title { part: "squares", version: "0" };
        let settings = Self::settings(flavour);
        let control = Control::default();
        Print::of_beads(title, &self.layers, &self.frame, &settings, &control)
            .unwrap()
            .program
            .emit()
    }

    pub(crate) fn check(
        &self,
        program: &Program,
        flavour: Flavour,
    ) -> Result<BeadReport, CheckError> {
        print::check_beads(
            program,
            &self.layers,
            &self.outlines,
            &self.frame,
            &Self::settings(flavour),
            &BeadLimits { outside_skeleton: 0.5, ..BeadLimits::default() },
            &Control::default(),
        )
    }
}

/// The beads of a square.
fn square(tool: u8, layer: usize) -> Vec<Bead> {
    let at = |x: f64, y: f64| [100.0 + SIDE_MM * f64::from(tool) + x, 100.0 + y];
    let bead = |start: [f64; 2], moves: &[([f64; 2], f64, Feature)]| Bead {
        tool,
        start_mm: start,
        moves: moves
            .iter()
            .map(|&(to_mm, width_mm, feature)| ExtrusionMove { to_mm, width_mm, feature })
            .collect(),
    };
    let [low, high] = [0.25, 3.75];
    let wall = [(high, low), (high, high), (low, high), (low, low)]
        .map(|(x, y)| (at(x, y), WIDTH_MM, Feature::OuterWall));
    let infill = if layer == 0 { Feature::SolidInfill } else { Feature::Infill };
    let joined = [(at(0.75, 0.75), WIDTH_MM, infill), (at(0.75, 3.25), WIDTH_MM, infill)];
    let gap = [0.3, 0.45, 0.6].map(|width| (at(2.0, 1.0 + 3.0 * width), width, Feature::GapFill));
    vec![
        bead(at(low, low), &[&wall[..], &joined].concat()),
        bead(at(3.0, 0.9), &[(at(3.0, 3.1), WIDTH_MM, infill)]),
        bead(at(2.0, 0.8), &gap),
    ]
}

/// A motion that extrudes into the part.
struct Printed {
    tool: u8,
    feature: Feature,
    ends_mm: [[f64; 3]; 2],
    filament_mm: f64,
    /// Filament of the tool that was unretracted minus retracted up to here.
    unretracted_mm: f64,
}

/// Whether two programs print the same into the part: the same motions in the same order, at
/// positions that differ by no more than rounding, and at no time more or less filament of a tool.
pub(crate) fn prints_the_same(a: &Program, b: &Program) -> bool {
    let [a, b] = [a, b].map(printed);
    let mut surplus_mm = [0.0_f64; 2];
    let mut is_same = |a: &Printed, b: &Printed| {
        let surplus = &mut surplus_mm[usize::from(a.tool)];
        *surplus += a.filament_mm - b.filament_mm;
        let ends = a.ends_mm.iter().zip(&b.ends_mm);
        let mut pairs = ends.flat_map(|(a, b)| [0, 1, 2].map(|axis| (axis, a[axis], b[axis])));
        let is_near = pairs.all(|(axis, a, b)| {
            // The check accepts layers that are 0.001 mm too high or too low.
            (a - b).abs() < if axis == 2 { 0.0011 } else { 0.0002 }
        });
        // Each program may differ from the plan by 0.000006 mm, and by 0.00002 mm where filament
        // is retracted.
        let is_filament =
            surplus.abs() < 1.3e-5 && (a.unretracted_mm - b.unretracted_mm).abs() < 4.1e-5;
        a.tool == b.tool && a.feature == b.feature && is_near && is_filament
    };
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| is_same(a, b))
}

fn printed(program: &Program) -> Vec<Printed> {
    let mut printed = Vec::new();
    let mut unretracted_mm = [0.0; 256];
    for event in program.trace() {
        let Ok(Event::Motion(motion)) = event else { continue };
        let unretracted_mm = &mut unretracted_mm[usize::from(motion.tool)];
        if !motion.is_extrusion() {
            *unretracted_mm += motion.extruded_mm;
        } else if motion.feature != Feature::PrimeTower {
            printed.push(Printed {
                tool: motion.tool,
                feature: motion.feature,
                ends_mm: [motion.from_mm, motion.to_mm],
                filament_mm: motion.extruded_mm,
                unretracted_mm: *unretracted_mm,
            });
        }
    }
    printed
}

/// Without this, programs that pass the check would prove nothing.
#[test]
fn a_changed_motion_is_not_the_same_print() {
    let text = BeadPlan::new().print(Flavour::Klipper);
    let before: Program = text.parse().unwrap();
    assert!(prints_the_same(&before, &before));
    let prints =
        |line: &str| line.starts_with("G1 X") && line.contains(" E") && !line.contains("E-");
    let lines: Vec<&str> = text.lines().collect();
    let mut compared = 0;
    for at in (0..lines.len()).filter(|&at| prints(lines[at])) {
        // Without the line, twice, and with 0.1 mm more filament.
        let (step, filament) = lines[at].split_once(" E").unwrap();
        let [filament, rest] = filament.split_once(' ').map_or([filament, ""], |(a, b)| [a, b]);
        let more = format!("{step} E{:.5} {rest}", filament.parse::<f64>().unwrap() + 0.1);
        let changes = [vec![], vec![lines[at]; 2], vec![more.as_str()]];
        for change in changes {
            let changed = [&lines[..at], &change, &lines[at + 1..]].concat().join("\n");
            assert!(!prints_the_same(&before, &changed.parse().unwrap()), "line {}", at + 1);
            compared += 1;
        }
    }
    assert!(compared > 30, "{compared} lines");
}
