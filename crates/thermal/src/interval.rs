//! Time intervals, the input of the steppers.

/// A stretch of time in which at most one voxel is held at its birth temperature.
///
/// [`crate::Simulation`] turns checked deposition events into these; a stepper may split them
/// further.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    /// x, y and z, with the halo counted, of the voxel under the nozzle, which keeps its birth
    /// temperature; `None` in a pause.
    pub(crate) held: Option<[usize; 3]>,
    /// Whether that voxel becomes active at the start of the interval.
    pub(crate) born: bool,
    /// Length, s, more than 0.
    pub(crate) seconds: f64,
    /// Number of the call's events that are complete at the end of the interval; `None` if its
    /// event goes on after it.
    pub(crate) completes: Option<usize>,
}

impl Interval {
    /// Splits the interval into the smallest number of equal ones no longer than a limit.
    ///
    /// Only the first of them has the birth, and only the last completes an event.
    pub(crate) fn split(self, max_s: f64) -> impl Iterator<Item = Self> {
        // The tolerance keeps rounding errors from adding an interval where `seconds` is a multiple
        // of the limit.
        let count = (self.seconds / max_s - 1e-6).ceil().max(1.0);
        (0..count as usize).map(move |i| Self {
            born: self.born && i == 0,
            seconds: self.seconds / count,
            completes: self.completes.filter(|_| i + 1 == count as usize),
            ..self
        })
    }

    /// Cuts a pause after some time, s, which is less than its length.
    /// Only the second part completes an event.
    pub(crate) fn cut(self, after_s: f64) -> (Self, Self) {
        debug_assert!(self.held.is_none() && after_s < self.seconds, "{self:?}");
        (
            Self { seconds: after_s, completes: None, ..self },
            Self { seconds: self.seconds - after_s, ..self },
        )
    }
}

/// Replaces `own` by some intervals as they concern a window: where the held voxel is not `inside`,
/// the interval is a pause, and consecutive pauses are one.
pub(crate) fn within(
    intervals: &[Interval],
    inside: impl Fn([usize; 3]) -> bool,
    own: &mut Vec<Interval>,
) {
    own.clear();
    for &interval in intervals {
        let held = interval.held.filter(|&position| inside(position));
        match own.last_mut() {
            Some(last) if held.is_none() && last.held.is_none() => last.seconds += interval.seconds,
            _ => own.push(Interval {
                held,
                born: interval.born && held.is_some(),
                completes: None,
                ..interval
            }),
        }
    }
}

/// Total length of some intervals, s.
pub(crate) fn total_seconds<'a>(intervals: impl IntoIterator<Item = &'a Interval>) -> f64 {
    intervals.into_iter().map(|interval| interval.seconds).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn birth(x: usize, seconds: f64) -> Interval {
        Interval { held: Some([x, 1, 1]), born: true, seconds, completes: Some(x) }
    }

    fn pause(seconds: f64) -> Interval {
        Interval { held: None, born: false, seconds, completes: Some(0) }
    }

    #[test]
    fn births_outside_a_window_are_pauses_of_it() {
        let intervals = [birth(1, 0.5), birth(9, 1.0), pause(2.0), birth(8, 4.0), birth(2, 8.0)];
        let mut own = vec![pause(1.0)];
        within(&intervals, |[x, ..]| x < 5, &mut own);
        let parts: Vec<_> =
            own.iter().map(|part| (part.held, part.born, part.seconds, part.completes)).collect();
        let expected = [
            (Some([1, 1, 1]), true, 0.5, None),
            (None, false, 7.0, None),
            (Some([2, 1, 1]), true, 8.0, None),
        ];
        assert_eq!(parts, expected);
        within(&intervals, |_| false, &mut own);
        assert_eq!((own.len(), total_seconds(&own).to_bits()), (1, 15.5_f64.to_bits()));
    }

    #[test]
    fn the_second_part_of_a_pause_completes_its_event() {
        let (first, second) = pause(2.0).cut(0.5);
        assert_eq!((first.seconds, first.completes), (0.5, None));
        assert_eq!((second.seconds, second.completes), (1.5, Some(0)));
    }
}
