//! The motions and pauses of a program, with the time that each takes.

use std::collections::VecDeque;

use crate::event::{Event, TraceError};
use crate::program::Program;
use crate::speed_profile::SpeedProfile;
use crate::time::{MotionLimits, Stopwatch};
use crate::trace::Trace;

impl Program {
    /// Returns an iterator over the motions and pauses of the program, in order, each with its
    /// speed profile.
    /// It ends after an error.
    ///
    /// The durations add up to [`Program::print_seconds`].
    /// Linear in lines and chords; nothing is computed before the iterator is advanced.
    pub fn timed_events(&self, limits: MotionLimits) -> TimedEvents<'_> {
        TimedEvents {
            trace: Some(self.trace()),
            stopwatch: Stopwatch::new(limits),
            events: VecDeque::new(),
            profiles: VecDeque::new(),
            error: None,
        }
    }
}

/// Iterator over the motions and pauses of a program, from [`Program::timed_events`].
#[derive(Debug)]
pub struct TimedEvents<'a> {
    /// `None` after its end.
    trace: Option<Trace<'a>>,
    stopwatch: Stopwatch,
    /// Motions and pauses that were traced and not yet returned.
    events: VecDeque<Event>,
    /// The profiles of the first of them.
    /// Those of the others are still open: how a motion ends depends on the motions after it.
    profiles: VecDeque<SpeedProfile>,
    error: Option<TraceError>,
}

impl Iterator for TimedEvents<'_> {
    type Item = Result<(Event, SpeedProfile), TraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(profile) = self.profiles.pop_front() {
                let event = self.events.pop_front().expect("each profile belongs to an event");
                return Some(Ok((event, profile)));
            }
            let Some(trace) = &mut self.trace else { return self.error.take().map(Err) };
            match trace.next() {
                Some(Ok(event)) => {
                    if matches!(event, Event::Motion(_) | Event::Pause { .. }) {
                        self.events.push_back(event);
                    }
                    self.stopwatch
                        .add_event(&event, &mut |profile| self.profiles.push_back(profile));
                }
                end => {
                    self.error = end.and_then(Result::err);
                    self.trace = None;
                    self.stopwatch.stop(&mut |profile| self.profiles.push_back(profile));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;
    use proptest::prelude::*;

    use super::*;

    const LIMITS: MotionLimits =
        MotionLimits { acceleration_mm_s2: 1000.0, square_corner_mm_s: 5.0, max_speed_mm_s: 300.0 };

    fn near(got: f64, expected: f64) {
        assert!((got - expected).abs() < 1e-9, "{got}, not {expected}");
    }

    #[test]
    fn a_motion_speeds_up_and_slows_down() {
        let program = "G1 X100 F6000\nG4 P500".parse::<Program>().unwrap();
        let timed: Vec<_> = program.timed_events(LIMITS).collect::<Result<_, _>>().unwrap();
        let [(Event::Motion(_), motion), (Event::Pause { .. }, pause)] = timed[..] else {
            panic!("{timed:?}")
        };
        // Up to 100 mm/s in 0.1 s and 5 mm.
        near(motion.seconds(), 1.1);
        near(motion.seconds_to(0.0), 0.0);
        near(motion.seconds_to(1.25), 0.05);
        near(motion.seconds_to(5.0), 0.1);
        near(motion.seconds_to(50.0), 0.55);
        near(motion.seconds_to(98.75), 1.05);
        near(motion.seconds_to(100.0), 1.1);
        near(pause.seconds(), 0.5);
        near(pause.seconds_to(0.0), 0.5);
    }

    #[test]
    fn events_before_an_error_are_returned() {
        let program = "G1 X10 F600\nG1 Y10\nG20\nG1 X0".parse::<Program>().unwrap();
        let timed: Vec<_> = program.timed_events(LIMITS).collect();
        assert_eq!(timed.iter().map(Result::is_ok).collect::<Vec<_>>(), [true, true, false]);
    }

    proptest! {
        #[test]
        fn durations_add_up_to_the_printing_time(
            moves in prop::collection::vec((0..4_u8, 0..30_i32, 0..30_i32, 1..200_u32), 1..60),
        ) {
            let line = |&(kind, x, y, speed): &(u8, i32, i32, u32)| match kind {
                0 => format!("G4 P{speed}\n"),
                1 => format!("M104 S{speed}\nG1 E{x} F{}\n", 60 * speed),
                _ => format!("G1 X{x} Y{y} E0 F{}\n", 60 * speed),
            };
            let text: String = moves.iter().map(line).collect();
            let program = text.parse::<Program>().unwrap();
            let total = program.print_seconds(LIMITS, &Control::default()).unwrap();
            let mut sum = 0.0;
            for step in program.timed_events(LIMITS) {
                let (event, profile) = step.unwrap();
                sum += profile.seconds();
                let Event::Motion(motion) = event else { continue };
                let length = motion.length_mm();
                let distances = (0..=20).map(|part| length * f64::from(part) / 20.0);
                let times: Vec<f64> = distances.map(|mm| profile.seconds_to(mm)).collect();
                prop_assert!(times.is_sorted(), "{times:?}");
                prop_assert!((times[20] - profile.seconds()).abs() < 1e-8, "{profile:?} {times:?}");
            }
            prop_assert!((sum - total).abs() < 1e-9 * (1.0 + total), "{} of {}", sum, total);
        }
    }
}
