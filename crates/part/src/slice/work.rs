//! Progress of work that several threads share.

use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{Control, Interrupted};

/// Counts units of work, polls for interruption before each and reports progress after it.
pub(super) struct Work<'a> {
    control: &'a Control<'a>,
    done: AtomicUsize,
    total: usize,
}

impl<'a> Work<'a> {
    pub(super) fn new(control: &'a Control<'a>, total: usize) -> Self {
        Self { control, done: AtomicUsize::new(0), total }
    }

    pub(super) fn control(&self) -> &'a Control<'a> {
        self.control
    }

    /// Runs one unit, unless the call should end.
    pub(super) fn unit<T>(&self, run: impl FnOnce() -> T) -> Result<T, Interrupted> {
        self.control.check()?;
        let result = run();
        self.control.report(self.done.fetch_add(1, Ordering::Relaxed) + 1, self.total);
        Ok(result)
    }
}
