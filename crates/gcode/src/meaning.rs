//! What a verbatim command means to the trace.
//!
//! The commands of Marlin, Klipper, RepRapFirmware and NIST RS274/NGC are sorted into four groups:
//! those that the trace follows; those that change motions in a way that it cannot follow, which
//! are refused; those that change neither motions nor times nor temperatures; and all others, which
//! [`Program::unknown_commands`](crate::Program::unknown_commands) lists.

use crate::code::Code;
use crate::command::{Command, Wait};
use crate::event::Heater;
use crate::number::Number;
use crate::parse::{Strictness, to_u8, typed};
use crate::words::{Fault, ParenthesisComments, ParseFault, Words, verbatim_acceleration};

/// What a command does.
#[derive(Debug)]
pub(crate) enum Meaning {
    /// Nothing that a trace shows, such as a message or a fan speed.
    Nothing,
    /// Something that could matter, but which only the printer knows.
    Unknown,
    /// What the typed command does.
    Typed(Command),
    /// Sets a heater; `None` stands for the nozzle of the current tool.
    Heat { heater: Option<Heater>, celsius: Number, wait: Wait },
    /// Switches all heaters off.
    HeatersOff,
    /// Switches the motors off.
    MotorsOff,
    /// Sets the speed of all motions, in per cent of the programmed one.
    Speed(Number),
    /// Sets the acceleration of all motions, in mm/s².
    Acceleration(Number),
    /// Ends the coordinates of `G92`.
    ClearOffsets,
    /// Uses the printer's coordinates on this line.
    MachineCoordinates,
    /// Ends the motion that words without a code repeat.
    EndMotion,
    /// Inches.
    Inches,
    /// Arcs outside the xy plane.
    Plane,
    /// Changes motions in a way that is not supported, for this reason.
    Refused(&'static str),
}

use Meaning::{Nothing, Refused, Unknown};

/// G-codes that choose what is the default here, or that level the bed.
const HARMLESS_G: [u32; 28] = [
    8, 15, 17, 21, 29, 30, 32, 34, 35, 36, 40, 49, 50, 51, 52, 54, 64, 68, 69, 71, 76, 77, 80, 81,
    94, 97, 98, 99,
];

/// M-codes that only set up or query the printer.
/// Fans, display, lights, sounds, sensors, calibration, files, settings in its memory.
const HARMLESS_M: [u32; 107] = [
    5, 7, 8, 9, 17, 20, 21, 22, 27, 31, 42, 70, 73, 74, 75, 76, 77, 78, 80, 82, 83, 85, 92, 105,
    106, 107, 108, 110, 111, 113, 114, 115, 116, 117, 118, 119, 122, 123, 126, 127, 142, 143, 145,
    150, 154, 155, 207, 208, 211, 250, 256, 260, 261, 280, 300, 301, 302, 304, 305, 307, 308, 309,
    355, 401, 402, 403, 404, 405, 406, 407, 412, 413, 420, 421, 425, 500, 501, 502, 503, 504, 524,
    532, 555, 569, 571, 572, 591, 592, 593, 851, 861, 862, 900, 906, 907, 911, 912, 913, 914, 915,
    960, 973, 975, 981, 991, 1002, 1006,
];

/// Klipper commands that only set up or query the printer, marks of the end of a file, and "no
/// tool".
const HARMLESS_NAMES: [&str; 24] = [
    "\u{1a}",
    "%",
    "BED_MESH_CALIBRATE",
    "BED_MESH_CLEAR",
    "BED_MESH_PROFILE",
    "CLEAR_PAUSE",
    "EXCLUDE_OBJECT_DEFINE",
    "EXCLUDE_OBJECT_END",
    "EXCLUDE_OBJECT_START",
    "QUAD_GANTRY_LEVEL",
    "RESPOND",
    "SET_DISPLAY_TEXT",
    "SET_FAN_SPEED",
    "SET_FILAMENT_SENSOR",
    "SET_IDLE_TIMEOUT",
    "SET_INPUT_SHAPER",
    "SET_LED",
    "SET_LED_TEMPLATE",
    "SET_PIN",
    "SET_PRESSURE_ADVANCE",
    "SET_PRINT_STATS_INFO",
    "T-1",
    "TEMPERATURE_WAIT",
    "Z_TILT_ADJUST",
];

/// The words of a code by letter.
fn words<'a>(code: &Code<'a>) -> Result<Words, Fault<'a>> {
    Words::read(code.words, "", "", false, &mut ParenthesisComments::default())
}

