//! Random layers of beads within convex outlines, for tests.

use std::f64::consts::TAU;

use beadwork_base::Control;
use beadwork_gcode::{Feature, Program};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{BeadLimits, BeadReport, CheckError, check_beads};
use crate::print::{
    CrossSection, Flavour, Nozzles, PrimeTower, Print, Printer, Process, Purge, Settings, Title,
    Tool,
};
use crate::slice::FillRule;
use crate::{Area, Bead, BeadLayer, ExtrusionMove, Frame};

const TITLE: Title<'_> = Title { part: "test", version: "0" };

/// Layers of beads with everything that a check needs.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) layers: Vec<BeadLayer>,
    pub(super) outlines: Vec<Vec<(u8, Area)>>,
    pub(super) frame: Frame,
    pub(super) settings: Settings,
    pub(super) limits: BeadLimits,
}

impl Case {
    pub(super) fn print(&self) -> Print {
        let control = Control::default();
        Print::of_beads(TITLE, &self.layers, &self.frame, &self.settings, &control).unwrap()
    }

    pub(super) fn check(&self, program: &Program) -> Result<BeadReport, CheckError> {
        // From the text, because that is what a printer gets.
        self.check_text(&program.emit())
    }

    pub(super) fn check_text(&self, text: &str) -> Result<BeadReport, CheckError> {
        let Self { layers, outlines, frame, settings, limits } = self;
        let program = text.parse().unwrap();
        check_beads(&program, layers, outlines, frame, settings, limits, &Control::default())
    }
}

/// Random cases; the tools stand side by side, each with a convex outline.
pub(super) fn cases() -> impl Strategy<Value = Case> {
    (any::<u64>(), any::<[bool; 6]>(), 1_usize..4, 1_u8..4).prop_map(
        |(seed, [oval, retracts, hops, klipper, own, has_tower], layers, tools)| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let layer_mm = rng.random_range(0.05..0.4);
            let width_mm = rng.random_range(0.2..0.9);
            let frame = Frame {
                left_mm: 0.0,
                back_mm: 0.0,
                cell_mm: rng.random_range(0.4..0.8),
                layer_mm,
                width: 0,
                height: 0,
            };
            let mut speed = || Some(rng.random_range(5.0..60.0)).filter(|_| rng.random::<bool>());
            let process = Process {
                outer_wall_mm_s: speed(),
                inner_wall_mm_s: speed(),
                infill_mm_s: speed(),
                solid_infill_mm_s: speed(),
                gap_fill_mm_s: speed(),
                small_perimeter_mm_s: speed(),
                cross_section: if oval { CrossSection::Oval } else { CrossSection::Rectangle },
                retract_mm: if retracts { 0.8 } else { 0.0 },
                z_hop_mm: if hops { 0.3 } else { 0.0 },
                wipe_mm: [0.0, 1.0, 7.3][rng.random_range(0..3)],
                ..Process::default()
            };
            let tower =
                PrimeTower { left_mm: 5.0, front_mm: 150.0, width_mm: 50.0, depth_mm: 40.0 };
            let settings = Settings {
                printer: Printer {
                    flavour: if klipper { Flavour::Klipper } else { Flavour::Marlin },
                    nozzles: if own { Nozzles::Own } else { Nozzles::Shared },
                    ..Printer::default()
                },
                tools: (0..tools)
                    .map(|tool| Tool { nozzle_c: 220.0 + f64::from(tool), ..Tool::default() })
                    .collect(),
                process,
                purge: Some(Purge::uniform(usize::from(tools), 0.4, has_tower.then_some(tower))),
            };
            let (layers, outlines) =
                (0..layers).map(|number| random_layer(number, tools, width_mm, &mut rng)).unzip();
            Case { layers, outlines, frame, settings, limits: BeadLimits::default() }
        },
    )
}

fn random_layer(
    number: usize,
    tools: u8,
    width_mm: f64,
    rng: &mut Xoshiro256PlusPlus,
) -> (BeadLayer, Vec<(u8, Area)>) {
    let mut beads = Vec::new();
    let mut outlines = Vec::new();
    for tool in 0..tools {
        let (radius, corners) = (rng.random_range(3.0..12.0), rng.random_range(3..30));
        let turn = rng.random_range(0.0..TAU);
        let centre = [40.0 + 40.0 * f64::from(tool), 100.0];
        let corner = |corner: i32| {
            let angle = turn + TAU * f64::from(corner) / f64::from(corners);
            [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
        };
        let area = Area::from_rings(&[(0..corners).map(corner).collect()], FillRule::NonZero);
        beads.extend(random_beads(tool, &area, width_mm, rng));
        outlines.push((tool, area));
    }
    // Any order of tools.
    for at in (1..beads.len()).rev() {
        if rng.random_range(0..3) == 0 {
            beads.swap(at, rng.random_range(0..=at));
        }
    }
    (BeadLayer { number, beads }, outlines)
}

/// A loop along the outline, and lines between random points within.
fn random_beads(tool: u8, area: &Area, width_mm: f64, rng: &mut Xoshiro256PlusPlus) -> Vec<Bead> {
    let within = area.offset(-width_mm / 2.0);
    let ring: Vec<_> = within.rings().next().unwrap().clone();
    let step = |to_mm, width_mm, feature| ExtrusionMove { to_mm, width_mm, feature };
    let wall = [Feature::OuterWall, Feature::InnerWall, Feature::ThinWall][rng.random_range(0..3)];
    let ends = ring[1..].iter().chain(&ring[..1]);
    let mut beads = vec![Bead {
        tool,
        start_mm: ring[0],
        moves: ends.map(|&to| step(to, width_mm, wall)).collect(),
    }];
    let features = [
        Feature::OuterWall,
        Feature::InnerWall,
        Feature::Infill,
        Feature::SolidInfill,
        Feature::GapFill,
        Feature::ThinWall,
    ];
    for _ in 0..rng.random_range(0..5) {
        let point = |near: Option<[f64; 2]>, rng: &mut Xoshiro256PlusPlus| {
            // Towards a corner, by at most the whole way: stays within a convex area.
            let from = near.unwrap_or(ring[rng.random_range(0..ring.len())]);
            let to = ring[rng.random_range(0..ring.len())];
            let share = match rng.random_range(0..6) {
                0 => 0.0,
                1 => rng.random_range(0.0..2e-4),
                _ => rng.random_range(0.0..1.0),
            };
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        };
        let mut at = point(None, rng);
        // Some beads go on where the last one ends.
        if rng.random_range(0..4) == 0 {
            at = beads[beads.len() - 1].end_mm();
        }
        let mut bead = Bead { tool, start_mm: at, moves: Vec::new() };
        let mut feature = features[rng.random_range(0..features.len())];
        let mut width = width_mm;
        for _ in 0..rng.random_range(0..8) {
            at = point(Some(at), rng);
            if rng.random_range(0..5) == 0 {
                feature = features[rng.random_range(0..features.len())];
                width = width_mm * rng.random_range(0.2..1.0);
            }
            bead.moves.push(step(at, width, feature));
        }
        beads.push(bead);
    }
    beads
}
