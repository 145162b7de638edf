//! Why a search ends.

use std::sync::atomic::{AtomicBool, Ordering};

use beadwork_base::Interrupted;

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

impl From<Interrupted> for Stop {
    fn from(interrupted: Interrupted) -> Self {
        match interrupted {
            Interrupted::Cancelled => Self::Cancelled,
            Interrupted::TimeUp => Self::TimeUp,
        }
    }
}

/// Whether a cancel token was given and is set.
pub(crate) fn is_cancelled(cancel: Option<&AtomicBool>) -> bool {
    cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
}