/// Whether one of these words has a number other than 0.
fn is_set(words: &Words, letters: &str) -> bool {
    letters.chars().any(|letter| words.value(letter).is_some_and(|value| value != Number::ZERO))
}

impl Meaning {
    /// The meaning of one code.
    pub(crate) fn of<'a>(code: &Code<'a>) -> Result<Self, Fault<'a>> {
        match code.name.letter {
            'G' => of_g(code),
            'M' => of_m(code),
            // Slicers use numbers beyond all tools to say "no tool".
            _ => Ok(match u8::try_from(code.name.number) {
                Ok(tool) if tool < u8::MAX && code.name.decimals == 0 => {
                    Self::Typed(Command::Tool(tool))
                }
                _ => Nothing,
            }),
        }
    }

    /// The meaning of a command with a name, such as those of Klipper.
    pub(crate) fn of_named(text: &str) -> Self {
        let name = name_of(text);
        let is = |known: &str| name.eq_ignore_ascii_case(known);
        if is("TURN_OFF_HEATERS") {
            Self::HeatersOff
        } else if is("SET_HEATER_TEMPERATURE") {
            let heater = match parameter(text, "HEATER") {
                Some(name) if name.eq_ignore_ascii_case("heater_bed") => Some(Heater::Bed),
                Some(name) => extruder(name).map(Heater::Nozzle),
                None => None,
            };
            match (heater, parameter(text, "TARGET").map(str::parse)) {
                (Some(_), None) => Self::Heat { heater, celsius: Number::ZERO, wait: Wait::No },
                (Some(_), Some(Ok(celsius))) => Self::Heat { heater, celsius, wait: Wait::No },
                _ => Unknown,
            }
        } else if is("ACTIVATE_EXTRUDER") {
            let tool = parameter(text, "EXTRUDER").and_then(extruder);
            tool.map_or(Unknown, |tool| Self::Typed(Command::Tool(tool)))
        } else if HARMLESS_NAMES.iter().any(|known| is(known)) {
            Nothing
        } else {
            // SET_VELOCITY_LIMIT with parameters that its type cannot hold.
            verbatim_acceleration(text).map_or(Unknown, Self::Acceleration)
        }
    }
}

/// The name that a verbatim command begins with.
pub(crate) fn name_of(text: &str) -> &str {
    text.split_ascii_whitespace().next().unwrap_or(text)
}

/// A parameter `NAME=value` of a command with a name.
pub(crate) fn parameter<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    text.split_ascii_whitespace().skip(1).find_map(|word| {
        let (key, value) = word.split_once('=')?;
        key.eq_ignore_ascii_case(name).then(|| value.trim_matches(['"', '\'']))
    })
}

/// The tool of Klipper's `extruder`, `extruder1` and so on.
fn extruder(name: &str) -> Option<u8> {
    const NAME: &str = "extruder";
    let number = name.get(..NAME.len()).filter(|start| start.eq_ignore_ascii_case(NAME))?;
    match &name[number.len()..] {
        "" => Some(0),
        digits => digits.parse().ok().filter(|&tool: &u8| tool < u8::MAX),
    }
}

