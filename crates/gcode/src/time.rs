//! Printing time, computed as the motion planner of the firmware plans it.
//!
//! # Look-ahead planning
//! The nozzle accelerates at a constant rate and may pass each corner between two motions only at a
//! limited speed (the *junction speed*).
//! The planner maximises the speed at every corner under three limits:
//!
//! - the junction speed,
//! - the nozzle must be able to slow down in time for every later corner and for the final stop,
//! - the nozzle must have had enough distance to reach that speed.
//!
//! Because v² = v₀² + 2 a s is linear in the distance s, each motion limits the *squares* of the
//! speeds at its two ends to a difference of at most 2 a · length.
//! Two passes over the motions, one from the last to the first and one from the first to the last,
//! find the maximum speeds (see [`corner_speeds2`]).
//!
//! # Junction speeds
//! The rule is Klipper's (documentation, page "Kinematics", section "Look-ahead").
//! Let θ be the angle between two motions, π if they are in line.
//! Imagine a circle that is tangent to both and passes the corner at the distance δ, the *junction
//! deviation*.
//! Its radius is R = δ sin(θ/2) / (1 - sin(θ/2)), and the centripetal acceleration on it equals a
//! at the speed v² = R a, which becomes the limit. δ is chosen such that a right angle is passed at
//! the square corner speed s: δ = s² (√2 - 1) / a.
//! Marlin's junction deviation (`M205 J`) follows the same rule.

use std::f64::consts::SQRT_2;

use beadwork_base::Control;

use crate::command::Wait;
use crate::event::{Event, Motion, TraceError};
use crate::program::Program;
use crate::speed_profile::SpeedProfile;

/// The limits of the printer that determine printing times.
///
/// They hold throughout a program: of the limits that a program can set, only accelerations
/// (`M204`, and `ACCEL` of `SET_VELOCITY_LIMIT`) are followed.
/// Not modelled are other limits that a program sets (`M205` and the rest of `SET_VELOCITY_LIMIT`),
/// limits of single axes (`M203`), Klipper's smoothing of short moves (minimum cruise ratio, and
/// its limit at corners of short moves), pressure advance, acceleration of retractions (`M204 R`),
/// and Klipper's limit where the flow changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Acceleration in mm/s², more than 0, of motions for which the program sets none.
    pub acceleration_mm_s2: f64,
    /// Speed through a right angle in mm/s, at least 0; 0 means a stop at every corner.
    pub square_corner_mm_s: f64,
    /// Maximum speed in mm/s, more than 0.
    pub max_speed_mm_s: f64,
}

/// Sums up the time of events that are added one by one.
///
/// Tool changes and waiting for heaters stop the nozzle; their own time is not included.
///
/// Linear in the number of events.
/// Holds the motions since the last stop, at most 65,536.
/// When that many are held, at least the older half gets its final speeds.
/// The times stay exact as long as the nozzle can stop within the newer half, as in any real print;
/// otherwise they are slightly too long.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    limits: MotionLimits,
    /// The motions since the last stop whose speeds are not fixed yet.
    queue: Vec<PlannedMotion>,
    /// Time of everything before the queue.
    seconds: f64,
    max_queue: usize,
}

/// Maximum length of the queue.
/// It needs one because a program may contain no stop, and an arc of a few bytes becomes hundreds
/// of motions.
const MAX_QUEUE: usize = 1 << 16;

/// A motion in the queue.
/// Lengths in mm, squared speeds in mm²/s², acceleration in mm/s².
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlannedMotion {
    length: f64,
    acceleration: f64,
    /// Square of the requested speed.
    cruise2: f64,
    /// Square of the maximum speed through the corner at its start.
    junction2: f64,
    /// Unit vector.
    direction: [f64; 3],
}

impl Program {
    /// Computes the printing time in s; [`MotionLimits`] and [`Stopwatch`] list what is not
    /// included.
    ///
    /// Linear in lines and chords of arcs.
    /// Progress counts lines.
    pub fn print_seconds(
        &self,
        limits: MotionLimits,
        control: &Control<'_>,
    ) -> Result<f64, TraceError> {
        let mut stopwatch = Stopwatch::new(limits);
        self.for_each_event(control, |event| stopwatch.add(event))?;
        Ok(stopwatch.seconds())
    }
}

impl Stopwatch {
    /// Creates a stopwatch at 0 s, with the nozzle at rest.
    pub fn new(limits: MotionLimits) -> Self {
        Self { limits, queue: Vec::new(), seconds: 0.0, max_queue: MAX_QUEUE }
    }

    /// Adds the next event.
    pub fn add(&mut self, event: &Event) {
        self.add_event(event, &mut |_| {});
    }

    /// The time in s until the nozzle rests after the last event.
    pub fn seconds(mut self) -> f64 {
        self.stop(&mut |_| {});
        self.seconds
    }

    /// Adds the next event, and emits the profiles of all motions and pauses that have become
    /// fixed, in order.
    pub(crate) fn add_event(&mut self, event: &Event, emit: &mut impl FnMut(SpeedProfile)) {
        match event {
            Event::Motion(motion) => self.add_motion(motion, emit),
            Event::Heat { wait: Wait::No, .. } => {}
            Event::ToolChange { .. }
            | Event::Heat { .. }
            | Event::HeatersOff { .. }
            | Event::MotorsOff { .. } => self.stop(emit),
            Event::Pause { seconds, .. } => self.stand_still(*seconds, emit),
        }
    }

