//! What a program makes the printer do, as plain data.

use std::fmt;

use beadwork_base::Interrupted;
use thiserror::Error;

use crate::code::CodeName;
use crate::command::Wait;
use crate::feature::Feature;
use crate::words::ParseFault;

/// A straight move of the nozzle, or extrusion or retraction while the nozzle stands still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Position at the start: x, y, z in mm.
    pub from_mm: [f64; 3],
    /// Position at the end: x, y, z in mm.
    pub to_mm: [f64; 3],
    /// Extruded filament in mm; negative for a retraction.
    pub extruded_mm: f64,
    /// Requested speed in mm/s, more than 0: of the nozzle, or of the filament if the nozzle stands
    /// still.
    pub feed_mm_s: f64,
    /// Acceleration in mm/s², if the program has set one for this kind of move.
    pub acceleration_mm_s2: Option<f64>,
    /// The tool.
    pub tool: u8,
    /// What is printed, according to the last comment that names a feature.
    pub feature: Feature,
    /// Number of the layer, from 0 at the bed, according to the last layer comment; `None` before
    /// the first layer and in a raft.
    pub layer: Option<u32>,
    /// Number of the line, from 1.
    pub line: usize,
}

impl Motion {
    /// The distance that the nozzle moves, in mm.
    pub fn length_mm(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.to_mm[axis] - self.from_mm[axis]);
        (x * x + y * y + z * z).sqrt()
    }

    /// Whether this is an extrusion move: the nozzle moves and extrudes.
    pub fn is_extrusion(&self) -> bool {
        self.extruded_mm > 0.0 && self.length_mm() > 0.0
    }
}

/// A heater of the printer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Heater {
    /// The nozzle of a tool; in a printer with one nozzle, that nozzle while the tool is selected.
    Nozzle(u8),
    /// The bed.
    Bed,
}

impl fmt::Display for Heater {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nozzle(tool) => write!(f, "nozzle of tool {tool}"),
            Self::Bed => f.write_str("bed"),
        }
    }
}

/// Something that the printer does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The nozzle or the filament moves.
    Motion(Motion),
    /// Another tool is selected.
    ToolChange {
        /// The previous tool; `None` if no tool was selected and nothing was extruded before.
        from: Option<u8>,
        /// The new tool.
        to: u8,
        /// Number of the line, from 1.
        line: usize,
    },
    /// A heater is set to a temperature.
    Heat {
        /// The heater.
        heater: Heater,
        /// The temperature in degrees Celsius.
        celsius: f64,
        /// What the printer waits for; [`Wait::Heating`] if it waits for the bed.
        wait: Wait,
        /// Number of the line, from 1.
        line: usize,
    },
    /// All heaters are switched off, Klipper's `TURN_OFF_HEATERS`.
    HeatersOff {
        /// Number of the line, from 1.
        line: usize,
    },
    /// The motors are switched off, `M84` or `M18`; from then on the position of the nozzle is
    /// uncertain.
    MotorsOff {
        /// Number of the line, from 1.
        line: usize,
    },
    /// The printer stands still, `G4`.
    Pause {
        /// Duration in s, at least 0.
        seconds: f64,
        /// Number of the line, from 1.
        line: usize,
    },
}

/// Why a program cannot be traced.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TraceError {
    /// The program switches to inches.
    #[error("line {line}: inches (G20) are not supported")]
    Inches {
        /// Number of the line, from 1.
        line: usize,
    },
    /// The program switches to arcs outside the xy plane.
    #[error("line {line}: arcs outside the xy plane (G18, G19) are not supported")]
    Plane {
        /// Number of the line, from 1.
        line: usize,
    },
    /// The program uses a command that changes motions in a way that is not supported.
    #[error("line {line}: {code} is not supported: {reason}")]
    Unsupported {
        /// Number of the line, from 1.
        line: usize,
        /// The command.
        code: CodeName,
        /// What is not supported.
        reason: &'static str,
    },
    /// A command that changes what motions mean follows a motion on the same line.
    #[error(
        "line {line}: a motion stands before another command on the same line, and firmware \
         differs in which comes first; write them on lines of their own"
    )]
    Order {
        /// Number of the line, from 1.
        line: usize,
    },
    /// A line that begins with a slash, which CNC controls skip on request.
    #[error("line {line}: begins with a slash; remove the line, or the slash")]
    Optional {
        /// Number of the line, from 1.
        line: usize,
    },
    /// Words without a command, and no motion command before them that they could repeat.
    #[error("line {line}: words without a command, and no motion command before them")]
    NoCommand {
        /// Number of the line, from 1.
        line: usize,
    },
    /// A word of a command with no type is malformed.
    #[error("line {line}: part of the line {fault}")]
    Word {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with the word.
        fault: ParseFault,
    },
    /// A feed rate is not positive.
    #[error("line {line}: feed rate is {feed_mm_min} mm/min, must be more than 0")]
    Feed {
        /// Number of the line, from 1.
        line: usize,
        /// The feed rate in mm/min.
        feed_mm_min: f64,
    },
    /// An acceleration is not positive.
    #[error("line {line}: acceleration is {acceleration_mm_s2} mm/s², must be more than 0")]
    Acceleration {
        /// Number of the line, from 1.
        line: usize,
        /// The acceleration in mm/s².
        acceleration_mm_s2: f64,
    },
    /// An arc has neither centre nor radius, its centre coincides with one of its ends, or its
    /// radius is too small to reach its end.
    #[error("line {line}: arc has no centre (I, J) or radius (R) that fits its ends")]
    Arc {
        /// Number of the line, from 1.
        line: usize,
    },
    /// The caller ended the call early.
    /// The iterators never return this.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