fn of_g<'a>(code: &Code<'a>) -> Result<Meaning, Fault<'a>> {
    let has_axes = |words: &Words| "XYZ".chars().any(|axis| words.has(axis));
    Ok(match (code.name.number, code.name.decimals) {
        (0 | 1, 0) => {
            let words = words(code)?;
            if is_set(&words, "HR") {
                Refused("it moves to an end stop or to a stored position (H, R)")
            } else {
                lenient(code)?
            }
        }
        (2 | 3, 0) => {
            let words = words(code)?;
            if is_set(&words, "PK") {
                Refused("arcs of several turns (P) and in other planes (K)")
            } else {
                lenient(code)?
            }
        }
        // Marlin ignores the words, NIST RS274/NGC moves to them.
        (17..=21 | 40 | 49 | 53 | 54 | 64 | 80 | 90 | 91 | 94, 0)
            if code.name.number != 20 && "XYZEFIJR".chars().any(|letter| has(code, letter)) =>
        {
            Refused("words of a motion after this code")
        }
        // Some CNC controls state the seconds as X or U.
        (4, 0) if ['X', 'U'].iter().any(|&letter| has(code, letter)) => Unknown,
        (4 | 11 | 28 | 90 | 91 | 92, 0) => lenient(code)?,
        (0..=3, _) => Refused("this kind of motion"),
        (5 | 6, _) => Refused("curves and direct steps"),
        (7, _) => Refused("diameters in place of x"),
        (10, _) => of_g10(code)?,
        (16, _) => Refused("polar coordinates"),
        (18 | 19, _) | (17, 1..) => Meaning::Plane,
        (20, 0) => Meaning::Inches,
        (38, _) => Refused("probing"),
        (41..=44, _) => Refused("cutter and tool length compensation"),
        (51 | 52 | 68, _) if code.words.bytes().any(|byte| matches!(byte, b'1'..=b'9')) => {
            Refused("scaled, shifted or rotated coordinates")
        }
        (53, 0) => Meaning::MachineCoordinates,
        (54, 1..) | (55..=59, _) => Refused("work coordinates other than those of G54"),
        (70, 0) => Refused("inches"),
        (73 | 81..=89, _) if has_axes(&words(code)?) => Refused("drilling cycles"),
        (80, 0) => Meaning::EndMotion,
        (90, 1) => Refused("absolute centres of arcs"),
        (92, 1 | 2) => Meaning::ClearOffsets,
        (92, _) => Refused("stored coordinates"),
        (93 | 95, _) => Refused("feed rates in other units than mm/min"),
        (91, 1) => Nothing,
        (number, _) if HARMLESS_G.contains(&number) => Nothing,
        _ => Unknown,
    })
}

/// Whether a code has a word with a number.
fn has(code: &Code<'_>, letter: char) -> bool {
    words(code).is_ok_and(|words| words.value(letter).is_some())
}

/// `G10`: firmware retraction, or tool settings and coordinate systems in RepRapFirmware.
fn of_g10<'a>(code: &Code<'a>) -> Result<Meaning, Fault<'a>> {
    let words = words(code)?;
    let sets_tool = words.has('P') || words.has('R');
    Ok(match words.value('S') {
        _ if words.has('L') => Refused("work coordinates set by the program"),
        // Marlin's G10 S1 retracts for a tool change.
        Some(celsius) if sets_tool || celsius > Number::whole(1) => heat_tool(&words, celsius),
        None if sets_tool || "XYZUVW".chars().any(|axis| words.has(axis)) => Unknown,
        _ => Meaning::Typed(Command::Retract),
    })
}

/// Sets the temperature at which the tool `P` prints, or the current tool.
fn heat_tool(words: &Words, celsius: Number) -> Meaning {
    match words.value('P').map(to_u8) {
        Some(None) => Unknown,
        tool => {
            Meaning::Heat { heater: tool.flatten().map(Heater::Nozzle), celsius, wait: Wait::No }
        }
    }
}

