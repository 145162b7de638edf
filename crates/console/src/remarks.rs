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
    // Modifiers and negative bodies change cells of their object on purpose.
    let objects = |role: Role| -> HashSet<usize> {
        let bodies = model.bodies.iter().filter(|body| body.role == role);
        bodies.map(|body| body.object).collect()
    };
    let (modified, reduced) = (objects(Role::Modifier), objects(Role::Negative));
    let Settings { cell_mm, layer_mm, .. } = settings;
    let too_small =
        format!("it is thinner than a bead of {cell_mm} mm or lower than a layer of {layer_mm} mm");
    let mut remarks = Vec::new();
    for (body, covered) in model.bodies.iter().zip(coverage) {
        let &Coverage { cells, own_cells, outline_mm, lost_mm } = covered;
        let name = &body.name;
        let (is_modified, is_reduced) =
            (modified.contains(&body.object), reduced.contains(&body.object));
        let share = lost_mm / outline_mm;
        match body.role {
            Role::Solid if cells == 0 => {
                remarks.push(format!("body '{name}' has no cells: {too_small}"));
            }
            Role::Solid if own_cells == 0 && !is_modified => {
                let others = if is_reduced { "later or negative bodies" } else { "later bodies" };
                remarks.push(format!(
                    "body '{name}' has no cells left: {others} cover all of its {}",
                    count(cells, "cell")
                ));
            }
            Role::Solid if share > REPORTED_SHARE && !is_modified && !is_reduced => {
                remarks.push(format!(
                    "body '{name}': {:.0} % of its outline is too thin for beads of {cell_mm} mm \
                     and is not printed",
                    100.0 * share
                ));
            }
            Role::Negative | Role::Modifier if cells == 0 => {
                let what = if body.role == Role::Negative { "negative body" } else { "modifier" };
                remarks.push(format!(
                    "{what} '{name}' has no effect: {too_small}, or lies beside the part"
                ));
            }
            _ => {}
        }
    }
    remarks
}

/// Bodies that other bodies cover, and negative bodies and modifiers without effect, if a part is
/// printed with beads.
///
/// `coverage` counts cells, which are coarser than beads: a wall thinner than a cell has none, but
/// can be printed.
/// So only what cells prove is reported.
pub fn of_bodies(model: &Model, coverage: &[Coverage]) -> Vec<String> {
    let is_modified = |object| {
        model.bodies.iter().any(|body| body.role == Role::Modifier && body.object == object)
    };
    let mut remarks = Vec::new();
    for (body, covered) in model.bodies.iter().zip(coverage) {
        let name = &body.name;
        match body.role {
            Role::Solid
                if covered.cells > 0 && covered.own_cells == 0 && !is_modified(body.object) =>
            {
                remarks.push(format!(
                    "body '{name}' is not printed: later or negative bodies cover it"
                ));
            }
            Role::Negative | Role::Modifier if covered.cells == 0 => {
                let what = if body.role == Role::Negative { "negative body" } else { "modifier" };
                remarks.push(format!(
                    "{what} '{name}' has hardly any effect: it is thinner than a bead, or lies \
                     beside the part"
                ));
            }
            _ => {}
        }
    }
    remarks
}

#[cfg(test)]
mod tests {
    use beadwork_mesh::Body;

    use super::*;

    // prusa3d/PrusaSlicer#15694: negative volumes that remove everything, or nothing
    #[test]
    fn bodies_without_effect_are_reported() {
        let body =
            |name: &str, object, role| Body { name: name.into(), object, role, ..Body::default() };
        let bodies = vec![
            body("wall", 0, Role::Solid),
            body("slit", 0, Role::Negative),
            body("cube", 1, Role::Solid),
            body("cover", 1, Role::Negative),
            body("plate", 2, Role::Solid),
            body("stripe", 2, Role::Modifier),
        ];
        let model = Model { bodies, ..Model::default() };
        let of = |cells, own_cells| Coverage { cells, own_cells, outline_mm: 1.0, lost_mm: 0.5 };
        let coverage = [of(0, 0), of(0, 0), of(9, 0), of(20, 0), of(9, 0), of(0, 0)];
        let too_small = "it is thinner than a bead of 0.5 mm or lower than a layer of 0.25 mm";
        assert_eq!(
            of_coverage(&model, &coverage, &Settings::default()),
            [
                format!("body 'wall' has no cells: {too_small}"),
                format!("negative body 'slit' has no effect: {too_small}, or lies beside the part"),
                "body 'cube' has no cells left: later or negative bodies cover all of its 9 cells"
                    .to_owned(),
                format!("modifier 'stripe' has no effect: {too_small}, or lies beside the part"),
            ]
        );
    }
}
