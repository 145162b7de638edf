//! The speed of the nozzle over one motion: a trapezoid over time.
//!
//! With a constant acceleration a, the square of the speed changes linearly with the distance s: v²
//! = v₀² + 2 a s.
//! So speeding up from v₀ to v takes the distance (v² - v₀²) / 2a and the time (v - v₀) / a.

/// How a motion or a pause proceeds over time: the nozzle speeds up, moves at constant speed and
/// slows down, or it stands still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedProfile {
    seconds: f64,
    /// `None` while the nozzle stands still.
    trapezoid: Option<Trapezoid>,
}

/// Lengths in mm, speeds in mm/s, acceleration in mm/s².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trapezoid {
    length: f64,
    acceleration: f64,
    start: f64,
    cruise: f64,
    end: f64,
    /// Distances of speeding up and of slowing down.
    ramps: [f64; 2],
}

impl SpeedProfile {
    /// A pause, or extrusion or retraction while the nozzle stands still.
    pub(crate) fn standstill(seconds: f64) -> Self {
        Self { seconds, trapezoid: None }
    }

    /// A motion, given the squares of its speeds at the start, at constant speed and at the end.
    pub(crate) fn motion(length: f64, acceleration: f64, speeds2: [f64; 3]) -> Self {
        let [start2, cruise2, end2] = speeds2;
        let [start, cruise, end] = speeds2.map(f64::sqrt);
        let ramp_length = (2.0 * cruise2 - start2 - end2) / (2.0 * acceleration);
        let ramp_seconds = (2.0 * cruise - start - end) / acceleration;
        let seconds = ramp_seconds + (length - ramp_length).max(0.0) / cruise;
        let ramps = [start2, end2].map(|speed2| (cruise2 - speed2) / (2.0 * acceleration));
        let trapezoid = Trapezoid { length, acceleration, start, cruise, end, ramps };
        Self { seconds, trapezoid: Some(trapezoid) }
    }

    /// Duration in s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Time from the start until the nozzle has moved `distance_mm`, in s.
    /// `distance_mm` ranges from 0 to the length of the motion.
    ///
    /// While the nozzle stands still, this is the whole duration.
    pub fn seconds_to(&self, distance_mm: f64) -> f64 {
        let Some(Trapezoid { length, acceleration, start, cruise, end, ramps: [up, down] }) =
            self.trapezoid
        else {
            return self.seconds;
        };
        let remaining = length - distance_mm;
        let speed_after = |from: f64, distance: f64| {
            (from * from + 2.0 * acceleration * distance.max(0.0)).sqrt()
        };
        let seconds = if distance_mm < up {
            (speed_after(start, distance_mm) - start) / acceleration
        } else if remaining < down {
            // Slowing down is speeding up from the end, with time running backwards.
            self.seconds - (speed_after(end, remaining) - end) / acceleration
        } else {
            (cruise - start) / acceleration + (distance_mm - up) / cruise
        };
        seconds.clamp(0.0, self.seconds)
    }
}
