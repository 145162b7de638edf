//! Applies verbatim commands, of which the trace understands some.

use super::{SavedState, Trace};
use crate::code::{Code, words_without_code};
use crate::command::Command;
use crate::event::{Event, Motion, TraceError};
use crate::meaning::{Meaning, name_of, parameter};
use crate::number::Number;
use crate::parse::motion;
use crate::words::{ParenthesisComments, ParseFault, Words};

/// Name of the state that Klipper saves if the command names none.
const DEFAULT_STATE: &str = "default";

impl<'a> Trace<'a> {
    /// Applies the rest of a line up to the next event, and returns it.
    pub(super) fn apply_rest(&mut self, line: usize) -> Result<Option<Event>, TraceError> {
        while !self.rest.is_empty() {
            let text = std::mem::take(&mut self.rest);
            let event = if let Some((words, rest)) = words_without_code(text) {
                if !rest.is_empty() {
                    return Err(TraceError::Order { line });
                }
                self.apply_words(words, line)?
            } else if let Some((code, rest)) = Code::first(text) {
                self.rest = rest;
                self.apply_code(&code, line)?
            } else {
                self.apply_named(text, line)?
            };
            if event.is_some() {
                return Ok(event);
            }
        }
        Ok(None)
    }

    /// Repeats the last motion command with other words.
    fn apply_words(&mut self, words: &str, line: usize) -> Result<Option<Event>, TraceError> {
        let number = self.motion_code.ok_or(TraceError::NoCommand { line })?;
        let words = Words::read(words, "", "", false, &mut ParenthesisComments::default())
            .map_err(|(_, fault)| TraceError::Word { line, fault })?;
        self.apply(&motion(number, &words), line)
    }

    /// Applies one of the codes of a line.
    fn apply_code(&mut self, code: &Code<'a>, line: usize) -> Result<Option<Event>, TraceError> {
        let meaning = Meaning::of(code).map_err(|(_, fault)| TraceError::Word { line, fault })?;
        let changes_motions = matches!(
            meaning,
            Meaning::ClearOffsets
                | Meaning::MachineCoordinates
                | Meaning::EndMotion
                | Meaning::Typed(
                    Command::AbsolutePositioning
                        | Command::RelativePositioning
                        | Command::AbsoluteExtrusion
                        | Command::RelativeExtrusion
                        | Command::SetPosition { .. },
                )
        );
        if changes_motions && self.moved_line == line {
            return Err(TraceError::Order { line });
        }
        match meaning {
            Meaning::Typed(command) => {
                let moves = match &command {
                    Command::Move(words) => {
                        [words.x, words.y, words.z, words.e].iter().any(Option::is_some)
                    }
                    Command::Arc(_) | Command::Home { .. } => true,
                    _ => false,
                };
                if moves {
                    self.moved_line = line;
                }
                return self.apply(&command, line);
            }
            Meaning::Heat { heater, celsius, wait } => {
                return Ok(Some(self.heat(heater, celsius, wait, line)));
            }
            Meaning::HeatersOff => return Ok(Some(Event::HeatersOff { line })),
            Meaning::MotorsOff => return Ok(Some(Event::MotorsOff { line })),
            Meaning::Speed(percent) => self.speed_factor = percent.to_f64() / 100.0,
            Meaning::Acceleration(value) => self.set_acceleration(Some(value), line)?,
            Meaning::ClearOffsets => self.origin_mm = [0.0; 3],
            // On a line of its own, Marlin uses the printer's coordinates until G54.
            Meaning::MachineCoordinates
                if self.rest.is_empty() && self.origin_mm.iter().any(|&at| at != 0.0) =>
            {
                return Err(TraceError::Unsupported {
                    line,
                    code: code.name,
                    reason: "coordinates of the printer after G92, without a motion on the line",
                });
            }
            Meaning::MachineCoordinates => self.machine_line = line,
            Meaning::EndMotion => self.motion_code = None,
            Meaning::Inches => return Err(TraceError::Inches { line }),
            Meaning::Plane => return Err(TraceError::Plane { line }),
            Meaning::Refused(reason) => {
                return Err(TraceError::Unsupported { line, code: code.name, reason });
            }
            Meaning::Nothing | Meaning::Unknown => {}
        }
        Ok(None)
    }

