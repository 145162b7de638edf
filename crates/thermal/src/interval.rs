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
}

/// Total length of some intervals, s.
pub(crate) fn total_seconds<'a>(intervals: impl IntoIterator<Item = &'a Interval>) -> f64 {
    intervals.into_iter().map(|interval| interval.seconds).sum()
}