    fn add_motion(&mut self, motion: &Motion, emit: &mut impl FnMut(SpeedProfile)) {
        let length = motion.length_mm();
        if length <= 0.0 {
            // Only filament moves.
            self.stand_still(motion.extruded_mm.abs() / motion.feed_mm_s, emit);
            return;
        }
        let direction = [0, 1, 2].map(|axis| (motion.to_mm[axis] - motion.from_mm[axis]) / length);
        let cruise = motion.feed_mm_s.min(self.limits.max_speed_mm_s);
        let acceleration = motion.acceleration_mm_s2.unwrap_or(self.limits.acceleration_mm_s2);
        let cruise2 = cruise * cruise;
        // The first motion after a stop starts at rest.
        let mut next = PlannedMotion { length, acceleration, cruise2, junction2: 0.0, direction };
        if let Some(last) = self.queue.last() {
            next.junction2 = last.junction2_to(&next, self.limits.square_corner_mm_s);
        }
        self.queue.push(next);
        if self.queue.len() >= self.max_queue {
            self.flush_fixed(emit);
        }
    }

    /// The nozzle comes to rest, and stands still for some time.
    fn stand_still(&mut self, seconds: f64, emit: &mut impl FnMut(SpeedProfile)) {
        self.stop(emit);
        self.seconds += seconds;
        emit(SpeedProfile::standstill(seconds));
    }

    /// The nozzle comes to rest: the speeds of all motions in the queue are now fixed.
    pub(crate) fn stop(&mut self, emit: &mut impl FnMut(SpeedProfile)) {
        let speeds2 = corner_speeds2(&self.queue, 0.0);
        self.flush(self.queue.len(), &speeds2, emit);
    }

    /// Removes the motions from the queue whose speeds no later motion can change.
    ///
    /// Later motions influence the queue only through the speed at its end, and a higher speed
    /// there lowers none of the others.
    /// So the final speeds lie between `min`, for a stop at the end, and `max`, for no limit there.
    /// A corner that is slower in `min` is so because of the stop: the nozzle slows down from it
    /// through every motion up to the end, and all corners on the way are slower too.
    /// Hence a corner where `min` and `max` agree is fixed, and so are all corners before it.
    fn flush_fixed(&mut self, emit: &mut impl FnMut(SpeedProfile)) {
        let min = corner_speeds2(&self.queue, 0.0);
        let max = corner_speeds2(&self.queue, f64::INFINITY);
        let fixed = min.iter().zip(&max).rposition(|(min, max)| min >= max);
        // Always remove at least half of the queue: otherwise the same motions would be planned
        // again after every further motion, in quadratic time.
        let fixed = fixed.unwrap_or(0).max(self.queue.len() / 2);
        self.flush(fixed, &min, emit);
        if let Some(first) = self.queue.first_mut() {
            // The speed at which the removed motions end.
            first.junction2 = min[fixed];
        }
    }

    /// Removes the first motions of the queue, and adds up their time.
    fn flush(&mut self, count: usize, speeds2: &[f64], emit: &mut impl FnMut(SpeedProfile)) {
        let flushed = self.queue.drain(..count).zip(speeds2.windows(2));
        let profiles = flushed.map(|(motion, ends)| motion.profile(ends[0], ends[1]));
        self.seconds += profiles
            .inspect(|&profile| emit(profile))
            .map(|profile| profile.seconds())
            .sum::<f64>();
    }
}

impl PlannedMotion {
    /// Square of the maximum speed through the corner between this motion and the next.
    fn junction2_to(&self, next: &Self, square_corner: f64) -> f64 {
        let cosine: f64 = (0..3).map(|axis| self.direction[axis] * next.direction[axis]).sum();
        let limit = self.cruise2.min(next.cruise2);
        // sin(θ/2), from the cosine of the change of direction, which is π - θ.
        let sine = (0.5 * (1.0 + cosine)).clamp(0.0, 1.0).sqrt();
        // δ a, which does not depend on the acceleration.
        let deviation2 = square_corner * square_corner * (SQRT_2 - 1.0);
        // In line, the circle is infinitely large.
        if 1.0 - sine < 1e-9 { limit } else { limit.min(deviation2 * sine / (1.0 - sine)) }
    }

    /// Maximum difference between the squares of the speeds at its ends.
    fn max_change2(&self) -> f64 {
        2.0 * self.acceleration * self.length
    }

    /// The speed profile between two end speeds, given as squares that differ by at most
    /// [`max_change2`](Self::max_change2).
    fn profile(&self, start2: f64, end2: f64) -> SpeedProfile {
        // Without a limit, the nozzle speeds up until it has to slow down again: the ramps meet at
        // the mean of the squared end speeds plus half of the possible change.
        let cruise2 = self.cruise2.min(f64::midpoint(start2, end2) + self.max_change2() / 2.0);
        SpeedProfile::motion(self.length, self.acceleration, [start2, cruise2, end2])
    }
}

/// Squares of the maximum speeds at all corners: one per motion for its start, and `end2`, the
/// limit at the end of the last one.
///
/// The backward pass makes sure that the nozzle can slow down to the speed at the end of each
/// motion, the forward pass that it can speed up from the speed at its start.
/// The forward pass does not break the result of the backward pass: it lowers a speed only where
/// the nozzle speeds up, and never below the speed at the corner before.
fn corner_speeds2(queue: &[PlannedMotion], end2: f64) -> Vec<f64> {
    let mut speeds2: Vec<f64> = queue.iter().map(|motion| motion.junction2).chain([end2]).collect();
    for (index, motion) in queue.iter().enumerate().rev() {
        speeds2[index] = speeds2[index].min(speeds2[index + 1] + motion.max_change2());
    }
    for (index, motion) in queue.iter().enumerate() {
        speeds2[index + 1] = speeds2[index + 1].min(speeds2[index] + motion.max_change2());
    }
    speeds2
}

#[cfg(test)]
mod tests;
