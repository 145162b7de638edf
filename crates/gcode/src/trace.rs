//! What a program makes the printer do: motions, changes of tool, heat and pauses.
//!
//! The printer is one of plastic as Marlin and Klipper drive them.
//! At the beginning it stands at 0, takes coordinates as places and lengths of filament as counted
//! from the start, and has the first tool.
//! `G28` puts the named axes to 0 without a motion.
//! Filament is counted from move to move while places are (`G91`), and after `M83` until `M82`.
//! Klipper does just that; Marlin differs in that `G90` ends `M83`, and `M82` holds after `G91`:
//! [`Program::check`] refuses programs in which that matters.
//! Macros, offsets of tools and retractions by the firmware do nothing here, for only the printer
//! knows what they do.

use std::iter::Enumerate;
use std::slice::Iter;

use thiserror::Error;

use super::arc::Chords;
use super::feature::Note;
use crate::{Command, Feature, Line, Move, Number, Program, Wait, parse};

/// A straight motion, or filament pushed or drawn back in place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Where it begins: x, y, z in mm.
    pub from_mm: [f64; 3],
    /// Where it ends: x, y, z in mm.
    pub to_mm: [f64; 3],
    /// Filament in mm; less than 0 when it is drawn back.
    pub extruded_mm: f64,
    /// Asked speed in mm/s, more than 0: of the head, or of the filament if the head stands.
    pub feed_mm_s: f64,
    /// Acceleration in mm/s², if the program has set one for such moves.
    pub acceleration_mm_s2: Option<f64>,
    /// The tool.
    pub tool: u8,
    /// What is printed, as the last comment says.
    pub feature: Feature,
    /// Number of the layer from 0, as the last comment says: counted from the bed, unless the
    /// program has a raft below.
    /// [`Layer::number`](super::Layer::number) in the programs written here.
    pub layer: Option<u32>,
    /// Number of the line, from 1.
    pub line: usize,
}

impl Motion {
    /// Length of the head's way, in mm.
    pub fn length_mm(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.to_mm[axis] - self.from_mm[axis]);
        (x * x + y * y + z * z).sqrt()
    }

    /// Whether it lays down a bead: the head moves and extrudes.
    pub fn is_stroke(&self) -> bool {
        self.extruded_mm > 0.0 && self.length_mm() > 0.0
    }
}

/// What can be heated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Heater {
    /// The nozzle of a tool, or the one nozzle while it has that tool's filament.
    Nozzle(u8),
    /// The bed.
    Bed,
}

impl std::fmt::Display for Heater {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Nozzle(tool) => write!(f, "nozzle of tool {tool}"),
            Self::Bed => f.write_str("bed"),
        }
    }
}

/// What happens in a program.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The head or the filament moves.
    Motion(Motion),
    /// Another tool is selected.
    ToolChange {
        /// The tool before; `None` if nothing was extruded or selected before.
        from: Option<u8>,
        /// The tool after.
        to: u8,
        /// Number of the line, from 1.
        line: usize,
    },
    /// Something gets another temperature.
    Heat {
        /// What.
        heater: Heater,
        /// The temperature, in degrees Celsius.
        celsius: f64,
        /// What is waited for; [`Wait::Heating`] if it is the bed.
        wait: Wait,
        /// Number of the line, from 1.
        line: usize,
    },
    /// All heaters are switched off, Klipper's `TURN_OFF_HEATERS`.
    HeatersOff {
        /// Number of the line, from 1.
        line: usize,
    },
    /// The motors let go, `M84` or `M18`: where the head is then is not certain.
    MotorsOff {
        /// Number of the line, from 1.
        line: usize,
    },
    /// Nothing moves for a while.
    Pause {
        /// How long, in s.
        seconds: f64,
        /// Number of the line, from 1.
        line: usize,
    },
}

