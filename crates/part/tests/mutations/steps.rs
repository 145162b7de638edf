//! The steps that a changed file goes through.

use beadwork_base::Control;
use beadwork_gcode::{Event, Program};
use beadwork_mesh::{Format, MaterialRule, Model, Placement, ReadLimits, RepairSettings};
use beadwork_part::print::{self, Flavour};
use beadwork_part::slice;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use zip::CompressionMethod;

use crate::bead_plan::{BeadPlan, prints_the_same};
use crate::cell_plan::CellPlan;
use crate::change::changed;
use crate::seed::{Content, Seed, pack};

/// Runs all steps on a changed file; returns whether the last one was reached.
pub(crate) fn run(seed: &Seed, number: u64) -> bool {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(number);
    match &seed.content {
        Content::Mesh(format, bytes) => mesh_steps(*format, &changed(bytes, &mut rng), number),
        Content::Parts(parts) => {
            let mut parts = parts.clone();
            let part = rng.random_range(0..parts.len());
            parts[part].1 = changed(&parts[part].1, &mut rng);
            let method =
                if rng.random() { CompressionMethod::Stored } else { CompressionMethod::Deflated };
            mesh_steps(Format::ThreeMf, &pack(&parts, method), number)
        }
        Content::Gcode(bytes) => gcode_steps(&changed(bytes, &mut rng)),
        Content::Beads(flavour, bytes) => {
            bead_steps(*flavour, &String::from_utf8_lossy(bytes), &changed(bytes, &mut rng))
        }
    }
}

fn mesh_steps(format: Format, bytes: &[u8], number: u64) -> bool {
    let Ok(mut model) = Model::read(format, bytes, &ReadLimits::default(), &Control::default())
    else {
        return false;
    };
    let is_finite = |model: &Model| {
        model.bodies.iter().all(|body| body.mesh.vertices().iter().flatten().all(|v| v.is_finite()))
    };
    assert!(model.triangle_count() > 0 && is_finite(&model));
    for body in &mut model.bodies {
        // A body that cannot be repaired stays as it is: later steps must handle that too.
        _ = body.repair(&RepairSettings::default(), &Control::default());
        assert!(body.paint.is_empty() || body.paint.len() == body.mesh.triangles().len());
    }
    let rules = [MaterialRule::Stated, MaterialRule::PerBody, MaterialRule::Single];
    model.assign_materials(rules[(number % 3) as usize]);
    let settings =
        slice::Settings { cell_mm: 1.0, layer_mm: 1.0, max_cells: 1 << 18, ..Default::default() };
    _ = slice::slice(&model, &settings, &Control::default());
    if Placement::default().apply(&mut model).is_err() {
        return false;
    }
    assert!(is_finite(&model));
    let Ok(layers) = slice::slice(&model, &settings, &Control::default()) else { return false };
    assert_eq!(layers.voxels().count() as u64, layers.cell_count());
    true
}

fn gcode_steps(bytes: &[u8]) -> bool {
    let Ok(program) = Program::from_bytes(bytes, &Control::default()) else { return false };
    assert_eq!(program.emit().parse().as_ref(), Ok(&program));
    for event in program.trace() {
        match event {
            Ok(Event::Motion(motion)) => {
                assert!(motion.length_mm().is_finite() && motion.extruded_mm.is_finite());
                assert!(motion.feed_mm_s > 0.0);
            }
            Ok(Event::Pause { seconds, .. }) => assert!(seconds >= 0.0),
            _ => {}
        }
    }
    let plan = CellPlan::new();
    let settings = CellPlan::settings(Flavour::Marlin);
    _ = print::check(&program, &plan.layers(), &plan.frame, &settings, &Control::default());
    let Ok(seconds) = program.print_seconds(settings.printer.limits(), &Control::default()) else {
        return false;
    };
    assert!(seconds >= 0.0 && seconds.is_finite(), "{seconds} s");
    true
}

/// A program that passes the check of beads prints what the unchanged one prints.
fn bead_steps(flavour: Flavour, before: &str, bytes: &[u8]) -> bool {
    let Ok(after) = Program::from_bytes(bytes, &Control::default()) else { return false };
    let plan = BeadPlan::new();
    if plan.check(&after, flavour).is_err() {
        return false;
    }
    let before: Program = before.parse().unwrap();
    assert!(prints_the_same(&before, &after), "the check accepts another print");
    true
}
