//! Interprets a program: keeps track of the printer's state and yields what the printer does.
//!
//! The state follows an FDM printer with Marlin, Klipper or RepRapFirmware.
//! It starts at position 0 with absolute positioning, absolute extrusion and tool 0. `G28` sets the
//! named axes to 0 without a motion.
//!
//! Extrusion is relative after `G91` until `G90`, and after `M83` until `M82`, as in Klipper.
//! Marlin differs in that `G90` also ends `M83`, and `M82` overrides an earlier `G91`.
//! A program that repeats `M83` after every `G90` and `G91` means the same to both.
//!
//! Several commands on a line are executed from left to right, and words without a command repeat
//! the last motion command, as in RepRapFirmware.
//!
//! Macros, tool offsets and firmware retraction have no effect: only the printer knows what they
//! do.

use std::collections::HashMap;
use std::slice::Iter;

use beadwork_base::Control;

use crate::arc::Chords;
use crate::command::{Command, LinearMove, Wait};
use crate::event::{Event, Heater, Motion, TraceError};
use crate::feature::{Feature, Marker};
use crate::number::Number;
use crate::program::{Line, Program};

/// Speed of a motion before the program sets a feed rate, in mm/s: Klipper's default.
const INITIAL_FEED_MM_S: f64 = 25.0;

/// Lines that are traced between two checks for interruption.
/// One line can be an arc of 720 motions, so this is about half a million motions at most.
const LINES_PER_CHECK: usize = 1 << 10;

impl Program {
    /// Returns an iterator over the events of the program, in order.
    /// It ends after an error.
    ///
    /// Arcs are replaced by chords: straight motions that deviate from the arc by at most 5 µm, or
    /// more if its radius exceeds 525 mm.
    /// Linear in lines and chords; nothing is computed before the iterator is advanced.
    pub fn trace(&self) -> Trace<'_> {
        Trace {
            lines: self.lines.iter(),
            line_number: 0,
            arc: None,
            rest: "",
            position_mm: [0.0; 3],
            origin_mm: [0.0; 3],
            filament_mm: 0.0,
            relative: false,
            relative_extrusion: false,
            feed_mm_s: INITIAL_FEED_MM_S,
            speed_factor: 1.0,
            motion_code: None,
            moved_line: 0,
            machine_line: 0,
            states: HashMap::new(),
            print_acceleration: None,
            travel_acceleration: None,
            tool: None,
            feature: Feature::Unknown,
            layer: None,
        }
    }

    /// Calls `visit` with every event of the program, in order.
    /// Progress counts lines.
    pub(crate) fn for_each_event(
        &self,
        control: &Control<'_>,
        mut visit: impl FnMut(&Event),
    ) -> Result<(), TraceError> {
        let mut trace = self.trace();
        for (number, lines) in self.lines.chunks(LINES_PER_CHECK).enumerate() {
            control.check()?;
            control.report(number * LINES_PER_CHECK, self.lines.len());
            trace.lines = lines.iter();
            for event in &mut trace {
                visit(&event?);
            }
        }
        control.report(self.lines.len(), self.lines.len());
        Ok(())
    }
}

/// Iterator over the events of a program, from [`Program::trace`].
#[derive(Debug)]
pub struct Trace<'a> {
    lines: Iter<'a, Line>,
    /// Number of the last line that was interpreted, from 1.
    line_number: usize,
    /// The rest of an arc: the motion from the end of its last chord, and the chords that follow.
    arc: Option<(Motion, Chords)>,
    /// The commands of the current line that are still to be applied.
    rest: &'a str,
    position_mm: [f64; 3],
    /// Position at which the program's coordinates are 0: `G92` moves it.
    origin_mm: [f64; 3],
    /// Length of extruded filament as the program counts it, for absolute extrusion.
    filament_mm: f64,
    relative: bool,
    relative_extrusion: bool,
    feed_mm_s: f64,
    /// Share of the feed rate at which the printer moves, `M220`.
    speed_factor: f64,
    /// The motion that words without a code repeat: 0 to 3 for `G0` to `G3`.
    motion_code: Option<u32>,
    /// The last line with several commands of which one moves.
    moved_line: usize,
    /// The last line on which coordinates are those of the printer, `G53`.
    machine_line: usize,
    /// States saved by Klipper's `SAVE_GCODE_STATE`, by name.
    states: HashMap<&'a str, SavedState>,
    /// Accelerations in mm/s², if the program has set them.
    print_acceleration: Option<f64>,
    travel_acceleration: Option<f64>,
    tool: Option<u8>,
    feature: Feature,
    layer: Option<u32>,
}

