//! What a user should know about a part: repairs, data that is not used, and what cells cannot
//! represent.

use std::collections::HashSet;

use beadwork_mesh::{Model, RepairReport, Role};
use beadwork_part::slice::{Coverage, Settings};

use crate::text::count;

/// Bodies of which more than this share of the outlines is lost are reported.
/// The tips of sharp corners are always lost.
const REPORTED_SHARE: f64 = 0.02;

/// Reports remarks, each on a line of stderr.
pub fn report(remarks: &[String]) {
    remarks.iter().for_each(|remark| eprintln!("beadwork: {remark}"));
}

/// The repairs of a body.
pub fn of_repair(body: &str, done: &RepairReport) -> String {
    let number = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        count => Some(format!("{count} {many}")),
    };
    let near = |count: usize| number(count, "near vertex merged", "near vertices merged");
    let all = [
        near(done.near_vertices)
            .map(|text| format!("{text} (up to {:.1e} mm apart)", done.merge_mm)),
        number(done.closed_t_junctions, "T-junction closed", "T-junctions closed"),
        number(done.closed_holes, "hole closed", "holes closed"),
        number(done.flipped_triangles, "triangle turned outwards", "triangles turned outwards"),
        number(
            done.dropped_triangles,
            "triangle without area dropped",
            "triangles without area dropped",
        ),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    format!("repaired {body}: {}", all.join(", "))
}

/// What became of bodies that cells do not represent, or only in part.
pub fn of_coverage(model: &Model, coverage: &[Coverage], settings: &Settings) -> Vec<String> {
    // Modifiers and negative bodies remove cells of their object on purpose.
    let others = model.bodies.iter().filter(|body| body.role != Role::Solid);
    let changed: HashSet<usize> = others.map(|body| body.object).collect();
    let mut remarks = Vec::new();
    for (body, covered) in model.bodies.iter().zip(coverage) {
        if changed.contains(&body.object) {
            continue;
        }
        let &Coverage { cells, own_cells, outline_mm, lost_mm } = covered;
        let share = lost_mm / outline_mm;
        let Settings { cell_mm, layer_mm, .. } = settings;
        let name = &body.name;
        if cells == 0 {
            remarks.push(format!(
                "body '{name}' has no cells: it is thinner than a bead of {cell_mm} mm or lower \
                 than a layer of {layer_mm} mm"
            ));
        } else if own_cells == 0 {
            remarks.push(format!(
                "body '{name}' has no cells left: later bodies cover all of its {}",
                count(cells, "cell")
            ));
        } else if share > REPORTED_SHARE {
            remarks.push(format!(
                "body '{name}': {:.0} % of its outline is too thin for beads of {cell_mm} mm and \
                 is not printed",
                100.0 * share
            ));
        }
    }
    remarks
}
