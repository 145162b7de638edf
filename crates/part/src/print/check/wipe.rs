//! Checks that filament is retracted in place, or on the way back along the bead just printed.

use beadwork_gcode::Motion;

use super::error::CheckError;
use super::tolerance;

/// Deviation of a wipe from the bead in mm: its last position is rounded.
const DEVIATION_MM: f64 = 1.5 * tolerance::POSITION_MM;

/// Tracks the way back along the bead just printed.
pub(super) struct WipeTracker {
    /// Maximum length of a wipe in mm.
    max_mm: f64,
    /// The positions of the bead up to that of the nozzle; empty after travel.
    trail: Vec<[f64; 3]>,
    /// Length of the way back so far, in mm.
    wiped_mm: f64,
}

impl WipeTracker {
    pub(super) fn new(max_mm: f64) -> Self {
        Self { max_mm, trail: Vec::new(), wiped_mm: 0.0 }
    }

    /// Follows a motion that extrudes.
    pub(super) fn extrusion(&mut self, motion: &Motion) {
        if self.wiped_mm > 0.0 {
            self.trail.clear();
            self.wiped_mm = 0.0;
        }
        if self.trail.is_empty() {
            self.trail.push(motion.from_mm);
        }
        self.trail.push(motion.to_mm);
    }

    /// Checks a motion that does not extrude.
    pub(super) fn other(&mut self, motion: &Motion) -> Result<(), CheckError> {
        let length_mm = motion.length_mm();
        if length_mm <= 0.0 {
            return Ok(());
        }
        let is_back = self.step_back(motion.to_mm);
        self.wiped_mm += length_mm;
        let is_wipe = is_back && self.wiped_mm <= self.max_mm + tolerance::POSITION_MM;
        if motion.extruded_mm < 0.0 && !is_wipe {
            let [x, y, _] = motion.to_mm;
            return Err(CheckError::Wipe { line: motion.line, to_mm: [x, y] });
        }
        if !is_back {
            self.trail.clear();
            self.wiped_mm = 0.0;
        }
        Ok(())
    }

    /// Moves back to a position on the last line of the trail; returns whether it lies there.
    fn step_back(&mut self, to: [f64; 3]) -> bool {
        let [.., before, last] = self.trail[..] else { return false };
        let is_back = distance_mm(before, to) + distance_mm(to, last)
            <= distance_mm(before, last) + 2.0 * DEVIATION_MM
            && distance_to_line_mm(to, before, last) <= DEVIATION_MM;
        if is_back {
            self.trail.pop();
            if distance_mm(before, to) > tolerance::POSITION_MM / 2.0 {
                self.trail.push(to);
            }
        }
        is_back
    }
}

/// Distance of a point from the line segment between two others.
fn distance_to_line_mm(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let along = sub(to, from);
    let length2 = dot(along, along);
    let share = if length2 > 0.0 { dot(sub(point, from), along) / length2 } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    distance_mm(point, [0, 1, 2].map(|axis| from[axis] + share * along[axis]))
}

fn distance_mm(a: [f64; 3], b: [f64; 3]) -> f64 {
    let offset = sub(a, b);
    dot(offset, offset).sqrt()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
