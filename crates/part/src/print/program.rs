//! Writes planned layers, of cells or of beads, as a G-code program.

use beadwork_base::{Control, Interrupted};
use beadwork_gcode::{Filament, Program, Totals, TraceError};
use thiserror::Error;

use super::header::{Title, header};
use super::layer::Layer;
use super::prime_tower::PrimeTowerPlan;
use super::settings::{Settings, Tool};
use super::settings_error::SettingsError;
use super::toolpath::{Toolpath, rounded};
use super::validate::{validate_beads, validate_layers};
use super::writer::Writer;
use crate::{BeadLayer, Frame};

/// A program and its totals.
#[derive(Clone, Debug, PartialEq)]
pub struct Print {
    /// The program.
    pub program: Program,
    /// Printing time, filament, lengths and counts.
    pub totals: Totals,
    /// Number of beads that were left out because they are too short for the decimals of a file:
    /// all their moves end where the bead begins, after rounding to 0.001 mm.
    pub dropped_beads: usize,
}

/// Why layers could not be written as a program.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PrintError {
    /// The layers, the frame and the settings are invalid or do not fit together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The call was cancelled or ran out of time.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl Print {
    /// Writes layers of cells, which must be numbered from 0 without a gap, as a program.
    ///
    /// The program assumes that the filament of every tool is retracted by [`Process::retract_mm`]
    /// at the start, and leaves it so at the end.
    /// Progress counts layers.
    /// Takes time linear in the cells of all layers.
    ///
    /// [`Process::retract_mm`]: super::Process::retract_mm
    pub fn new(
        title: Title<'_>,
        layers: &[Layer<'_>],
        frame: &Frame,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Self, PrintError> {
        validate_layers(layers, frame, settings)?;
        let job = Job {
            tools: layers.iter().map(|layer| tools_of(layer.runs().map(|run| run.zone))).collect(),
            toolpaths: &|number| {
                let layer = &layers[number];
                let column_and_row = |cell| layer.column_and_row(cell);
                let toolpath =
                    |run| Toolpath::of_run(&run, column_and_row, number, frame, settings);
                layer.runs().filter_map(toolpath).collect()
            },
            lifts: layers.iter().map(|layer| layer.path.pieces() as usize - 1).sum(),
            dropped_beads: 0,
        };
        job.write(title, frame, settings, control)
    }

    /// Writes layers of beads, which must be numbered from 0 without a gap, as a program.
    ///
    /// Of the frame, only the height of a layer counts, and the width of a cell: it is the width of
    /// the beads of the prime tower, and of no bead of the part.
    ///
    /// A move extrudes its length times the cross-section of its width and the height of the layer.
    /// Moves that are too short for the decimals of a file (positions of 0.001 mm, and 0.00002 mm
    /// of filament) are merged with the next move of their bead, or with the one before if there is
    /// none, so that no filament is lost.
    /// Beads of such moves only are left out and counted.
    ///
    /// The program begins and ends as that of [`Print::new`].
    /// Progress counts layers.
    /// Takes time linear in the moves.
    pub fn of_beads(
        title: Title<'_>,
        layers: &[BeadLayer],
        frame: &Frame,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Self, PrintError> {
        validate_beads(layers, frame, settings)?;
        let toolpaths = |number: usize| {
            let beads = layers[number].beads.iter();
            beads.filter_map(|bead| Toolpath::of_bead(bead, number, frame, settings)).collect()
        };
        let mut job = Job { tools: Vec::new(), toolpaths: &toolpaths, lifts: 0, dropped_beads: 0 };
        for layer in layers {
            control.check()?;
            let beads: Vec<_> = toolpaths(layer.number);
            if beads.is_empty() {
                return Err(SettingsError::NoBeads { layer: layer.number }.into());
            }
            job.dropped_beads += layer.beads.len() - beads.len();
            let is_lift = |pair: &&[Toolpath]| {
                pair[0].tool == pair[1].tool
                    && rounded(pair[0].end_mm()) != rounded(pair[1].start_mm)
            };
            job.lifts += beads.windows(2).filter(is_lift).count();
            job.tools.push(tools_of(beads.iter().map(|bead| bead.tool)));
        }
        job.write(title, frame, settings, control)
    }
}

/// What is to be printed.
struct Job<'a> {
    /// For each layer the tools in printing order, consecutive ones different.
    tools: Vec<Vec<u8>>,
    /// Returns the toolpaths of a layer; a function, because those of all layers would need much
    /// memory.
    toolpaths: &'a dyn Fn(usize) -> Vec<Toolpath>,
    lifts: usize,
    dropped_beads: usize,
}

impl Job<'_> {
    fn write(
        &self,
        title: Title<'_>,
        frame: &Frame,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Print, PrintError> {
        let layers = self.tools.len();
        let tower = PrimeTowerPlan::new(&self.tools, frame, settings)?;
        let first_tool = self.tools[0][0];
        let mut writer = Writer::new(frame, settings, first_tool, self.used_tools(settings));
        writer.start();
        for number in 0..layers {
            control.check()?;
            let tower = tower.as_ref().filter(|tower| number <= tower.last_layer);
            writer.layer(number, &(self.toolpaths)(number), tower);
            control.report(number + 1, layers);
        }
        writer.end();
        let body = Program { lines: writer.into_lines() };
        let filaments: Vec<Filament> = settings.tools.iter().map(Tool::filament).collect();
        let control = control.without_progress();
        let totals = Totals::measure(&body, settings.printer.limits(), &filaments, &control)
            .map_err(|error| match error {
                TraceError::Interrupted(interrupted) => interrupted,
                _ => unreachable!("valid settings give speeds above 0, and no arcs are written"),
            })?;
        let totals = Totals { layers, lifts: self.lifts, ..totals };
        let mut lines = header(title, frame, settings, &totals);
        lines.extend(body.lines);
        Ok(Print { program: Program { lines }, totals, dropped_beads: self.dropped_beads })
    }

    /// The tools that print anything, in ascending order.
    fn used_tools(&self, settings: &Settings) -> Vec<u8> {
        let prints = |tool: &u8| self.tools.iter().any(|tools| tools.contains(tool));
        (0..settings.tools.len()).map(|tool| tool as u8).filter(prints).collect()
    }
}

/// The tools of consecutive toolpaths, where consecutive ones are different.
fn tools_of(toolpaths: impl Iterator<Item = u8>) -> Vec<u8> {
    let mut tools: Vec<u8> = toolpaths.collect();
    tools.dedup();
    tools
}

#[cfg(test)]
mod bead_tests;
#[cfg(test)]
mod tests;
