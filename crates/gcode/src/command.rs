//! Commands of G-code, as far as planning and checking a print needs them.

use thiserror::Error;

use crate::{Number, parse};

/// One command.
/// What is not typed here is kept word for word as [`Command::Other`].
///
/// `None` stands for a word that is not written: an axis that does not move, a speed that stays as
/// it was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// A straight move, `G0` or `G1`.
    Move(Move),
    /// A move along an arc, `G2` or `G3`.
    /// Boxed, for it is rarer and larger than all others.
    Arc(Box<Arc>),
    /// A pause, `G4`; if both are given, printers take the seconds.
    Dwell {
        /// `S`, in s.
        seconds: Option<Number>,
        /// `P`, in ms.
        milliseconds: Option<Number>,
    },
    /// To the end switches of these axes, `G28`; of all of them, if none is named.
    Home {
        /// Whether x is named.
        x: bool,
        /// Whether y is named.
        y: bool,
        /// Whether z is named.
        z: bool,
    },
    /// Calls the present place by other coordinates, `G92`; without any, all of them are 0.
    SetPosition {
        /// New x in mm.
        x: Option<Number>,
        /// New y in mm.
        y: Option<Number>,
        /// New z in mm.
        z: Option<Number>,
        /// New length of extruded filament, in mm.
        e: Option<Number>,
    },
    /// Coordinates are places, `G90`.
    Absolute,
    /// Coordinates are distances from the present place, `G91`.
    Relative,
    /// Lengths of filament count from the last `G92 E`, `M82`.
    AbsoluteExtrusion,
    /// Lengths of filament are those of one move, `M83`.
    RelativeExtrusion,
    /// The printer draws the filament back by a length of its own, `G10`.
    Retract,
    /// The printer undoes that, `G11`.
    Unretract,
    /// Selects a tool, `T0` and so on, below 255: `T255` unloads in some printers, and is kept word
    /// for word when read.
    Tool(u8),
    /// Heats the nozzle, `M104`, or waits until it is hot, `M109`.
    NozzleTemperature {
        /// `S` or `R`, in degrees Celsius.
        celsius: Number,
        /// `T`: of which tool; the present one, if none is named.
        tool: Option<u8>,
        /// What to wait for.
        wait: Wait,
    },
    /// Heats the bed, `M140`, or waits until it is hot, `M190`.
    BedTemperature {
        /// `S`, in degrees Celsius.
        celsius: Number,
        /// Whether to wait.
        wait: bool,
    },
    /// Speed of the fan, 0 to 255, `M106`; off, `M107`.
    Fan(Option<Number>),
    /// Acceleration in mm/s², `M204`.
    /// Klipper takes `S`, or else the lesser of `P` and `T`, for all moves; the trace takes each
    /// for its own.
    Acceleration {
        /// `P`: of printing moves.
        print: Option<Number>,
        /// `T`: of travel.
        travel: Option<Number>,
        /// `R`: of filament that is drawn back or pushed out in place.
        retract: Option<Number>,
        /// `S`: of printing moves and travel.
        all: Option<Number>,
    },
    /// Klipper's `SET_VELOCITY_LIMIT`, if it has no other words than these; else it is kept word
    /// for word, and only its `ACCEL` counts.
    VelocityLimit {
        /// `VELOCITY`: greatest speed, in mm/s.
        velocity: Option<Number>,
        /// `ACCEL`, in mm/s².
        acceleration: Option<Number>,
        /// `SQUARE_CORNER_VELOCITY`: speed through a right angle, in mm/s.
        square_corner: Option<Number>,
    },
    /// How suddenly the speed may change, `M205`.
    Jerk {
        /// `X`, in mm/s.
        x: Option<Number>,
        /// `Y`, in mm/s.
        y: Option<Number>,
        /// `Z`, in mm/s.
        z: Option<Number>,
        /// `E`, in mm/s.
        e: Option<Number>,
        /// `J`: how far corners may be cut to reckon their speed, in mm.
        junction_deviation: Option<Number>,
    },
    /// What the printer shows of the progress, `M73`.
    Progress {
        /// `P`: per cent done.
        percent: Option<Number>,
        /// `R`: minutes left.
        minutes: Option<Number>,
    },
    /// Anything else: macros, and codes that are not typed here.
    Other(Verbatim),
}

