//! Parts from mesh to checked G-code: insets and infill, each a bead of its own.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

use beadwork_base::Control;
use beadwork_gcode::{Feature, Program};
use beadwork_mesh::{Example, MaterialRule, Model, Placement, RepairSettings};
use beadwork_part::print::{
    self, BeadLimits, BeadReport, CheckError, Print, Process, Purge, Title, Tool,
};
use beadwork_part::slice::{self, Cut};
use beadwork_part::toolpath::{self, Island, islands};
use beadwork_part::{Bead, BeadLayer, ExtrusionMove, Frame};

const WIDTH_MM: f64 = 0.5;

/// The insets of an island from the outside inwards, then its infill.
fn beads(island: &Island) -> Vec<Bead> {
    let bead = |points: &[[f64; 2]], is_closed: bool, feature| {
        let step = |&to_mm| ExtrusionMove { to_mm, width_mm: WIDTH_MM, feature };
        let ends = points[1..].iter().chain(points.first().filter(|_| is_closed));
        Bead { tool: island.material, start_mm: points[0], moves: ends.map(step).collect() }
    };
    let insets = island.insets.iter().map(|inset| {
        let is_outer = inset.depth == 0;
        bead(&inset.ring, true, if is_outer { Feature::OuterWall } else { Feature::InnerWall })
    });
    let infill = island.infill.iter().flat_map(|infill| {
        let feature = if infill.is_solid { Feature::SolidInfill } else { Feature::Infill };
        let lines = infill.lines.iter().map(move |line| bead(line, false, feature));
        lines.chain(infill.loops.iter().map(move |ring| bead(ring, true, feature)))
    });
    insets.chain(infill).collect()
}

/// Prints a model with beads, and checks the text.
fn print(mut model: Model, layer_mm: f64, density: f64) -> Result<BeadReport, CheckError> {
    let control = Control::default();
    for body in &mut model.bodies {
        body.repair(&RepairSettings::default(), &control).unwrap();
    }
    model.assign_materials(MaterialRule::Stated);
    Placement::default().apply(&mut model).unwrap();
    let cutting = slice::Settings { layer_mm, ..slice::Settings::default() };
    let areas = Cut::new(&model, &cutting, &control).unwrap().areas(&cutting, &control).unwrap();
    let filling = toolpath::Settings { density, ..toolpath::Settings::default() };
    let islands = islands(&areas, &filling, &control).unwrap();
    let layer = |(number, islands): (usize, &Vec<Island>)| BeadLayer {
        number,
        beads: islands.iter().flat_map(beads).collect(),
    };
    let layers: Vec<_> = islands.iter().enumerate().map(layer).collect();
    let outlines: Vec<Vec<_>> = areas
        .into_iter()
        .map(|layer| layer.areas.into_iter().map(|each| (each.material, each.area)).collect())
        .collect();

    let tools = 1 + outlines.iter().flatten().map(|(tool, _)| *tool).max().unwrap();
    let settings = print::Settings {
        tools: vec![Tool::default(); usize::from(tools)],
        process: Process { wipe_mm: 1.0, z_hop_mm: 0.2, ..Process::default() },
        purge: Some(Purge::uniform(usize::from(tools), 10.0, None)),
        ..print::Settings::default()
    };
    let frame =
        Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: WIDTH_MM, layer_mm, width: 0, height: 0 };
    let title = Title { part: "part", version: "0" };
    let print = Print::of_beads(title, &layers, &frame, &settings, &control).unwrap();
    let program: Program = print.program.emit().parse().unwrap();
    let limits = BeadLimits::default();
    print::check_beads(&program, &layers, &outlines, &frame, &settings, &limits, &control)
}

#[test]
fn insets_and_infill_stay_within_the_outlines() {
    for example in [Example::UShape, Example::LogoPlate] {
        for density in [0.2, 1.0] {
            let report = print(example.model(), 0.5, density).unwrap();
            for fill in &report.fill {
                let ratio = fill.ratio().unwrap();
                assert!(ratio < 1.01 && ratio > 0.9 * density, "{example}, {density}: {ratio}");
            }
        }
    }
}
