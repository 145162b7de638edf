//! How a caller controls a long call.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

use crate::Threads;

/// Where a long call works, what ends it early, and who is informed of its progress.
///
/// Every call of the workspace that can take longer than a fraction of a second takes one.
/// The default works on the calling thread, runs to its end and reports nothing.
/// None of the fields changes a result that is not interrupted.
///
/// Construct it with `..Control::default()`: a minor version may add a field.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// The threads to work on.
    pub threads: Threads<'a>,
    /// Ends the call soon after it is cancelled.
    /// Searches then return the best result so far, other calls an error.
    pub cancel: Option<&'a CancelToken>,
    /// Polled periodically, from any thread; when true, the call ends as if it were cancelled, but
    /// with [`Interrupted::TimeUp`].
    /// The libraries read no clock: this is how a caller limits their time.
    pub time_is_up: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// Called periodically, from any thread, with the progress so far.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl<'a> Control<'a> {
    /// A control with these threads, which runs to its end and reports nothing.
    pub fn on(threads: Threads<'a>) -> Self {
        Self { threads, ..Self::default() }
    }

    /// This control for one of several calls that share a progress report: the call itself reports
    /// nothing.
    pub fn without_progress(self) -> Self {
        Self { progress: None, ..self }
    }

    /// This control for work on the calling thread, for calls that are themselves made in parallel.
    pub fn on_one_thread(self) -> Self {
        Self { threads: Threads::One, ..self }
    }

    /// Why the call should end now, if it should.
    #[inline]
    pub fn interrupted(&self) -> Option<Interrupted> {
        if self.cancel.is_some_and(CancelToken::is_cancelled) {
            return Some(Interrupted::Cancelled);
        }
        self.time_is_up.is_some_and(|is_up| is_up()).then_some(Interrupted::TimeUp)
    }

    /// Returns an error if the call should end now: for calls that have no partial result.
    #[inline]
    pub fn check(&self) -> Result<(), Interrupted> {
        self.interrupted().map_or(Ok(()), Err)
    }

    /// Reports that `done` of `total` units of work are complete; the call's documentation names
    /// the unit.
    #[inline]
    pub fn report(&self, done: usize, total: usize) {
        if let Some(progress) = self.progress {
            progress(Progress { done, total });
        }
    }
}

/// How much of a call's work is complete.
///
/// Within one call `total` stays the same.
/// Calls that work on one thread report rising `done`; on several threads reports may overtake each
/// other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Units of work done; the call's documentation names the unit.
    pub done: usize,
    /// Units of work in all.
    pub total: usize,
}

impl Progress {
    /// Share of the work that is done, 0 to 1; 1 if there is none to do.
    pub fn fraction(self) -> f64 {
        if self.total == 0 { 1.0 } else { self.done as f64 / self.total as f64 }
    }
}

/// A flag that ends long calls early.
/// Clones share the flag; it can be set from any thread, and stays set.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that is not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks all calls that hold a clone of this token to end soon.
    /// Returns whether that was asked before.
    pub fn cancel(&self) -> bool {
        self.0.swap(true, Ordering::Relaxed)
    }

    /// The flag itself, for code that polls an atomic.
    pub fn as_flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Whether [`CancelToken::cancel`] was called.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why a call ended before its work was complete.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Interrupted {
    /// [`Control::cancel`] was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// [`Control::time_is_up`] returned true.
    #[error("time limit reached")]
    TimeUp,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_control_never_interrupts() {
        let control = Control::default();
        assert_eq!(control.interrupted(), None);
        assert_eq!(control.check(), Ok(()));
        control.report(1, 2);
    }

    #[test]
    fn clones_of_a_token_share_its_flag() {
        let token = CancelToken::new();
        let clone = token.clone();
        assert!(!clone.cancel());
        assert!(token.is_cancelled());
        assert!(token.cancel());
    }

    #[test]
    fn cancelling_comes_before_the_time_limit() {
        let token = CancelToken::new();
        let is_up = || true;
        let control =
            Control { cancel: Some(&token), time_is_up: Some(&is_up), ..Control::default() };
        assert_eq!(control.interrupted(), Some(Interrupted::TimeUp));
        token.cancel();
        assert_eq!(control.interrupted(), Some(Interrupted::Cancelled));
    }

    #[test]
    fn fraction_of_no_work_is_one() {
        assert_eq!(Progress { done: 0, total: 0 }.fraction().to_bits(), 1.0_f64.to_bits());
        assert_eq!(Progress { done: 1, total: 4 }.fraction().to_bits(), 0.25_f64.to_bits());
    }
}