fn of_m<'a>(code: &Code<'a>) -> Result<Meaning, Fault<'a>> {
    let number = code.name.number;
    Ok(match number {
        6 => match words(code)?.value('T') {
            None => Nothing,
            Some(tool) => match to_u8(tool) {
                Some(tool) if tool < u8::MAX => Meaning::Typed(Command::Tool(tool)),
                _ => Nothing,
            },
        },
        18 | 84 => {
            // With S, the command only sets how long motors may idle before they are switched off.
            if words(code)?.has('S') { Nothing } else { Meaning::MotorsOff }
        }
        82 | 83 | 204 => lenient(code)?,
        104 | 109 => {
            let words = words(code)?;
            let wait = match (number, words.value('S')) {
                (104, _) => Wait::No,
                (_, Some(_)) => Wait::Heating,
                (_, None) => Wait::HeatingOrCooling,
            };
            let celsius = words.value('S').or(words.value('R').filter(|_| number == 109));
            match (celsius, words.value('T').map(to_u8)) {
                (_, Some(None)) => Unknown,
                (Some(celsius), tool) => {
                    Meaning::Heat { heater: tool.flatten().map(Heater::Nozzle), celsius, wait }
                }
                (None, _) => {
                    if words.has('I') || words.has('R') {
                        Unknown
                    } else {
                        Nothing
                    }
                }
            }
        }
        140 | 190 => {
            let words = words(code)?;
            let wait = if number == 190 { Wait::Heating } else { Wait::No };
            let celsius = words.value('S').or(words.value('R').filter(|_| number == 190));
            match celsius {
                // RepRapFirmware numbers several beds with P.
                Some(celsius) if !is_set(&words, "P") => {
                    Meaning::Heat { heater: Some(Heater::Bed), celsius, wait }
                }
                Some(_) => Unknown,
                None => {
                    if words.has('I') {
                        Unknown
                    } else {
                        Nothing
                    }
                }
            }
        }
        200 => {
            // Extrusion in mm³, unless the diameter is 0 or S switches it off.
            let words = words(code)?;
            let off = |letter| words.value(letter) == Some(Number::ZERO);
            if off('D') || off('S') { Nothing } else { Unknown }
        }
        220 => {
            let words = words(code)?;
            match words.value('S') {
                Some(percent) if percent > Number::ZERO => Meaning::Speed(percent),
                Some(_) => Refused("a speed of 0 %"),
                None => {
                    if words.has('R') {
                        Unknown
                    } else {
                        Nothing
                    }
                }
            }
        }
        221 => {
            let words = words(code)?;
            match words.value('S') {
                Some(percent) if percent != Number::whole(100) => Unknown,
                _ => Nothing,
            }
        }
        // Cancels an object; other words name objects.
        486 if code.words.trim_start().starts_with(['P', 'p', 'C', 'c']) => Unknown,
        486 => Nothing,
        400 => {
            if code.words.is_empty() {
                Nothing
            } else {
                Unknown
            }
        }
        568 => {
            let words = words(code)?;
            words.value('S').map_or(Nothing, |celsius| heat_tool(&words, celsius))
        }
        _ if HARMLESS_M.contains(&number) => Nothing,
        _ => Unknown,
    })
}

/// What the typed command does, without the words that its type cannot hold.
fn lenient<'a>(code: &Code<'a>) -> Result<Meaning, Fault<'a>> {
    // Zero decimals, as in `G1.0`, change nothing.
    let text = code.text;
    let comments = &mut ParenthesisComments::default();
    if let Some(command) = typed(text, Strictness::Lenient, comments)? {
        return Ok(Meaning::Typed(command));
    }
    let plain = format!("{} {}", code.name, code.words);
    let command =
        typed(&plain, Strictness::Lenient, comments).map_err(|(_, fault)| (text, fault))?;
    command.map(Meaning::Typed).ok_or((text, ParseFault::Word))
}
