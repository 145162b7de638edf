//! How long a print takes.
//!
//! The head speeds up and slows down at a given acceleration and passes corners at a limited speed,
//! which the planner of the firmware looks ahead for.
//! The rule of corners is that of Klipper, from its documentation, page "Kinematics", section
//! "Look-ahead": with the angle θ between two moves that meet (π if straight on), a circle that
//! comes as near to the corner as the junction deviation δ has the radius R = δ sin(θ/2) / (1 -
//! sin(θ/2)), and the head may pass with v² = R a.
//! The deviation is chosen so that a right angle is passed with the square corner velocity s: δ =
//! s² (√2 - 1) / a.
//! Marlin's junction deviation (`M205 J`) is the same rule.
//!
//! Not reckoned with: smoothing of short moves (Klipper's minimum cruise ratio and its limit of
//! short moves at corners), pressure advance, limits of single axes (`M203`), what a program says
//! of corners and of the greatest speed (`M205`, and all of `SET_VELOCITY_LIMIT` but `ACCEL`:
//! [`Limits`] holds throughout), acceleration of filament alone (`M204 R`) and Klipper's limit of
//! speed where the flow changes, heating, and what macros and changes of tool take.

use super::pace::Pace;
use crate::{Event, Motion, Program, TraceError, Wait};

/// What the printer can do, where a program does not say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Acceleration in mm/s², more than 0, of motions that have none of their own.
    pub acceleration_mm_s2: f64,
    /// Speed through a right angle, in mm/s, at least 0: 0 means a stop at every corner.
    pub square_corner_mm_s: f64,
    /// The greatest speed, in mm/s, more than 0.
    pub greatest_mm_s: f64,
}

/// Reckons the time of events as they come, in linear time; it holds the motions since the last
/// stop, but no more than about 65,000: of those before, nothing that comes changes the speed,
/// unless none of them was long enough to brake in.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    limits: Limits,
    chain: Vec<Leg>,
    /// Of what lies before the chain.
    seconds: f64,
    most_legs: usize,
}

/// A program may go on without a stop, and an arc of a few letters be hundreds of motions: so many
/// are held.
const MOST_LEGS: usize = 1 << 16;

/// A motion of the head on the way from one stop to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    length: f64,
    acceleration: f64,
    /// Square of the asked speed.
    cruise2: f64,
    /// Square of the greatest speed at its beginning.
    junction2: f64,
    direction: [f64; 3],
}

impl Program {
    /// How long the program takes, in s.
    /// Linear.
    pub fn print_seconds(&self, limits: Limits) -> Result<f64, TraceError> {
        let mut watch = Stopwatch::new(limits);
        for event in self.trace() {
            watch.take(&event?);
        }
        Ok(watch.seconds())
    }
}

impl Stopwatch {
    /// Begins at rest.
    pub fn new(limits: Limits) -> Self {
        Self { limits, chain: Vec::new(), seconds: 0.0, most_legs: MOST_LEGS }
    }

    /// The next event.
    pub fn take(&mut self, event: &Event) {
        self.take_to(event, &mut |_| {});
    }

    /// The next event; tells the paces of all motions and pauses that are now certain, in their
    /// order.
    pub(super) fn take_to(&mut self, event: &Event, told: &mut impl FnMut(Pace)) {
        match event {
            Event::Motion(motion) => self.motion(motion, told),
            Event::Heat { wait: Wait::No, .. } => {}
            Event::ToolChange { .. }
            | Event::Heat { .. }
            | Event::HeatersOff { .. }
            | Event::MotorsOff { .. } => self.stop(told),
            Event::Pause { seconds, .. } => self.rest(*seconds, told),
        }
    }

    /// The head comes to rest, and stays so for a while.
    fn rest(&mut self, seconds: f64, told: &mut impl FnMut(Pace)) {
        self.stop(told);
        self.seconds += seconds;
        told(Pace::rest(seconds));
    }

