//! A picture of some layers of a plan.

use beadwork_console::part::Part;
use beadwork_console::text::count;
use beadwork_part::print;
use beadwork_part::{Panel, svg};
use beadwork_search::plan::tools::ToolPlan;

/// Maximum number of layers drawn: two rows.
const PANELS: usize = 6;

/// Draws up to [`PANELS`] layers from bottom to top; of consecutive equal layers, only the lowest.
pub(super) fn draw(part: &Part, plan: &ToolPlan, settings: &print::Settings) -> String {
    let layers: Vec<_> = part
        .layers
        .layers
        .iter()
        .enumerate()
        .filter_map(|(number, layer)| Some((number, layer.as_ref()?)))
        .collect();
    let mut shown: Vec<usize> = (0..layers.len()).collect();
    shown.dedup_by(|b, a| layers[*a].1 == layers[*b].1);
    if shown.len() > PANELS {
        shown = (0..PANELS).map(|panel| shown[panel * (shown.len() - 1) / (PANELS - 1)]).collect();
    }
    let title = |&at: &usize| {
        let planned = &plan.layers[at];
        let beads = count(planned.path.pieces().into(), "bead");
        let crossings = count(planned.crossings.into(), "crossing");
        format!("layer {}: {beads}, {crossings}", layers[at].0 + 1)
    };
    let titles: Vec<String> = shown.iter().map(title).collect();
    let panels: Vec<Panel<'_>> = shown
        .iter()
        .zip(&titles)
        .map(|(&at, title)| Panel {
            title,
            region: &layers[at].1.region,
            zones: &layers[at].1.zones,
            path: Some(&plan.layers[at].path),
            links: &[],
        })
        .collect();
    let colours: Vec<[u8; 3]> = settings.tools.iter().map(|tool| tool.colour).collect();
    // If all tools have the same colour, zones get the colours of the palette.
    let differ = colours.iter().any(|colour| *colour != colours[0]);
    svg(&panels, differ.then_some(&colours[..]))
}
