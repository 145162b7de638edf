//! Writes planned layers as G-code, and checks the result.

use anyhow::Context;
use beadwork_base::Threads;
use beadwork_gcode::Program;
use beadwork_part::print::{self, Layer, Print};
use beadwork_part::slice::{self, Layers};
use beadwork_search::plan::tools::{LayerRef, ToolPlan};

use crate::control;
use crate::part::Part;
use crate::printer::Profile;

/// The layers that have cells, as input of the planner.
pub fn refs(layers: &Layers) -> Vec<LayerRef<'_>> {
    let layers = layers.layers.iter().flatten();
    layers.map(|slice::Layer { region, zones }| LayerRef { region, zones }).collect()
}

/// The layers that have cells, with their paths and their numbers counted from the bed.
/// Empty layers at the bottom are left out, so layer 0 is the lowest one with cells.
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

/// A plan as checked G-code.
pub struct Printed {
    /// The text of the program.
    pub text: String,
    /// Time, travel and filament.
    pub totals: beadwork_gcode::Totals,
    /// Result of the check of the text.
    pub checked: print::Report,
    /// The settings, with the position of the prime tower.
    pub settings: print::Settings,
}

/// Writes a plan as G-code, and checks the text: a faulty program must not reach a printer.
pub fn print(
    part: &Part,
    plan: &ToolPlan,
    profile: &Profile,
    settings: print::Settings,
    threads: Threads<'_>,
) -> anyhow::Result<Printed> {
    let paths = plan.layers.iter().map(|planned| &planned.path);
    print_paths(part, paths, profile, settings, threads)
}

/// Writes one path per layer with cells as G-code, and checks the text.
pub fn print_paths<'a>(
    part: &'a Part,
    paths: impl Iterator<Item = &'a beadwork_grid::Path>,
    profile: &Profile,
    settings: print::Settings,
    threads: Threads<'_>,
) -> anyhow::Result<Printed> {
    let layers = printed_layers(&part.layers, paths);
    let frame = &part.layers.frame;
    let (Print { program, totals, .. }, settings) =
        profile.print(&part.name, &layers, frame, settings)?;
    let text = program.emit();
    drop(program);
    let program = control::quiet(threads, |control| Program::parse(&text, control))??;
    let checked = control::quiet(Threads::One, |control| {
        print::check(&program, &layers, frame, &settings, control)
    })?;
    let checked = checked.context("G-code does not print the plan; this is a bug of beadwork")?;
    Ok(Printed { text, totals, checked, settings })
}
