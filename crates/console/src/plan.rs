//! From planned layers to G-code that has been checked.

use anyhow::Context;
use beadwork_gcode::Program;
use beadwork_part::print::{self, Layer, Print};
use beadwork_part::slice::{self, Layers};
use beadwork_search::plan::{LayerRef, ToolPlan};

use crate::part::Part;
use crate::printer::Profile;

/// Layers with cells, as the planner takes them.
pub fn refs(layers: &Layers) -> Vec<LayerRef<'_>> {
    let layers = layers.layers.iter().flatten();
    layers.map(|slice::Layer { region, zones }| LayerRef { region, zones }).collect()
}

/// Layers with the paths of those that have cells, as they are printed: from the bed up, empty ones
/// below left out.
pub fn printed_layers<'a>(
    layers: &'a Layers,
    paths: impl Iterator<Item = &'a beadwork_grid::Path>,
) -> Vec<Layer<'a>> {
    let numbered = layers.layers.iter().skip(layers.empty_below()).enumerate();
    let filled = numbered.filter_map(|(number, layer)| Some((number, layer.as_ref()?)));
    let with_path =
        |((number, layer), path): ((usize, &'a slice::Layer), &'a beadwork_grid::Path)| Layer {
            number,
            region: &layer.region,
            zones: &layer.zones,
            path,
        };
    filled.zip(paths).map(with_path).collect()
}

/// A plan as G-code that has been checked.
pub struct Printed {
    pub text: String,
    pub totals: beadwork_gcode::Totals,
    /// What the check found in the text.
    pub checked: print::Report,
    pub settings: print::Settings,
}

/// Writes a plan as G-code, and checks the text: what is wrong there must not reach a printer.
pub fn print(
    part: &Part,
    plan: &ToolPlan,
    profile: &Profile,
    settings: print::Settings,
) -> anyhow::Result<Printed> {
    let layers = printed_layers(&part.layers, plan.layers.iter().map(|planned| &planned.path));
    let frame = &part.layers.frame;
    let (Print { program, totals }, settings) =
        profile.print(&part.name, &layers, frame, settings)?;
    let text = program.emit();
    drop(program);
    let checked = print::check(&Program::parse(&text)?, &layers, frame, &settings);
    let checked =
        checked.context("the G-code does not print the plan; this is a fault of beadwork")?;
    Ok(Printed { text, totals, checked, settings })
}
