//! Drawings of the shapes, before and after.

use std::path::Path;

use beadwork_base::Control;
use beadwork_console::output;
use beadwork_part::{BeadPanel, bead_svg};

use super::cases::Case;
use super::methods::{Column, plan};
use super::shapes::Shape;

/// Draws a layer of a shape with the beads of nearest neighbour and of cover, as SHAPE.svg in a
/// folder that exists.
pub(super) fn draw(
    shape: Shape,
    case: &Case,
    seed: u64,
    folder: &Path,
    control: &Control<'_>,
) -> anyhow::Result<()> {
    // In the manifold, a layer in which the pipes are apart.
    let layer = case.layers.len() / 4;
    let columns = [Column::NEAREST, Column::COVER];
    let mut plans = Vec::new();
    for column in columns {
        plans.push(plan(case, column, seed, control)?);
    }
    let titles: Vec<String> = columns
        .iter()
        .zip(&plans)
        .map(|(column, plan)| {
            format!("{}, {}: {} infill beads", shape.name(), column.name, plan.counts[layer].infill)
        })
        .collect();
    let panels: Vec<BeadPanel<'_>> = titles
        .iter()
        .zip(&plans)
        .map(|(title, plan)| BeadPanel { title, layer: &plan.layers[layer] })
        .collect();
    output::file(&folder.join(format!("{}.svg", shape.name())), bead_svg(&panels, None))
}
