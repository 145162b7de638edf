//! Typed commands, as plain data.

use thiserror::Error;

use crate::number::Number;

/// One command.
/// A command without a variant here is kept verbatim as [`Command::Other`].
///
/// `None` stands for a word that is not written: an axis that does not move, a speed that stays as
/// it was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// A straight move, `G0` or `G1`.
    Move(LinearMove),
    /// A move along an arc, `G2` or `G3`.
    /// Boxed because it is rarer and larger than the others.
    Arc(Box<Arc>),
    /// A pause, `G4`.
    /// If both times are given, printers use the seconds.
    Dwell {
        /// `S`, in s.
        seconds: Option<Number>,
        /// `P`, in ms.
        milliseconds: Option<Number>,
    },
    /// Moves the named axes to their end switches, `G28`; all axes if none is named.
    Home {
        /// Whether x is named.
        x: bool,
        /// Whether y is named.
        y: bool,
        /// Whether z is named.
        z: bool,
    },
    /// Gives the current position other coordinates without moving, `G92`; without any words, all
    /// coordinates become 0.
    SetPosition {
        /// New x in mm.
        x: Option<Number>,
        /// New y in mm.
        y: Option<Number>,
        /// New z in mm.
        z: Option<Number>,
        /// New length of extruded filament in mm.
        e: Option<Number>,
    },
    /// Absolute positioning, `G90`.
    AbsolutePositioning,
    /// Relative positioning, `G91`: coordinates are distances from the current position.
    RelativePositioning,
    /// Absolute extrusion, `M82`: lengths of filament count from the last `G92 E`.
    AbsoluteExtrusion,
    /// Relative extrusion, `M83`: lengths of filament are those of one move.
    RelativeExtrusion,
    /// Firmware retraction, `G10`: retracts filament by a length that the printer knows.
    Retract,
    /// Firmware unretraction, `G11`.
    Unretract,
    /// Selects a tool, `T0` to `T254`.
    /// `T255` unloads filament in some printers; the parser keeps it verbatim.
    Tool(u8),
    /// Sets the temperature of a nozzle, `M104`, or also waits for it, `M109`.
    NozzleTemperature {
        /// `S` or `R`, in degrees Celsius.
        celsius: Number,
        /// `T`: the tool whose nozzle is heated; the current tool if not written.
        tool: Option<u8>,
        /// What the printer waits for.
        wait: Wait,
    },
    /// Sets the temperature of the bed, `M140`, or also waits for it, `M190`.
    BedTemperature {
        /// `S`, in degrees Celsius.
        celsius: Number,
        /// Whether the printer waits.
        wait: bool,
    },
    /// Fan speed, 0 to 255, `M106`; `None` switches it off, `M107`.
    Fan(Option<Number>),
    /// Acceleration in mm/s², `M204`.
    /// Klipper uses `S`, or else the lower of `P` and `T`, for all moves; the trace applies each
    /// word to its own kind of move, as Marlin does.
    Acceleration {
        /// `P`: of printing moves.
        print: Option<Number>,
        /// `T`: of travel moves.
        travel: Option<Number>,
        /// `R`: of retraction and unretraction.
        retract: Option<Number>,
        /// `S`: of printing and travel moves.
        all: Option<Number>,
    },
    /// Klipper's `SET_VELOCITY_LIMIT` with no parameters but these; with others it is kept
    /// verbatim, and the trace uses only its `ACCEL`.
    VelocityLimit {
        /// `VELOCITY`: maximum speed in mm/s.
        velocity: Option<Number>,
        /// `ACCEL`: acceleration in mm/s².
        acceleration: Option<Number>,
        /// `SQUARE_CORNER_VELOCITY`: speed through a right angle in mm/s.
        square_corner: Option<Number>,
    },
    /// Jerk limits, `M205`.
    Jerk {
        /// `X`, in mm/s.
        x: Option<Number>,
        /// `Y`, in mm/s.
        y: Option<Number>,
        /// `Z`, in mm/s.
        z: Option<Number>,
        /// `E`, in mm/s.
        e: Option<Number>,
        /// `J`: junction deviation in mm.
        junction_deviation: Option<Number>,
    },
    /// The progress that the printer displays, `M73`.
    Progress {
        /// `P`: per cent done.
        percent: Option<Number>,
        /// `R`: remaining minutes.
        minutes: Option<Number>,
    },
    /// Any other command: macros, and codes without a variant here.
    Other(Verbatim),
}

/// What the printer waits for when it sets the temperature of a nozzle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wait {
    /// Nothing: it continues at once, `M104 S`.
    No,
    /// Until the nozzle has heated up, `M109 S`.
    /// If the nozzle is too hot, Marlin continues at once and Klipper waits until it has cooled.
    Heating,
    /// Until the nozzle has heated up or cooled down, `M109 R`, which Klipper does not support.
    HeatingOrCooling,
}

/// A straight move, `G0` or `G1`.
/// With relative positioning, coordinates are distances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearMove {
    /// Whether it is `G0`, which FDM printers treat like `G1`.
    pub rapid: bool,
    /// x in mm.
    pub x: Option<Number>,
    /// y in mm.
    pub y: Option<Number>,
    /// z in mm.
    pub z: Option<Number>,
    /// Filament in mm.
    pub e: Option<Number>,
    /// Feed rate in mm/min, for this move and those that follow.
    pub f: Option<Number>,
}

/// A move along a circular arc in the xy plane, `G2` or `G3`; a helix if z changes.
/// With relative positioning, coordinates are distances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arc {
    /// Whether it is `G2`.
    pub clockwise: bool,
    /// x of its end in mm.
    pub x: Option<Number>,
    /// y of its end in mm.
    pub y: Option<Number>,
    /// z of its end in mm.
    pub z: Option<Number>,
    /// x of the centre relative to the start, in mm.
    pub i: Option<Number>,
    /// y of the centre relative to the start, in mm.
    pub j: Option<Number>,
    /// Radius in mm, in place of the centre; negative for an arc of more than half a circle.
    pub r: Option<Number>,
    /// Filament in mm.
    pub e: Option<Number>,
    /// Feed rate in mm/min, for this move and those that follow.
    pub f: Option<Number>,
}

/// The text of a command that has no type of its own.
///
/// Invariant: parsing the text as a line returns the same text as a verbatim command.
/// So the text is trimmed and not empty, contains no semicolon or line break, and is not a command
/// that [`Command`] has a variant for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verbatim(Box<str>);

/// A text that cannot be a [`Verbatim`] command.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "'{0}' cannot be kept verbatim: it must be one trimmed command without a type or a comment"
)]
pub struct VerbatimError(pub String);

impl Verbatim {
    /// Wraps a text that the parser has found to satisfy the invariant.
    pub(crate) fn from_parsed(text: &str) -> Self {
        Self(text.into())
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}