    fn motion(&mut self, motion: &Motion, told: &mut impl FnMut(Pace)) {
        let length = motion.length_mm();
        if length <= 0.0 {
            // Filament alone: the head stands meanwhile.
            self.rest(motion.extruded_mm.abs() / motion.feed_mm_s, told);
            return;
        }
        let direction = [0, 1, 2].map(|axis| (motion.to_mm[axis] - motion.from_mm[axis]) / length);
        let cruise = motion.feed_mm_s.min(self.limits.greatest_mm_s);
        let acceleration = motion.acceleration_mm_s2.unwrap_or(self.limits.acceleration_mm_s2);
        let mut leg =
            Leg { length, acceleration, cruise2: cruise * cruise, junction2: 0.0, direction };
        if let Some(before) = self.chain.last() {
            leg.junction2 = before.junction2_to(&leg, self.limits.square_corner_mm_s);
        }
        self.chain.push(leg);
        if self.chain.len() >= self.most_legs {
            self.settle(told);
        }
    }

    /// The head comes to rest.
    pub(super) fn stop(&mut self, told: &mut impl FnMut(Pace)) {
        let speeds = speeds2(&self.chain, 0.0);
        self.pass(self.chain.len(), &speeds, told);
    }

    /// Lets go of the legs whose speeds are the same whatever comes.
    ///
    /// The speeds lie between those with a stop behind the last leg and those without any limit
    /// there.
    /// Where both agree they agree in all legs before too: what slows down in one of them only
    /// would have to do so in every leg up to the last.
    fn settle(&mut self, told: &mut impl FnMut(Pace)) {
        let (least, greatest) = (speeds2(&self.chain, 0.0), speeds2(&self.chain, f64::INFINITY));
        let settled = least.iter().zip(&greatest).rposition(|(least, greatest)| least >= greatest);
        // At least half of them, lest each leg be looked at again and again.
        let settled = settled.unwrap_or(0).max(self.chain.len() / 2);
        self.pass(settled, &least, told);
        if let Some(first) = self.chain.first_mut() {
            first.junction2 = least[settled];
        }
    }

    /// Counts the time of the first legs, and lets go of them.
    fn pass(&mut self, legs: usize, speeds: &[f64], told: &mut impl FnMut(Pace)) {
        let passed = self.chain.drain(..legs).zip(speeds.windows(2));
        let paces = passed.map(|(leg, ends)| leg.pace(ends[0], ends[1]));
        self.seconds += paces.inspect(|&pace| told(pace)).map(|pace| pace.seconds()).sum::<f64>();
    }

    /// The time until the head rests after the last event, in s.
    pub fn seconds(mut self) -> f64 {
        self.stop(&mut |_| {});
        self.seconds
    }
}

impl Leg {
    /// Square of the greatest speed through the corner between this leg and the next.
    fn junction2_to(&self, next: &Self, square_corner: f64) -> f64 {
        let straight: f64 = (0..3).map(|axis| self.direction[axis] * next.direction[axis]).sum();
        let limit = self.cruise2.min(next.cruise2);
        // Half the angle between the legs, of which straight on is a right one.
        let sine = (0.5 * (1.0 + straight)).clamp(0.0, 1.0).sqrt();
        // δ a, in which the acceleration cancels out.
        let corner2 = square_corner * square_corner * (std::f64::consts::SQRT_2 - 1.0);
        if 1.0 - sine < 1e-9 { limit } else { limit.min(corner2 * sine / (1.0 - sine)) }
    }

    /// By how much the square of the speed can change along it.
    fn change2(&self) -> f64 {
        2.0 * self.acceleration * self.length
    }

    /// From one speed to another, both given as squares and within reach of each other.
    fn pace(&self, begin2: f64, end2: f64) -> Pace {
        let peak2 = self.cruise2.min(f64::midpoint(begin2, end2) + self.change2() / 2.0);
        Pace::motion(self.length, self.acceleration, [begin2, peak2, end2])
    }
}

/// Squares of the speeds at the ends of the legs, from the first one's junction to `end2`: the
/// greatest that break no limit.
///
/// Backwards, each leg must be able to slow down to what follows; then forwards, to speed up from
/// what comes before.
fn speeds2(chain: &[Leg], end2: f64) -> Vec<f64> {
    let mut speeds: Vec<f64> = chain.iter().map(|leg| leg.junction2).chain([end2]).collect();
    for (at, leg) in chain.iter().enumerate().rev() {
        speeds[at] = speeds[at].min(speeds[at + 1] + leg.change2());
    }
    for (at, leg) in chain.iter().enumerate() {
        speeds[at + 1] = speeds[at + 1].min(speeds[at] + leg.change2());
    }
    speeds
}

#[cfg(test)]
mod tests;
