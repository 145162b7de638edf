//! When the head is where: the time of each motion, and of each stretch of it.

use std::collections::VecDeque;

use crate::{Event, Limits, Program, Stopwatch, Trace, TraceError};

/// How a motion or a pause goes on: speeding up, at one speed, slowing down; or standing still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    seconds: f64,
    /// `None` while the head stands.
    way: Option<Way>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    length: f64,
    acceleration: f64,
    begin: f64,
    peak: f64,
    end: f64,
    /// Lengths of speeding up and slowing down.
    ramps: [f64; 2],
}

impl Pace {
    pub(super) fn rest(seconds: f64) -> Self {
        Self { seconds, way: None }
    }

    /// A motion that begins, peaks and ends at speeds given as squares.
    pub(super) fn motion(length: f64, acceleration: f64, speeds2: [f64; 3]) -> Self {
        let [begin2, peak2, end2] = speeds2;
        let [begin, peak, end] = speeds2.map(f64::sqrt);
        let both = (2.0 * peak2 - begin2 - end2) / (2.0 * acceleration);
        let changing = (2.0 * peak - begin - end) / acceleration;
        let seconds = changing + (length - both).max(0.0) / peak;
        let ramps = [begin2, end2].map(|speed2| (peak2 - speed2) / (2.0 * acceleration));
        Self { seconds, way: Some(Way { length, acceleration, begin, peak, end, ramps }) }
    }

    /// How long it takes, in s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// How long it takes the head to get so far from the beginning, in s.
    /// `way_mm` is from 0 to the motion's length.
    ///
    /// All of it while the head stands.
    pub fn seconds_to(&self, way_mm: f64) -> f64 {
        let Some(Way { length, acceleration, begin, peak, end, ramps: [up, down] }) = self.way
        else {
            return self.seconds;
        };
        let left = length - way_mm;
        let faster = |from: f64, way: f64| (from * from + 2.0 * acceleration * way.max(0.0)).sqrt();
        let seconds = if way_mm < up {
            (faster(begin, way_mm) - begin) / acceleration
        } else if left < down {
            self.seconds - (faster(end, left) - end) / acceleration
        } else {
            (peak - begin) / acceleration + (way_mm - up) / peak
        };
        seconds.clamp(0.0, self.seconds)
    }
}

impl Program {
    /// The motions and pauses of the program in order, each with its pace; it ends after an error.
    /// Linear in all.
    ///
    /// The paces add up to [`Program::print_seconds`].
    pub fn paced(&self, limits: Limits) -> Paced<'_> {
        Paced {
            trace: Some(self.trace()),
            watch: Stopwatch::new(limits),
            waiting: VecDeque::new(),
            paces: VecDeque::new(),
            error: None,
        }
    }
}

/// The motions and pauses of a program with their paces, from [`Program::paced`].
#[derive(Debug)]
pub struct Paced<'a> {
    /// `None` after its end.
    trace: Option<Trace<'a>>,
    watch: Stopwatch,
    /// Events whose pace is still open, for it depends on what follows, and those whose pace is
    /// known.
    waiting: VecDeque<Event>,
    paces: VecDeque<Pace>,
    error: Option<TraceError>,
}

impl Iterator for Paced<'_> {
    type Item = Result<(Event, Pace), TraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(pace) = self.paces.pop_front() {
                let event = self.waiting.pop_front().expect("a pace is that of an event");
                return Some(Ok((event, pace)));
            }
            let Some(trace) = &mut self.trace else { return self.error.take().map(Err) };
            match trace.next() {
                Some(Ok(event)) => {
                    if matches!(event, Event::Motion(_) | Event::Pause { .. }) {
                        self.waiting.push_back(event);
                    }
                    self.watch.take_to(&event, &mut |pace| self.paces.push_back(pace));
                }
                end => {
                    self.error = end.and_then(Result::err);
                    self.trace = None;
                    self.watch.stop(&mut |pace| self.paces.push_back(pace));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LIMITS: Limits =
        Limits { acceleration_mm_s2: 1000.0, square_corner_mm_s: 5.0, greatest_mm_s: 300.0 };

    fn near(got: f64, expected: f64) {
        assert!((got - expected).abs() < 1e-9, "{got}, not {expected}");
    }

    #[test]
    fn a_motion_speeds_up_and_slows_down() {
        let program = Program::parse("G1 X100 F6000\nG4 P500").unwrap();
        let paced: Vec<_> = program.paced(LIMITS).collect::<Result<_, _>>().unwrap();
        let [(Event::Motion(_), motion), (Event::Pause { .. }, pause)] = paced[..] else {
            panic!("{paced:?}")
        };
        // To 100 mm/s in 0.1 s and 5 mm.
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
    fn what_precedes_an_error_is_told() {
        let program = Program::parse("G1 X10 F600\nG1 Y10\nG20\nG1 X0").unwrap();
        let paced: Vec<_> = program.paced(LIMITS).collect();
        assert_eq!(paced.iter().map(Result::is_ok).collect::<Vec<_>>(), [true, true, false]);
    }

    proptest! {
        #[test]
        fn paces_add_up_to_the_print(
            moves in prop::collection::vec((0..4_u8, 0..30_i32, 0..30_i32, 1..200_u32), 1..60),
        ) {
            let line = |&(kind, x, y, speed): &(u8, i32, i32, u32)| match kind {
                0 => format!("G4 P{speed}\n"),
                1 => format!("M104 S{speed}\nG1 E{x} F{}\n", 60 * speed),
                _ => format!("G1 X{x} Y{y} E0 F{}\n", 60 * speed),
            };
            let text: String = moves.iter().map(line).collect();
            let program = Program::parse(&text).unwrap();
            let total = program.print_seconds(LIMITS).unwrap();
            let mut sum = 0.0;
            for step in program.paced(LIMITS) {
                let (event, pace) = step.unwrap();
                sum += pace.seconds();
                let Event::Motion(motion) = event else { continue };
                let length = motion.length_mm();
                let times: Vec<f64> =
                    (0..=20).map(|part| pace.seconds_to(length * f64::from(part) / 20.0)).collect();
                prop_assert!(times.is_sorted(), "{times:?}");
                prop_assert!((times[20] - pace.seconds()).abs() < 1e-8, "{pace:?} {times:?}");
            }
            prop_assert!((sum - total).abs() < 1e-9 * (1.0 + total), "{} of {}", sum, total);
        }
    }
}