/// What the printer waits for when a nozzle gets another temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wait {
    /// Nothing: it goes on at once, `M104 S`.
    No,
    /// Until the nozzle is as hot, `M109 S`: Marlin goes on at once if it is hotter, Klipper waits
    /// then too.
    Heating,
    /// Until the nozzle is as hot or as cool, `M109 R`, which Marlin knows and Klipper does not.
    Both,
}

/// A straight move, `G0` or `G1`.
/// Coordinates in mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Move {
    /// Whether it is `G0`, which printers of plastic treat like `G1`.
    pub rapid: bool,
    /// x in mm.
    pub x: Option<Number>,
    /// y in mm.
    pub y: Option<Number>,
    /// z in mm.
    pub z: Option<Number>,
    /// Filament in mm.
    pub e: Option<Number>,
    /// Speed in mm/min, from this move on.
    pub f: Option<Number>,
}

/// A move along an arc of a circle in the plane of x and y.
/// Coordinates in mm.
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
    /// x of the centre, seen from the start, in mm.
    pub i: Option<Number>,
    /// y of the centre, seen from the start, in mm.
    pub j: Option<Number>,
    /// Radius in mm, instead of the centre; less than 0 for the longer way round.
    pub r: Option<Number>,
    /// Filament in mm.
    pub e: Option<Number>,
    /// Speed in mm/min, from this move on.
    pub f: Option<Number>,
}

/// The text of a command that is not typed.
///
/// Invariant: reading it as a line gives itself again.
/// So it is not blank, is trimmed, holds neither a semicolon nor a line break, and is no command
/// that [`Command`] has a type for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verbatim(Box<str>);

/// Why a text can't be a [`Verbatim`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is not a command that is kept word for word")]
pub struct VerbatimError(pub String);

impl Verbatim {
    /// Checks the text.
    pub fn new(text: &str) -> Result<Self, VerbatimError> {
        let line = if text.contains('\n') { None } else { parse::line(text).ok() };
        match line.map(super::Line::into_parts) {
            Some((Some(Command::Other(verbatim)), None)) if *verbatim.0 == *text => Ok(verbatim),
            _ => Err(VerbatimError(text.to_owned())),
        }
    }

