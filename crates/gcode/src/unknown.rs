//! Commands whose effect is not known.

use std::collections::HashMap;

use crate::code::{Code, words_without_code};
use crate::command::Command;
use crate::meaning::{Meaning, name_of};
use crate::number::Number;
use crate::program::Program;
use crate::time::MotionLimits;
use crate::words::{ParenthesisComments, Words};

/// A command of a program that could matter but has no effect in the trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownCommand {
    /// Its name, such as `START_PRINT` or `M600`.
    pub name: String,
    /// How many times the program contains it.
    pub count: usize,
    /// Number of the first line that contains it, from 1.
    pub line: usize,
}

impl Program {
    /// Returns the commands that could change motions, times or temperatures, but have no effect in
    /// the trace, in the order of their first lines.
    ///
    /// These are macros, commands that only the printer can interpret, limits of speed and
    /// acceleration other than `limits`, axes other than x, y, z and e, and firmware retraction.
    /// Not listed are commands that only set up the printer, such as fan speeds and messages.
    ///
    /// Linear in the length of the program.
    pub fn unknown_commands(&self, limits: MotionLimits) -> Vec<UnknownCommand> {
        let differs = |value: Option<Number>, limit: f64| {
            value.is_some_and(|value| (value.to_f64() - limit).abs() > SAME_MM_S)
        };
        let corner = limits.square_corner_mm_s;
        let mut found = Vec::new();
        let mut places = HashMap::new();
        let mut add = |name: &str, line: usize| {
            if let Some(&at) = places.get(name) {
                let known: &mut UnknownCommand = &mut found[at];
                known.count += 1;
            } else {
                places.insert(name.to_owned(), found.len());
                found.push(UnknownCommand { name: name.to_owned(), count: 1, line });
            }
        };
        for (number, line) in (1..).zip(&self.lines) {
            match line.command() {
                Some(Command::Retract) => add("G10", number),
                Some(Command::Unretract) => add("G11", number),
                Some(Command::Jerk { x, y, .. })
                    if x.or(*y).is_none() || differs(*x, corner) || differs(*y, corner) =>
                {
                    add("M205", number);
                }
                Some(Command::VelocityLimit { velocity, square_corner, .. })
                    if differs(*velocity, limits.max_speed_mm_s)
                        || differs(*square_corner, corner) =>
                {
                    add("SET_VELOCITY_LIMIT", number);
                }
                Some(Command::Other(text)) => {
                    for_each_unknown(text.as_str(), &mut |name| add(name, number));
                }
                _ => {}
            }
        }
        found
    }
}

/// Speeds that differ less are the same, in mm/s.
const SAME_MM_S: f64 = 0.01;

/// Calls `add` with the name of each unknown command of a line.
fn for_each_unknown(text: &str, add: &mut impl FnMut(&str)) {
    let mut rest = text;
    if let Some((words, after)) = words_without_code(rest) {
        add_axes(words, "", add);
        rest = after;
    }
    let mut is_first = true;
    while let Some((code, after)) = Code::first(rest) {
        match Meaning::of(&code) {
            Ok(Meaning::Unknown) => add(&code.name.to_string()),
            Ok(Meaning::Typed(Command::Retract | Command::Unretract)) => {
                add(&code.name.to_string());
            }
            Ok(Meaning::Typed(Command::Move(_) | Command::Arc(_))) => {
                add_axes(code.words, &code.name.to_string(), add);
            }
            // Errors end the trace.
            _ => {}
        }
        rest = after;
        is_first = false;
    }
    if is_first && !rest.is_empty() && rest.len() == text.len() {
        let is_state = STATES.iter().any(|name| name_of(text).eq_ignore_ascii_case(name));
        if !is_state && matches!(Meaning::of_named(text), Meaning::Unknown) {
            add(name_of(text));
        }
    }
}

/// Klipper commands that the trace follows itself.
pub(crate) const STATES: [&str; 2] = ["SAVE_GCODE_STATE", "RESTORE_GCODE_STATE"];

/// Adds the axes of a motion that the trace has none for.
fn add_axes(words: &str, name: &str, add: &mut impl FnMut(&str)) {
    let words = Words::read(words, "", "", false, &mut ParenthesisComments::default());
    let Ok(words) = words else { return };
    for axis in "ABCUVW".chars() {
        if words.value(axis).is_some() {
            add(format!("{name} {axis}").trim());
        }
    }
}
