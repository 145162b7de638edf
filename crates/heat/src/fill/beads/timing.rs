//! How long beads and the travel between them take.

use beadwork_gcode::MotionLimits;
use beadwork_part::Bead;
use beadwork_part::print::Process;

/// Speeds of a print of beads.
///
/// The time of a bead is that at constant speed.
/// Travel is a move between two stops if filament is retracted for it, and otherwise one between
/// two corners.
/// [`Program::print_seconds`](beadwork_gcode::Program::print_seconds) of the written program is
/// exact; the planners need only the differences between orders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeadTiming {
    /// Speeds and retraction.
    pub process: Process,
    /// Acceleration of the printer.
    pub limits: MotionLimits,
}

impl BeadTiming {
    /// Both ends of each line of a bead in mm, with its time in s.
    pub(super) fn lines(
        &self,
        bead: &Bead,
        layer: usize,
    ) -> impl Iterator<Item = ([[f64; 2]; 2], f64)> {
        let lines = bead.lines().zip(&bead.moves);
        lines.map(move |((from, to, _), step)| {
            let speed_mm_s = self.process.speed_mm_s(step.feature, false, layer);
            ([from, to], distance_mm(from, to) / speed_mm_s)
        })
    }

    /// Time from the end of a bead to the beginning of another, s; 0 if that is the same position.
    pub(super) fn travel_s(&self, from_mm: [f64; 2], to_mm: [f64; 2]) -> f64 {
        let length_mm = distance_mm(from_mm, to_mm);
        if length_mm < SAME_MM {
            return 0.0;
        }
        let Process { travel_mm_s, retract_mm, retract_mm_s, z_hop_mm, .. } = self.process;
        let corner_mm_s = self.limits.square_corner_mm_s.min(travel_mm_s);
        if length_mm <= self.process.retract_beyond_mm || retract_mm <= 0.0 {
            return self.move_s(length_mm, corner_mm_s);
        }
        let retraction_s = 2.0 * (retract_mm / retract_mm_s + self.move_s(z_hop_mm, 0.0));
        let stops_s = corner_mm_s / self.limits.acceleration_mm_s2;
        stops_s + self.move_s(length_mm, 0.0) + retraction_s
    }

    /// Time of a straight travel move that begins and ends at a speed in mm/s, s.
    fn move_s(&self, length_mm: f64, ends_mm_s: f64) -> f64 {
        let MotionLimits { acceleration_mm_s2, max_speed_mm_s, .. } = self.limits;
        let speed_mm_s = self.process.travel_mm_s.min(max_speed_mm_s);
        let squared = ends_mm_s * ends_mm_s + acceleration_mm_s2 * length_mm;
        if squared <= speed_mm_s * speed_mm_s {
            return 2.0 * (squared.sqrt() - ends_mm_s) / acceleration_mm_s2;
        }
        let ramp_mm_s = speed_mm_s - ends_mm_s;
        length_mm / speed_mm_s + ramp_mm_s * ramp_mm_s / (acceleration_mm_s2 * speed_mm_s)
    }
}

/// Positions that are nearer are the same: less than the resolution of a program.
pub(super) const SAME_MM: f64 = 0.0005;

pub(super) fn distance_mm(from: [f64; 2], to: [f64; 2]) -> f64 {
    libm::hypot(to[0] - from[0], to[1] - from[1])
}