    /// Applies a command with a name, such as those of Klipper.
    fn apply_named(&mut self, text: &'a str, line: usize) -> Result<Option<Event>, TraceError> {
        let name = name_of(text);
        if let Some(rest) = text.strip_prefix('/')
            && (Code::first(rest).is_some() || words_without_code(rest).is_some())
        {
            return Err(TraceError::Optional { line });
        }
        if is_malformed_g_code(name) {
            return Err(TraceError::Word { line, fault: ParseFault::Word });
        }
        if name.eq_ignore_ascii_case("SAVE_GCODE_STATE") {
            let state = parameter(text, "NAME").unwrap_or(DEFAULT_STATE);
            self.states.insert(state, self.state());
            return Ok(None);
        }
        if name.eq_ignore_ascii_case("RESTORE_GCODE_STATE") {
            return Ok(self.restore(text, line));
        }
        match Meaning::of_named(text) {
            Meaning::Typed(command) => self.apply(&command, line),
            Meaning::Heat { heater, celsius, wait } => {
                Ok(Some(self.heat(heater, celsius, wait, line)))
            }
            Meaning::HeatersOff => Ok(Some(Event::HeatersOff { line })),
            Meaning::Acceleration(value) => {
                self.set_acceleration(Some(value), line)?;
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    fn state(&self) -> SavedState {
        SavedState {
            position_mm: self.position_mm,
            origin_mm: self.origin_mm,
            filament_mm: self.filament_mm,
            relative: self.relative,
            relative_extrusion: self.relative_extrusion,
            feed_mm_s: self.feed_mm_s,
            speed_factor: self.speed_factor,
        }
    }

    /// Restores a state that Klipper saved; with `MOVE=1` the nozzle returns to its position.
    fn restore(&mut self, text: &str, line: usize) -> Option<Event> {
        let state = parameter(text, "NAME").unwrap_or(DEFAULT_STATE);
        let state = *self.states.get(state)?;
        let from_mm = self.position_mm;
        let number = |name| parameter(text, name).and_then(|value| value.parse::<Number>().ok());
        self.origin_mm = state.origin_mm;
        self.filament_mm = state.filament_mm;
        self.relative = state.relative;
        self.relative_extrusion = state.relative_extrusion;
        self.feed_mm_s = state.feed_mm_s;
        self.speed_factor = state.speed_factor;
        if number("MOVE").is_none_or(|value| value == Number::ZERO) {
            return None;
        }
        self.position_mm = state.position_mm;
        let speed = number("MOVE_SPEED").filter(|&speed| speed > Number::ZERO);
        let motion = Motion {
            from_mm,
            to_mm: state.position_mm,
            extruded_mm: 0.0,
            feed_mm_s: speed.map_or(self.feed_mm_s, Number::to_f64),
            acceleration_mm_s2: self.travel_acceleration,
            tool: self.tool.unwrap_or(0),
            feature: self.feature,
            layer: self.layer,
            line,
        };
        (motion.length_mm() > 0.0).then_some(Event::Motion(motion))
    }
}

/// Whether a name is a G-code followed by a character that belongs to no word, such as a blank in
/// another encoding: it might be a motion.
/// Names of macros may begin like a code, but contain only letters, digits and underscores.
fn is_malformed_g_code(name: &str) -> bool {
    let number = name.strip_prefix(['G', 'g']).unwrap_or("");
    let rest = number.trim_start_matches(|next: char| next.is_ascii_digit());
    let is_name = |next: char| next.is_ascii_alphanumeric() || next == '_';
    rest.len() < number.len() && !rest.starts_with(is_name)
}