/// A line that makes no sense.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TraceError {
    /// It asks for inches.
    #[error("line {line}: inches are not supported")]
    Inches {
        /// Number of the line, from 1.
        line: usize,
    },
    /// It asks for arcs in another plane than that of x and y.
    #[error("line {line}: arcs are not supported in other planes than that of x and y")]
    Plane {
        /// Number of the line, from 1.
        line: usize,
    },
    /// It asks for a speed that is not positive.
    #[error("line {line}: a speed of {feed_mm_min} mm/min")]
    Feed {
        /// Number of the line, from 1.
        line: usize,
        /// The speed, in mm/min.
        feed_mm_min: f64,
    },
    /// It asks for an acceleration that is not positive.
    #[error("line {line}: an acceleration of {acceleration_mm_s2} mm/s²")]
    Acceleration {
        /// Number of the line, from 1.
        line: usize,
        /// The acceleration, in mm/s².
        acceleration_mm_s2: f64,
    },
    /// It asks for an arc without centre and radius, around its own beginning, or with a radius
    /// that does not reach its end.
    #[error("line {line}: no such arc")]
    Arc {
        /// Number of the line, from 1.
        line: usize,
    },
}

/// Speed of a motion before the program asks for one, in mm/s: Klipper's.
const FIRST_FEED_MM_S: f64 = 25.0;

impl Program {
    /// The events of the program in order, one at a time; it ends after an error.
    /// Arcs come as straight motions.
    /// Linear in lines and chords.
    pub fn trace(&self) -> Trace<'_> {
        Trace {
            lines: self.lines.iter().enumerate(),
            arc: None,
            at: [0.0; 3],
            origin: [0.0; 3],
            filament: 0.0,
            relative: false,
            relative_filament: false,
            feed: FIRST_FEED_MM_S,
            acceleration: None,
            travel_acceleration: None,
            tool: None,
            feature: Feature::Unknown,
            layer: None,
        }
    }
}

/// The events of a program, from [`Program::trace`].
#[derive(Debug)]
pub struct Trace<'a> {
    lines: Enumerate<Iter<'a, Line>>,
    /// What is left of an arc.
    arc: Option<(Motion, Chords)>,
    /// Where the head is.
    at: [f64; 3],
    /// What the program calls 0.
    origin: [f64; 3],
    /// What the program calls the length of extruded filament.
    filament: f64,
    relative: bool,
    relative_filament: bool,
    feed: f64,
    acceleration: Option<f64>,
    travel_acceleration: Option<f64>,
    tool: Option<u8>,
    feature: Feature,
    layer: Option<u32>,
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
            let (index, line) = self.lines.next()?;
            if let Some(note) = line.comment().and_then(Note::read) {
                match note {
                    Note::NextLayer => {
                        self.layer = Some(self.layer.map_or(0, |last| last.saturating_add(1)))
                    }
                    Note::Layer(layer) => self.layer = layer,
                    Note::Feature(feature) => self.feature = feature,
                }
            }
            let Some(command) = line.command() else { continue };
            match self.apply(command, index + 1) {
                Ok(Some(event)) => return Some(Ok(event)),
                Ok(None) => {}
                Err(error) => {
                    self.lines = [].iter().enumerate();
                    return Some(Err(error));
                }
            }
        }
    }
}