/// What Klipper's `SAVE_GCODE_STATE` saves.
#[derive(Clone, Copy, Debug)]
struct SavedState {
    position_mm: [f64; 3],
    origin_mm: [f64; 3],
    filament_mm: f64,
    relative: bool,
    relative_extrusion: bool,
    feed_mm_s: f64,
    speed_factor: f64,
}

impl Iterator for Trace<'_> {
    type Item = Result<Event, TraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some((motion, chords)) = &mut self.arc {
            if let Some((to, share)) = chords.next() {
                let chord =
                    Motion { to_mm: to, extruded_mm: motion.extruded_mm * share, ..*motion };
                motion.from_mm = to;
                return Some(Ok(Event::Motion(chord)));
            }
            self.arc = None;
        }
        loop {
            let applied = if self.rest.is_empty() {
                let line = self.lines.next()?;
                self.line_number += 1;
                match line.comment().and_then(Marker::read) {
                    Some(Marker::NextLayer) => {
                        self.layer = Some(self.layer.map_or(0, |last| last.saturating_add(1)));
                    }
                    Some(Marker::Layer(layer)) => self.layer = layer,
                    Some(Marker::Feature(feature)) => self.feature = feature,
                    None => {}
                }
                match line.command() {
                    None => Ok(None),
                    Some(Command::Other(text)) => {
                        self.rest = text.as_str();
                        self.apply_rest(self.line_number)
                    }
                    Some(command) => self.apply(command, self.line_number),
                }
            } else {
                self.apply_rest(self.line_number)
            };
            match applied {
                Ok(Some(event)) => return Some(Ok(event)),
                Ok(None) => {}
                Err(error) => {
                    self.lines = [].iter();
                    self.rest = "";
                    return Some(Err(error));
                }
            }
        }
    }
}

