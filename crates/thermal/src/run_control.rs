//! Interruption and progress of a call, as the steppers see them.

use std::cell::Cell;

use beadwork_base::{Control, Interrupted};

use crate::interval::Interval;

/// Voxel updates between two polls of the caller's control: some 100 µs of work.
///
/// A voxel update is one stage of one voxel.
/// On small parts a step takes a microsecond, and a poll that reads a clock would not be much
/// cheaper.
const UPDATES_PER_POLL: usize = 1 << 18;

/// Control of one call to the steppers: polls the caller's [`Control`], reports the number of
/// complete events, and counts the simulated time in case the call is interrupted.
///
/// Steppers poll only while all voxels of the part have reached the same time, so that an
/// interrupted simulation is in a valid state.
pub(crate) struct RunControl<'a> {
    control: &'a Control<'a>,
    /// Events of the call.
    total: usize,
    /// Events that are complete.
    done: Cell<usize>,
    /// `done` as last reported.
    reported: Cell<usize>,
    /// Simulated time since [`RunControl::restart_clock`], s.
    passed_s: Cell<f64>,
    /// Voxel updates since the last poll.
    updates: Cell<usize>,
}

impl<'a> RunControl<'a> {
    /// For a call that runs through `total` events.
    pub(crate) fn new(control: &'a Control<'a>, total: usize) -> Self {
        let [done, reported, updates] = [0; 3].map(Cell::new);
        Self { control, total, done, reported, passed_s: Cell::new(0.0), updates }
    }

    /// Counts `updates` voxel updates that are about to be made, and returns an error if the call
    /// should end before them.
    pub(crate) fn poll(&self, updates: usize) -> Result<(), Interrupted> {
        let counted = self.updates.get().saturating_add(updates);
        if counted < UPDATES_PER_POLL {
            self.updates.set(counted);
            return Ok(());
        }
        self.updates.set(0);
        if self.reported.replace(self.done.get()) != self.done.get() {
            self.control.report(self.done.get(), self.total);
        }
        self.control.check()
    }

    /// Notes that the whole part has been stepped through some time.
    pub(crate) fn pass(&self, seconds: f64) {
        self.passed_s.set(self.passed_s.get() + seconds);
    }

    /// Notes that the end of an interval has been reached.
    pub(crate) fn complete(&self, interval: &Interval) {
        if let Some(done) = interval.completes {
            self.done.set(done);
        }
    }

    /// Simulated time since [`RunControl::restart_clock`], s.
    pub(crate) fn passed_s(&self) -> f64 {
        self.passed_s.get()
    }

    /// Starts to count simulated time from 0.
    pub(crate) fn restart_clock(&self) {
        self.passed_s.set(0.0);
    }

    /// Reports that all events are complete.
    pub(crate) fn finish(&self) {
        self.control.report(self.total, self.total);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use beadwork_base::{CancelToken, Progress};

    use super::*;

    #[test]
    fn polls_are_rare_and_report_what_is_complete() {
        let (cancel, reports) = (CancelToken::new(), Mutex::new(Vec::new()));
        let report = |Progress { done, total }| reports.lock().unwrap().push((done, total));
        let control =
            Control { cancel: Some(&cancel), progress: Some(&report), ..Control::default() };
        let run = RunControl::new(&control, 7);
        cancel.cancel();
        assert_eq!(run.poll(UPDATES_PER_POLL - 1), Ok(()));
        run.complete(&Interval { held: None, born: false, seconds: 1.0, completes: Some(3) });
        run.complete(&Interval { held: None, born: false, seconds: 1.0, completes: None });
        assert_eq!(run.poll(1), Err(Interrupted::Cancelled));
        assert_eq!(run.poll(UPDATES_PER_POLL - 1), Ok(()));
        assert_eq!(run.poll(usize::MAX), Err(Interrupted::Cancelled));
        run.finish();
        assert_eq!(*reports.lock().unwrap(), [(3, 7), (7, 7)]);
    }

    #[test]
    fn time_is_counted_from_the_last_restart() {
        let control = Control::default();
        let run = RunControl::new(&control, 0);
        run.pass(1.5);
        run.restart_clock();
        run.pass(0.25);
        run.pass(0.25);
        assert_eq!(run.passed_s().to_bits(), 0.5_f64.to_bits());
    }
}