impl Trace<'_> {
    fn apply(&mut self, command: &Command, line: usize) -> Result<Option<Event>, TraceError> {
        match *command {
            Command::Move(Move { x, y, z, e, f, .. }) => {
                let motion = self.motion([x, y, z], e, f, line)?;
                let moves = motion.length_mm() > 0.0 || motion.extruded_mm.abs() > 0.0;
                return Ok(moves.then_some(Event::Motion(motion)));
            }
            Command::Arc(ref arc) => {
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
                for (axis, _) in
                    [x, y, z].into_iter().enumerate().filter(|&(_, named)| named || all)
                {
                    self.at[axis] = 0.0;
                    self.origin[axis] = 0.0;
                }
            }
            Command::SetPosition { x, y, z, e } => {
                let all = [x, y, z, e].iter().all(Option::is_none).then_some(Number::ZERO);
                for (axis, value) in [x, y, z].into_iter().enumerate() {
                    if let Some(value) = value.or(all) {
                        self.origin[axis] = self.at[axis] - value.to_f64();
                    }
                }
                self.filament = e.or(all).map_or(self.filament, Number::to_f64);
            }
            Command::Absolute => self.relative = false,
            Command::Relative => self.relative = true,
            Command::AbsoluteExtrusion => self.relative_filament = false,
            Command::RelativeExtrusion => self.relative_filament = true,
            Command::Tool(to) => {
                let from = self.tool.replace(to);
                return Ok((from != Some(to)).then_some(Event::ToolChange { from, to, line }));
            }
            Command::Acceleration { print, travel, retract, all } => {
                let checked = |value: Option<Number>| acceleration(value, line);
                let (print, travel, all) = (checked(print)?, checked(travel)?, checked(all)?);
                checked(retract)?;
                self.acceleration = print.or(all).or(self.acceleration);
                self.travel_acceleration = travel.or(all).or(self.travel_acceleration);
            }
            Command::VelocityLimit { acceleration: value, .. } => self.accelerate(value, line)?,
            Command::Other(ref text) => return self.other(text.as_str(), line),
            Command::NozzleTemperature { celsius, tool, wait } => {
                let heater = Heater::Nozzle(tool.or(self.tool).unwrap_or(0));
                return Ok(Some(Event::Heat { heater, celsius: celsius.to_f64(), wait, line }));
            }
            Command::BedTemperature { celsius, wait } => {
                let wait = if wait { Wait::Heating } else { Wait::No };
                return Ok(Some(Event::Heat {
                    heater: Heater::Bed,
                    celsius: celsius.to_f64(),
                    wait,
                    line,
                }));
            }
            Command::Fan(_)
            | Command::Jerk { .. }
            | Command::Progress { .. }
            | Command::Retract
            | Command::Unretract => {}
        }
        Ok(None)
    }

    /// What a command that is not typed does.
    fn other(&mut self, text: &str, line: usize) -> Result<Option<Event>, TraceError> {
        let is = |name: &str| text.eq_ignore_ascii_case(name);
        if is("G20") {
            return Err(TraceError::Inches { line });
        }
        if is("G18") || is("G19") {
            return Err(TraceError::Plane { line });
        }
        let mut words = text.split_ascii_whitespace();
        let name = words.next().unwrap_or(text);
        if name.eq_ignore_ascii_case("TURN_OFF_HEATERS") {
            return Ok(Some(Event::HeatersOff { line }));
        }
        // With S it says when to switch off motors that rest.
        let switches = ["M84", "M18"].iter().any(|known| name.eq_ignore_ascii_case(known));
        if switches && !words.any(|word| word.starts_with(['S', 's'])) {
            return Ok(Some(Event::MotorsOff { line }));
        }
        // With words that its type does not hold it still limits what follows.
        self.accelerate(parse::acceleration(text), line)?;
        Ok(None)
    }

    fn accelerate(&mut self, value: Option<Number>, line: usize) -> Result<(), TraceError> {
        let value = acceleration(value, line)?;
        self.acceleration = value.or(self.acceleration);
        self.travel_acceleration = value.or(self.travel_acceleration);
        Ok(())
    }

    /// The straight motion to a place; the head is there from now on.
    fn motion(
        &mut self,
        place: [Option<Number>; 3],
        e: Option<Number>,
        f: Option<Number>,
        line: usize,
    ) -> Result<Motion, TraceError> {
        if let Some(feed) = f {
            let feed_mm_min = feed.to_f64();
            if feed <= Number::ZERO {
                return Err(TraceError::Feed { line, feed_mm_min });
            }
            self.feed = feed_mm_min / 60.0;
        }
        let from_mm = self.at;
        for (axis, value) in place.into_iter().enumerate() {
            if let Some(value) = value {
                let zero = if self.relative { self.at[axis] } else { self.origin[axis] };
                self.at[axis] = zero + value.to_f64();
            }
        }
        let extruded_mm = match e.map(Number::to_f64) {
            None => 0.0,
            Some(length) if self.relative || self.relative_filament => length,
            Some(length) => {
                let before = std::mem::replace(&mut self.filament, length);
                length - before
            }
        };
        if extruded_mm > 0.0 {
            // Who extrudes before selecting a tool has the first one.
            self.tool.get_or_insert(0);
        }
        Ok(Motion {
            from_mm,
            to_mm: self.at,
            extruded_mm,
            feed_mm_s: self.feed,
            acceleration_mm_s2: if extruded_mm > 0.0 {
                self.acceleration
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

fn acceleration(value: Option<Number>, line: usize) -> Result<Option<f64>, TraceError> {
    match value.map(Number::to_f64) {
        Some(acceleration_mm_s2) if acceleration_mm_s2 <= 0.0 => {
            Err(TraceError::Acceleration { line, acceleration_mm_s2 })
        }
        value => Ok(value),
    }
}

#[cfg(test)]
mod tests;
