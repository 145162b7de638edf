//! Control of long calls: threads, cancellation, time limit and progress.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

use crate::Threads;

/// The threads of a long call, its cancel token, its time limit and its progress report.
///
/// Every call of the workspace that can take longer than a fraction of a second takes a `Control`
/// as its last argument.
/// With the default, the call works on the calling thread, runs to its end and reports nothing.
/// No field changes the result of a call that runs to its end.
///
/// Construct it with `..Control::default()`: fields may be added.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// The threads to work on.
    pub threads: Threads<'a>,
    /// Token that makes the call end soon after it is cancelled.
    /// Searches then return the best result so far, other calls an error.
    pub cancel: Option<&'a CancelToken>,
    /// Polled periodically, from any thread; when it returns true, the call ends as if cancelled,
    /// but with [`Interrupted::TimeUp`].
    /// The libraries read no clock, so a caller who wants a time limit compares times here.
    pub time_is_up: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// Called periodically, from any thread, with the progress so far.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl<'a> Control<'a> {
    /// A control with these threads, without cancellation, time limit or progress report.
    pub fn on(threads: Threads<'a>) -> Self {
        Self { threads, ..Self::default() }
    }

    /// Returns this control without its progress report.
    ///
    /// For a caller that makes several calls and reports their overall progress itself.
    pub fn without_progress(self) -> Self {
        Self { progress: None, ..self }
    }

    /// Returns this control without its cancel token and its time limit.
    ///
    /// For what an interrupted call must still do to return a whole result.
    pub fn uninterrupted(self) -> Self {
        Self { cancel: None, time_is_up: None, ..self }
    }

    /// Returns this control with [`Threads::One`], for calls that already run in parallel.
    pub fn on_one_thread(self) -> Self {
        Self { threads: Threads::One, ..self }
    }

    /// Reason why the call should end now; `None` if it should continue.
    ///
    /// Costs one atomic load, and one call of `time_is_up` if that is set.
    #[inline]
    pub fn interrupted(&self) -> Option<Interrupted> {
        if self.cancel.is_some_and(CancelToken::is_cancelled) {
            return Some(Interrupted::Cancelled);
        }
        self.time_is_up.is_some_and(|is_up| is_up()).then_some(Interrupted::TimeUp)
    }

    /// Returns an error if the call should end now, for calls without a partial result.
    #[inline]
    pub fn check(&self) -> Result<(), Interrupted> {
        self.interrupted().map_or(Ok(()), Err)
    }

    /// Reports that `done` of `total` units of work are complete.
    /// The documentation of the call names the unit.
    #[inline]
    pub fn report(&self, done: usize, total: usize) {
        if let Some(progress) = self.progress {
            progress(Progress { done, total });
        }
    }
}

/// The share of a call's work that is complete.
///
/// `total` stays the same within one call.
/// On one thread `done` rises from report to report; on several threads reports may arrive out of
/// order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Units of work done; the documentation of the call names the unit.
    pub done: usize,
    /// Units of work in all.
    pub total: usize,
}

impl Progress {
    /// Share of the work that is done, 0 to 1; 1 if `total` is 0.
    pub fn fraction(self) -> f64 {
        if self.total == 0 { 1.0 } else { self.done as f64 / self.total as f64 }
    }
}

/// A flag that ends long calls early.
/// Clones share the flag, any thread can set it, and it stays set.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that is not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes all calls that hold a clone of this token end soon.
    /// Returns whether the token had already been cancelled.
    pub fn cancel(&self) -> bool {
        self.0.swap(true, Ordering::Relaxed)
    }

    /// Whether [`CancelToken::cancel`] was called.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Reason why a call ended before its work was complete.
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