    /// For the parser, which has just found it to be so.
    pub(super) fn trusted(text: &str) -> Self {
        Self(text.into())
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Command {
    /// A command that is kept word for word.
    pub fn other(text: &str) -> Result<Self, VerbatimError> {
        Verbatim::new(text).map(Self::Other)
    }

    /// Appends the command as one line of text, without a line break.
    pub(super) fn push_to(&self, out: &mut String) {
        match *self {
            Self::Move(Move { rapid, x, y, z, e, f }) => {
                out.push_str(if rapid { "G0" } else { "G1" });
                push_words(out, [('X', x), ('Y', y), ('Z', z), ('E', e), ('F', f)]);
            }
            Self::Arc(ref arc) => {
                let Arc { clockwise, x, y, z, i, j, r, e, f } = **arc;
                out.push_str(if clockwise { "G2" } else { "G3" });
                let place = [('X', x), ('Y', y), ('Z', z), ('I', i), ('J', j), ('R', r)];
                push_words(out, place);
                push_words(out, [('E', e), ('F', f)]);
            }
            Self::Dwell { seconds, milliseconds } => {
                out.push_str("G4");
                push_words(out, [('S', seconds), ('P', milliseconds)]);
            }
            Self::Home { x, y, z } => {
                out.push_str("G28");
                for (word, _) in
                    [(" X", x), (" Y", y), (" Z", z)].into_iter().filter(|&(_, named)| named)
                {
                    out.push_str(word);
                }
            }
            Self::SetPosition { x, y, z, e } => {
                out.push_str("G92");
                push_words(out, [('X', x), ('Y', y), ('Z', z), ('E', e)]);
            }
            Self::Absolute => out.push_str("G90"),
            Self::Relative => out.push_str("G91"),
            Self::AbsoluteExtrusion => out.push_str("M82"),
            Self::RelativeExtrusion => out.push_str("M83"),
            Self::Retract => out.push_str("G10"),
            Self::Unretract => out.push_str("G11"),
            Self::Tool(tool) => {
                out.push('T');
                push_tool(out, tool);
            }
            Self::NozzleTemperature { celsius, tool, wait } => {
                out.push_str(if wait == Wait::No { "M104" } else { "M109" });
                if let Some(tool) = tool {
                    out.push_str(" T");
                    push_tool(out, tool);
                }
                push_words(out, [(if wait == Wait::Both { 'R' } else { 'S' }, Some(celsius))]);
            }
            Self::BedTemperature { celsius, wait } => {
                out.push_str(if wait { "M190" } else { "M140" });
                push_words(out, [('S', Some(celsius))]);
            }
            Self::Fan(None) => out.push_str("M107"),
            Self::Fan(speed) => {
                out.push_str("M106");
                push_words(out, [('S', speed)]);
            }
            Self::Acceleration { print, travel, retract, all } => {
                out.push_str("M204");
                push_words(out, [('P', print), ('R', retract), ('T', travel), ('S', all)]);
            }
            Self::VelocityLimit { velocity, acceleration, square_corner } => {
                out.push_str(VELOCITY_LIMIT);
                let named = [
                    (VELOCITY, velocity),
                    (ACCELERATION, acceleration),
                    (SQUARE_CORNER_VELOCITY, square_corner),
                ];
                for (name, value) in named {
                    if let Some(value) = value {
                        out.extend([" ", name, "="]);
                        value.push_to(out);
                    }
                }
            }
            Self::Jerk { x, y, z, e, junction_deviation } => {
                out.push_str("M205");
                push_words(
                    out,
                    [('X', x), ('Y', y), ('Z', z), ('E', e), ('J', junction_deviation)],
                );
            }
            Self::Progress { percent, minutes } => {
                out.push_str("M73");
                push_words(out, [('P', percent), ('R', minutes)]);
            }
            Self::Other(ref text) => out.push_str(text.as_str()),
        }
    }
}

pub(super) const VELOCITY_LIMIT: &str = "SET_VELOCITY_LIMIT";
pub(super) const VELOCITY: &str = "VELOCITY";
pub(super) const ACCELERATION: &str = "ACCEL";
pub(super) const SQUARE_CORNER_VELOCITY: &str = "SQUARE_CORNER_VELOCITY";

fn push_words<const N: usize>(out: &mut String, words: [(char, Option<Number>); N]) {
    for (letter, value) in words {
        if let Some(value) = value {
            out.push(' ');
            out.push(letter);
            value.push_to(out);
        }
    }
}

fn push_tool(out: &mut String, tool: u8) {
    Number::whole(i32::from(tool)).push_to(out);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_word_for_word() {
        for text in [
            "M117 Hello (world)",
            "START_PRINT BED=80",
            "M106 P1 S255",
            "G29.1",
            "T?",
            "T1000",
            "é",
            "M204 X5",
            "T255",
            "SET_VELOCITY_LIMIT ACCEL=5 MINIMUM_CRUISE_RATIO=0.5",
        ] {
            assert_eq!(Verbatim::new(text).unwrap().as_str(), text);
        }
        for text in [
            "", " ", " M117", "M117 ", "M84;off", "M84\n", "G1 X1", "g1x1", "N5 M84", "(M84)",
            "G1 Xa", "M84\r",
        ] {
            assert_eq!(Verbatim::new(text), Err(VerbatimError(text.to_owned())), "{text}");
        }
    }
}
