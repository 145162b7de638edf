//! Interruption and progress of long loops.

use beadwork_base::{Control, Interrupted};

/// Items between two checks: few enough that they take no longer than some milliseconds, and enough
/// that the checks cost nothing in comparison.
const ITEMS_PER_CHECK: u32 = 1 << 12;

/// Checks for interruption and reports progress once every few thousand items.
///
/// A call makes one or more passes over its data.
/// All passes count as the same number of units of work, whatever the number of items that they
/// visit.
pub(crate) struct Work<'a> {
    control: &'a Control<'a>,
    passes: usize,
    units_per_pass: usize,
    /// Passes that are complete.
    complete: usize,
    /// Items of the current pass.
    items: usize,
    countdown: u32,
}

impl<'a> Work<'a> {
    /// Work of `passes` times `units_per_pass` units, with the first pass about to begin.
    pub(crate) fn new(control: &'a Control<'a>, passes: usize, units_per_pass: usize) -> Self {
        let items = units_per_pass;
        // The first item is a check: a call that is interrupted before it begins does nothing.
        Self { control, passes, units_per_pass, complete: 0, items, countdown: 1 }
    }

    /// Sets the number of items of the current pass, if it is not the number of units.
    pub(crate) fn set_items(&mut self, items: usize) {
        self.items = items;
    }

    /// Completes the current pass.
    pub(crate) fn end_pass(&mut self) {
        self.complete += 1;
        self.items = self.units_per_pass;
        self.control.report(self.complete * self.units_per_pass, self.total());
    }

    /// Call this for every item, before the work on it; `done` is the number of items of this pass
    /// before it.
    #[inline]
    pub(crate) fn tick(&mut self, done: usize) -> Result<(), Interrupted> {
        self.countdown -= 1;
        if self.countdown == 0 { self.check(done) } else { Ok(()) }
    }

    /// Call this for work on `items` items that does not count as progress.
    #[inline]
    pub(crate) fn poll(&mut self, items: usize) -> Result<(), Interrupted> {
        if items < self.countdown as usize {
            self.countdown -= items as u32;
            return Ok(());
        }
        self.countdown = ITEMS_PER_CHECK;
        self.control.check()
    }

    #[cold]
    fn check(&mut self, done: usize) -> Result<(), Interrupted> {
        self.countdown = ITEMS_PER_CHECK;
        self.control.check()?;
        let share = done as u128 * self.units_per_pass as u128 / self.items.max(1) as u128;
        let done = self.complete * self.units_per_pass + (share as usize).min(self.units_per_pass);
        self.control.report(done, self.total());
        Ok(())
    }

    fn total(&self) -> usize {
        self.passes * self.units_per_pass
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use beadwork_base::Progress;

    use super::*;

    #[test]
    fn progress_rises_to_the_total() {
        let seen = Mutex::new(Vec::new());
        let progress = |progress: Progress| seen.lock().unwrap().push(progress);
        let control = Control { progress: Some(&progress), ..Control::default() };
        let mut work = Work::new(&control, 2, 100);
        work.set_items(10_000);
        (0..10_000).for_each(|item| work.tick(item).unwrap());
        work.end_pass();
        (0..100).for_each(|item| work.tick(item).unwrap());
        work.end_pass();
        let seen = seen.into_inner().unwrap();
        assert!(seen.iter().all(|progress| progress.total == 200));
        assert_eq!(seen.iter().map(|at| at.done).collect::<Vec<_>>(), [0, 40, 81, 100, 200]);
    }
}
