//! What can be wrong with a print.

use beadwork_base::Interrupted;
use beadwork_gcode::{Heater, TraceError};
use thiserror::Error;

use super::CellPosition;
use crate::print::SettingsError;

/// What is wrong with a print; lines are numbered from 1.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CheckError {
    /// The program makes no sense.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The layers, the frame and the settings don't belong together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The check was cancelled or ran out of time.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// It extrudes at a height where no layer has its top.
    #[error("line {line}: extrudes at a height of {z_mm} mm, where no layer is")]
    Height {
        /// Number of the line.
        line: usize,
        /// The height, in mm.
        z_mm: f64,
    },
    /// It extrudes while it rises or sinks.
    #[error("line {line}: extrudes from {from_mm} to {to_mm} mm of height")]
    Slope {
        /// Number of the line.
        line: usize,
        /// z at the beginning, in mm.
        from_mm: f64,
        /// z at the end, in mm.
        to_mm: f64,
    },
    /// It extrudes neither along the middles of a row nor of a column.
    #[error("line {line}, layer {layer}: extrudes from ({}, {}) to ({}, {}) mm, off the middles of the cells",
        from_mm[0], from_mm[1], to_mm[0], to_mm[1])]
    OffCentre {
        /// Number of the line.
        line: usize,
        /// The layer.
        layer: usize,
        /// x and y at the beginning, in mm.
        from_mm: [f64; 2],
        /// x and y at the end, in mm.
        to_mm: [f64; 2],
    },
    /// It extrudes outside the region.
    #[error("line {line}: {place} does not belong to the part")]
    Outside {
        /// Number of the line.
        line: usize,
        /// The cell.
        place: CellPosition,
    },
    /// A cell is printed with the tool of another zone.
    #[error("line {line}: {place} is printed with tool {got} instead of {expected}")]
    WrongTool {
        /// Number of the line.
        line: usize,
        /// The cell.
        place: CellPosition,
        /// Its zone.
        expected: u8,
        /// The tool.
        got: u8,
    },
    /// A cell is printed twice.
    #[error("line {line}: {place} is printed again")]
    PrintedTwice {
        /// Number of the line.
        line: usize,
        /// The cell.
        place: CellPosition,
    },
    /// The beads don't follow the path.
    #[error("line {line}: the head comes to {place} where the path has it in cell ({}, {})", expected[0], expected[1])]
    OffPath {
        /// Number of the line.
        line: usize,
        /// The cell that is printed; the expected one, if it is printed in another direction.
        place: CellPosition,
        /// Column and row of the cell that is next on the path.
        expected: [u32; 2],
    },
    /// A cell is not printed, or not wholly.
    #[error("{place} is printed to {share} of it")]
    Missing {
        /// The cell.
        place: CellPosition,
        /// How much of it is, from 0 to 1.
        share: f64,
    },
    /// A motion extrudes too much or too little.
    #[error("line {line}: extrudes {got_mm3} mm³ where the cells take {expected_mm3}")]
    Volume {
        /// Number of the line.
        line: usize,
        /// What the cells take, in mm³.
        expected_mm3: f64,
        /// What is extruded, in mm³.
        got_mm3: f64,
    },
    /// A bead begins while the filament is drawn back, more is pushed out in place than was drawn
    /// back, or a tool is put aside with its filament not drawn back as the settings say.
    #[error("line {line}: the filament of tool {tool} is drawn back by {drawn_mm} mm")]
    Retraction {
        /// Number of the line.
        line: usize,
        /// The tool.
        tool: u8,
        /// By how much, in mm; less than 0 if too much was pushed out.
        drawn_mm: f64,
    },
    /// The part goes on before enough is purged.
    #[error("line {line}: {got_mm3} mm³ are purged from tool {from} to {to}, of {asked_mm3}")]
    Purge {
        /// Number of the line where the part goes on.
        line: usize,
        /// The tool before.
        from: u8,
        /// The tool after.
        to: u8,
        /// What is to be purged, in mm³.
        asked_mm3: f64,
        /// What is purged, in mm³.
        got_mm3: f64,
    },
    /// The tower is printed beside its place.
    #[error("line {line}: the tower is printed beyond the place that the settings give it")]
    PrimeTowerOutside {
        /// Number of the line.
        line: usize,
    },
    /// The tower is printed on nothing.
    #[error("line {line}: the tower of layer {layer} has none below to rest on")]
    PrimeTowerInAir {
        /// Number of the line.
        line: usize,
        /// The layer.
        layer: usize,
    },
    /// The head goes through what is printed.
    #[error(
        "line {line}: the head is at a height of {z_mm} mm, and the print has one of {top_mm} mm"
    )]
    NozzleTooLow {
        /// Number of the line.
        line: usize,
        /// The lower end of the motion, in mm.
        z_mm: f64,
        /// Top of the highest layer that is begun, in mm.
        top_mm: f64,
    },
    /// The head leaves the printer.
    #[error("line {line}: the head goes to ({}, {}, {}) mm, beyond the bed", place_mm[0], place_mm[1], place_mm[2])]
    OffBed {
        /// Number of the line.
        line: usize,
        /// x, y and z where the motion ends, in mm.
        place_mm: [f64; 3],
    },
    /// It extrudes faster than the settings say.
    #[error("line {line}: extrudes at {got_mm_s} mm/s, and at most {most_mm_s} are asked for")]
    Speed {
        /// Number of the line.
        line: usize,
        /// The speed, in mm/s.
        got_mm_s: f64,
        /// That of the settings, in mm/s.
        most_mm_s: f64,
    },
    /// It extrudes with another temperature than that of the settings.
    #[error("line {line}: the {heater} is set to {got_c} °C instead of {asked_c}")]
    Temperature {
        /// Number of the line that extrudes.
        line: usize,
        /// What has the temperature.
        heater: Heater,
        /// That of the settings, in degrees Celsius.
        asked_c: f64,
        /// That of the program, in degrees Celsius.
        got_c: f64,
    },
    /// It extrudes without having waited for the temperature.
    #[error("line {line}: the {heater} may not have its temperature yet")]
    NotWaited {
        /// Number of the line that extrudes.
        line: usize,
        /// What was not waited for.
        heater: Heater,
    },
    /// It extrudes although the motors have let go.
    #[error("line {line}: extrudes after the motors were switched off")]
    MotorsOff {
        /// Number of the line.
        line: usize,
    },
    /// Printers take the filament of a move for different lengths.
    #[error(
        "line {line}: whether filament counts from the start or from the last move is not the same for all printers"
    )]
    Ambiguous {
        /// Number of the line.
        line: usize,
    },
    /// A tool has no settings.
    #[error("line {line}: tool {tool} is not among the {tools} of the settings")]
    Tool {
        /// Number of the line.
        line: usize,
        /// The tool.
        tool: u8,
        /// How many tools there are.
        tools: usize,
    },
}