impl Trace<'_> {
    /// Applies a command to the state; returns the event that it causes, if any.
    fn apply(&mut self, command: &Command, line: usize) -> Result<Option<Event>, TraceError> {
        match *command {
            Command::Move(LinearMove { x, y, z, e, f, rapid }) => {
                self.motion_code = Some(u32::from(!rapid));
                let motion = self.motion([x, y, z], e, f, line)?;
                let moves = motion.length_mm() > 0.0 || motion.extruded_mm.abs() > 0.0;
                return Ok(moves.then_some(Event::Motion(motion)));
            }
            Command::Arc(ref arc) => {
                self.motion_code = Some(if arc.clockwise { 2 } else { 3 });
                let motion = self.motion([arc.x, arc.y, arc.z], arc.e, arc.f, line)?;
                let mut chords = Chords::new(motion.from_mm, motion.to_mm, arc)
                    .ok_or(TraceError::Arc { line })?;
                if let Some((to_mm, share)) = chords.next() {
                    let first = Motion { to_mm, extruded_mm: motion.extruded_mm * share, ..motion };
                    self.arc = Some((Motion { from_mm: to_mm, ..motion }, chords));
                    return Ok(Some(Event::Motion(first)));
                }
            }
            Command::Dwell { seconds, milliseconds } => {
                let milliseconds = milliseconds.map(|value| value.to_f64() / 1000.0);
                let seconds = seconds.map(Number::to_f64).or(milliseconds).unwrap_or(0.0).max(0.0);
                return Ok(Some(Event::Pause { seconds, line }));
            }
            Command::Home { x, y, z } => {
                let all = !(x || y || z);
                for (axis, is_named) in [x, y, z].into_iter().enumerate() {
                    if is_named || all {
                        self.position_mm[axis] = 0.0;
                        self.origin_mm[axis] = 0.0;
                    }
                }
            }
            Command::SetPosition { x, y, z, e } => {
                let all = [x, y, z, e].iter().all(Option::is_none).then_some(Number::ZERO);
                for (axis, value) in [x, y, z].into_iter().enumerate() {
                    if let Some(value) = value.or(all) {
                        self.origin_mm[axis] = self.position_mm[axis] - value.to_f64();
                    }
                }
                self.filament_mm = e.or(all).map_or(self.filament_mm, Number::to_f64);
            }
            Command::AbsolutePositioning => self.relative = false,
            Command::RelativePositioning => self.relative = true,
            Command::AbsoluteExtrusion => self.relative_extrusion = false,
            Command::RelativeExtrusion => self.relative_extrusion = true,
            Command::Tool(to) => {
                let from = self.tool.replace(to);
                return Ok((from != Some(to)).then_some(Event::ToolChange { from, to, line }));
            }
            Command::Acceleration { print, travel, retract, all } => {
                let checked = |value: Option<Number>| checked_acceleration(value, line);
                let (print, travel, all) = (checked(print)?, checked(travel)?, checked(all)?);
                checked(retract)?;
                self.print_acceleration = print.or(all).or(self.print_acceleration);
                self.travel_acceleration = travel.or(all).or(self.travel_acceleration);
            }
            Command::VelocityLimit { acceleration, .. } => {
                self.set_acceleration(acceleration, line)?;
            }
            Command::NozzleTemperature { celsius, tool, wait } => {
                return Ok(Some(self.heat(tool.map(Heater::Nozzle), celsius, wait, line)));
            }
            Command::BedTemperature { celsius, wait } => {
                let wait = if wait { Wait::Heating } else { Wait::No };
                return Ok(Some(self.heat(Some(Heater::Bed), celsius, wait, line)));
            }
            // Verbatim commands are applied one by one, see `apply_rest`.
            Command::Other(_)
            | Command::Fan(_)
            | Command::Jerk { .. }
            | Command::Progress { .. }
            | Command::Retract
            | Command::Unretract => {}
        }
        Ok(None)
    }

    /// The event that sets a heater; `None` stands for the nozzle of the current tool.
    fn heat(&self, heater: Option<Heater>, celsius: Number, wait: Wait, line: usize) -> Event {
        let heater = heater.unwrap_or(Heater::Nozzle(self.tool.unwrap_or(0)));
        Event::Heat { heater, celsius: celsius.to_f64(), wait, line }
    }

    fn set_acceleration(&mut self, value: Option<Number>, line: usize) -> Result<(), TraceError> {
        let value = checked_acceleration(value, line)?;
        self.print_acceleration = value.or(self.print_acceleration);
        self.travel_acceleration = value.or(self.travel_acceleration);
        Ok(())
    }

    /// Moves the nozzle to the given coordinates; returns the straight motion to them.
    fn motion(
        &mut self,
        coordinates: [Option<Number>; 3],
        e: Option<Number>,
        f: Option<Number>,
        line: usize,
    ) -> Result<Motion, TraceError> {
        if let Some(feed) = f {
            let feed_mm_min = feed.to_f64();
            if feed <= Number::ZERO {
                return Err(TraceError::Feed { line, feed_mm_min });
            }
            self.feed_mm_s = feed_mm_min / 60.0;
        }
        let from_mm = self.position_mm;
        for (axis, value) in coordinates.into_iter().enumerate() {
            if let Some(value) = value {
                let zero = if self.relative {
                    from_mm[axis]
                } else if self.machine_line == line {
                    0.0
                } else {
                    self.origin_mm[axis]
                };
                self.position_mm[axis] = zero + value.to_f64();
            }
        }
        let extruded_mm = match e.map(Number::to_f64) {
            None => 0.0,
            Some(length) if self.relative || self.relative_extrusion => length,
            Some(length) => {
                let before = std::mem::replace(&mut self.filament_mm, length);
                length - before
            }
        };
        if extruded_mm > 0.0 {
            // A program that extrudes before it selects a tool uses the first one.
            self.tool.get_or_insert(0);
        }
        Ok(Motion {
            from_mm,
            to_mm: self.position_mm,
            extruded_mm,
            feed_mm_s: self.feed_mm_s * self.speed_factor,
            acceleration_mm_s2: if extruded_mm > 0.0 {
                self.print_acceleration
            } else {
                self.travel_acceleration
            },
            tool: self.tool.unwrap_or(0),
            feature: self.feature,
            layer: self.layer,
            line,
        })
    }
}

fn checked_acceleration(value: Option<Number>, line: usize) -> Result<Option<f64>, TraceError> {
    match value.map(Number::to_f64) {
        Some(acceleration_mm_s2) if acceleration_mm_s2 <= 0.0 => {
            Err(TraceError::Acceleration { line, acceleration_mm_s2 })
        }
        value => Ok(value),
    }
}

mod verbatim;

#[cfg(test)]
mod tests;
