//! Errors of the check of a print.

use std::fmt;

use beadwork_base::Interrupted;
use beadwork_gcode::{Feature, Heater, TraceError};
use thiserror::Error;

use crate::print::settings_error::SettingsError;

/// A cell of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellPosition {
    /// Number of the layer.
    pub layer: usize,
    /// Column of the cell.
    pub x: u32,
    /// Row of the cell.
    pub y: u32,
}

impl fmt::Display for CellPosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "layer {}, cell ({}, {})", self.layer, self.x, self.y)
    }
}

/// Why a program does not print its layers; lines are numbered from 1.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CheckError {
    /// A command of the program is invalid.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The layers, the frame and the settings are invalid or do not fit together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The check was cancelled or ran out of time.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A motion extrudes at a height that is not the top of a layer.
    #[error("line {line}: extrudes at z = {z_mm} mm, which is not the top of a layer")]
    Height {
        /// Number of the line.
        line: usize,
        /// The height in mm.
        z_mm: f64,
    },
    /// A motion changes its height while it extrudes.
    #[error("line {line}: z changes from {from_mm} to {to_mm} mm while extruding")]
    Slope {
        /// Number of the line.
        line: usize,
        /// z at the start in mm.
        from_mm: f64,
        /// z at the end in mm.
        to_mm: f64,
    },
    /// A motion extrudes neither through the centres of a row nor through those of a column.
    #[error(
        "line {line}, layer {layer}: extrudes from ({}, {}) to ({}, {}) mm, off the cell centres",
        from_mm[0], from_mm[1], to_mm[0], to_mm[1]
    )]
    OffCentre {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
        /// x and y at the start in mm.
        from_mm: [f64; 2],
        /// x and y at the end in mm.
        to_mm: [f64; 2],
    },
    /// A motion extrudes outside the region of its layer.
    #[error("line {line}: {position} is printed but does not belong to the part")]
    OutsidePart {
        /// Number of the line.
        line: usize,
        /// The cell.
        position: CellPosition,
    },
    /// A cell is printed with the tool of another zone.
    #[error("line {line}: {position} is printed with tool {got} instead of {expected}")]
    WrongTool {
        /// Number of the line.
        line: usize,
        /// The cell.
        position: CellPosition,
        /// The tool of its zone.
        expected: u8,
        /// The tool that prints it.
        got: u8,
    },
    /// A cell is printed twice.
    #[error("line {line}: {position} is printed twice")]
    PrintedTwice {
        /// Number of the line.
        line: usize,
        /// The cell.
        position: CellPosition,
    },
    /// The beads do not follow the path.
    #[error(
        "line {line}: {position} is printed where the path has cell ({}, {})",
        expected[0], expected[1]
    )]
    OffPath {
        /// Number of the line.
        line: usize,
        /// The cell that is printed; the expected cell if it is printed in another direction.
        position: CellPosition,
        /// Column and row of the next cell of the path.
        expected: [u32; 2],
    },
    /// A cell is not printed, or only half of it.
    #[error("{position} is incomplete: the printed share is {share}")]
    Missing {
        /// The cell.
        position: CellPosition,
        /// Printed share of the cell: 0 or 0.5.
        share: f64,
    },
    /// A motion extrudes elsewhere than the next move of the beads.
    #[error(
        "line {line}, layer {layer}: extrudes from ({}, {}) to ({}, {}) mm \
         where bead {bead} runs from ({}, {}) to ({}, {}) mm",
        got_mm[0][0], got_mm[0][1], got_mm[1][0], got_mm[1][1],
        expected_mm[0][0], expected_mm[0][1], expected_mm[1][0], expected_mm[1][1]
    )]
    OffBead {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// x and y of both ends of the move of the bead in mm.
        expected_mm: [[f64; 2]; 2],
        /// x and y of both ends of the motion in mm.
        got_mm: [[f64; 2]; 2],
    },
    /// A motion extrudes after the last bead of a layer.
    #[error(
        "line {line}, layer {layer}: extrudes from ({}, {}) to ({}, {}) mm after the last bead",
        from_mm[0], from_mm[1], to_mm[0], to_mm[1]
    )]
    AfterBeads {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
        /// x and y at the start in mm.
        from_mm: [f64; 2],
        /// x and y at the end in mm.
        to_mm: [f64; 2],
    },
    /// A bead is printed with another tool than its own.
    #[error(
        "line {line}, layer {layer}: bead {bead} is printed with tool {got} instead of {expected}"
    )]
    BeadTool {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// The tool of the bead.
        expected: u8,
        /// The tool that prints it.
        got: u8,
    },
    /// A move of a bead is marked as another feature.
    #[error(
        "line {line}, layer {layer}: bead {bead} is marked as {} instead of {}",
        got.name(), expected.name()
    )]
    BeadFeature {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// The feature of the move, as it is marked in a file.
        expected: Feature,
        /// The feature of the last comment.
        got: Feature,
    },
    /// A bead is not printed, or not to its end.
    #[error(
        "layer {layer}, bead {bead} is incomplete: the move to ({}, {}) mm is missing",
        to_mm[0], to_mm[1]
    )]
    MissingBead {
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// x and y of the end of the missing move in mm.
        to_mm: [f64; 2],
    },
    /// A bead reaches beyond the outline of its material.
    #[error(
        "line {line}, layer {layer}: bead {bead} is {width_mm} mm wide \
         from ({}, {}) to ({}, {}) mm, beyond the outline of tool {tool}",
        from_mm[0], from_mm[1], to_mm[0], to_mm[1]
    )]
    OutsideOutline {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// The tool.
        tool: u8,
        /// Width of the bead in mm.
        width_mm: f64,
        /// x and y at the start in mm.
        from_mm: [f64; 2],
        /// x and y at the end in mm.
        to_mm: [f64; 2],
    },
    /// There are not as many layers of outlines as layers of beads.
    #[error("outlines have {got} layers: expected {expected}, one for each layer of beads")]
    OutlineLayers {
        /// Number of layers of beads.
        expected: usize,
        /// Number of layers of outlines.
        got: usize,
    },
    /// A material has two outlines in a layer.
    #[error("layer {layer}: tool {tool} has two outlines: unite them")]
    TwoOutlines {
        /// Number of the layer.
        layer: usize,
        /// The tool.
        tool: u8,
    },
    /// The beads of a material in a layer, or in all layers, fill too little or too much of the
    /// outlines.
    #[error(
        "{}tool {tool} extrudes {extruded_mm2} mm² into outlines of {outline_mm2} mm²: \
         the ratio must be from {} to {}",
        layer.map_or(String::new(), |layer| format!("layer {layer}: ")), limits[0], limits[1]
    )]
    Fill {
        /// Number of the layer; `None` for all layers.
        layer: Option<usize>,
        /// The tool.
        tool: u8,
        /// Sum of length times width of the beads in mm².
        extruded_mm2: f64,
        /// Area of the outlines in mm².
        outline_mm2: f64,
        /// Minimum and maximum ratio.
        limits: [f64; 2],
    },
    /// Filament is retracted during a move that does not lead back along the bead just printed, or
    /// too far.
    #[error(
        "line {line}: retracts on the way to ({}, {}) mm, \
         off the bead just printed or beyond process.wipe_mm",
        to_mm[0], to_mm[1]
    )]
    Wipe {
        /// Number of the line.
        line: usize,
        /// x and y at the end in mm.
        to_mm: [f64; 2],
    },
    /// A motion extrudes too much or too little.
    #[error("line {line}: extrudes {got_mm3} mm³ instead of {expected_mm3}")]
    Volume {
        /// Number of the line.
        line: usize,
        /// Volume of a bead of this length, in mm³.
        expected_mm3: f64,
        /// Extruded volume in mm³.
        got_mm3: f64,
    },
    /// A bead begins with retracted filament, more filament is unretracted than was retracted, or a
    /// tool is deselected without the retraction of the settings.
    #[error("line {line}: the filament of tool {tool} is retracted by {retracted_mm} mm")]
    Retraction {
        /// Number of the line.
        line: usize,
        /// The tool.
        tool: u8,
        /// Retracted length in mm; less than 0 if too much was unretracted.
        retracted_mm: f64,
    },
    /// The part continues before enough is purged.
    #[error(
        "line {line}: {got_mm3} mm³ are purged from tool {from} to {to} instead of {expected_mm3}"
    )]
    Purge {
        /// Number of the line that continues the part.
        line: usize,
        /// The tool before the change.
        from: u8,
        /// The tool after the change.
        to: u8,
        /// Purge volume of the settings in mm³.
        expected_mm3: f64,
        /// Purged volume in mm³.
        got_mm3: f64,
    },
    /// The prime tower is printed outside the position of the settings, or they define no tower.
    #[error("line {line}: the prime tower is printed outside the position of the settings")]
    PrimeTowerOutside {
        /// Number of the line.
        line: usize,
    },
    /// The prime tower is printed in the air.
    #[error("line {line}: the prime tower of layer {layer} has nothing below to rest on")]
    PrimeTowerInAir {
        /// Number of the line.
        line: usize,
        /// Number of the layer.
        layer: usize,
    },
    /// The nozzle moves below the top of what was printed.
    #[error(
        "line {line}: the nozzle is at z = {z_mm} mm, below the top of the print at {top_mm} mm"
    )]
    NozzleTooLow {
        /// Number of the line.
        line: usize,
        /// Minimum z of the motion in mm.
        z_mm: f64,
        /// Top of the highest layer begun, in mm.
        top_mm: f64,
    },
    /// The nozzle leaves the build volume.
    #[error(
        "line {line}: the nozzle moves to ({}, {}, {}) mm, beyond the bed",
        position_mm[0], position_mm[1], position_mm[2]
    )]
    OffBed {
        /// Number of the line.
        line: usize,
        /// x, y and z at the end of the motion in mm.
        position_mm: [f64; 3],
    },
    /// A motion extrudes faster than the settings allow.
    #[error("line {line}: extrudes at {got_mm_s} mm/s, the maximum is {max_mm_s}")]
    Speed {
        /// Number of the line.
        line: usize,
        /// Speed of the motion in mm/s.
        got_mm_s: f64,
        /// Speed of the settings in mm/s.
        max_mm_s: f64,
    },
    /// A motion extrudes while a heater is set to another temperature than that of the settings.
    #[error("line {line}: the {heater} is set to {got_c} °C instead of {expected_c}")]
    Temperature {
        /// Number of the line.
        line: usize,
        /// The heater.
        heater: Heater,
        /// Temperature of the settings in °C.
        expected_c: f64,
        /// Temperature of the program in °C.
        got_c: f64,
    },
    /// A motion extrudes although the program did not wait for a temperature.
    #[error("line {line}: the {heater} may not have reached its temperature")]
    NotWaited {
        /// Number of the line.
        line: usize,
        /// The heater.
        heater: Heater,
    },
    /// A motion extrudes although the motors are off.
    #[error("line {line}: extrudes after the motors were switched off")]
    MotorsOff {
        /// Number of the line.
        line: usize,
    },
    /// Marlin and Klipper would extrude different lengths of filament.
    #[error(
        "line {line}: Marlin and Klipper disagree whether this extrusion is absolute or relative"
    )]
    AmbiguousExtrusion {
        /// Number of the line.
        line: usize,
    },
    /// A tool has no settings.
    #[error("line {line}: unknown tool {tool}: the settings define {tools}")]
    UnknownTool {
        /// Number of the line.
        line: usize,
        /// The tool.
        tool: u8,
        /// Number of tools in the settings.
        tools: usize,
    },
}
