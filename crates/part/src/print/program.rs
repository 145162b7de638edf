//! Writes planned layers as a G-code program.

use beadwork_base::{Control, Interrupted};
use beadwork_gcode::{Filament, Program, Totals, TraceError};
use thiserror::Error;

use super::header::{Title, header};
use super::layer::Layer;
use super::prime_tower::PrimeTowerPlan;
use super::settings::{Settings, Tool};
use super::settings_error::SettingsError;
use super::validate::validate;
use super::writer::Writer;
use crate::Frame;

/// A program and its totals.
#[derive(Clone, Debug, PartialEq)]
pub struct Print {
    /// The program.
    pub program: Program,
    /// Printing time, filament, lengths and counts.
    pub totals: Totals,
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
    /// Writes layers, which must be numbered from 0 without a gap, as a program.
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
        validate(layers, frame, settings)?;
        let tower = PrimeTowerPlan::new(layers, frame, settings)?;
        let first_tool = layers[0].zones.id(layers[0].path.order()[0]);
        let mut writer = Writer::new(frame, settings, first_tool, used_tools(layers, settings));
        writer.start();
        for layer in layers {
            control.check()?;
            writer.layer(layer, tower.as_ref().filter(|tower| layer.number <= tower.last_layer));
            control.report(layer.number + 1, layers.len());
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
        let lifts = layers.iter().map(|layer| layer.path.pieces() as usize - 1).sum();
        let totals = Totals { layers: layers.len(), lifts, ..totals };
        let mut lines = header(title, frame, settings, &totals);
        lines.extend(body.lines);
        Ok(Self { program: Program { lines }, totals })
    }
}

/// The tools that print anything, in ascending order.
fn used_tools(layers: &[Layer<'_>], settings: &Settings) -> Vec<u8> {
    let prints = |tool: &u8| layers.iter().any(|layer| layer.zones.ids().contains(tool));
    (0..settings.tools.len()).map(|tool| tool as u8).filter(prints).collect()
}

#[cfg(test)]
mod tests;
