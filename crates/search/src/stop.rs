//! Why a search ends.

use std::sync::atomic::{AtomicBool, Ordering};

/// Why a search stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stop {
    /// It did as much work as asked.
    Done,
    /// It reached the bound.
    Optimal,
    /// The cancel token was set.
    Cancelled,
    /// Its time was up.
    TimeUp,
}

/// What may end a search early.
#[derive(Clone, Copy, Default)]
pub(crate) struct Interrupt<'a> {
    pub(crate) cancel: Option<&'a AtomicBool>,
    pub(crate) time_is_up: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl Interrupt<'_> {
    /// Whether to stop now, and why.
    pub(crate) fn check(&self) -> Option<Stop> {
        if is_cancelled(self.cancel) {
            return Some(Stop::Cancelled);
        }
        self.time_is_up.is_some_and(|time_is_up| time_is_up()).then_some(Stop::TimeUp)
    }
}

/// Whether a cancel token was given and is set.
pub(crate) fn is_cancelled(cancel: Option<&AtomicBool>) -> bool {
    cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
}
