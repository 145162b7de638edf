//! Why a search ends.

use beadwork_base::Interrupted;

/// Why a search stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stop {
    /// All planned work is done.
    Done,
    /// The result reached a proven lower bound, so nothing better exists.
    Optimal,
    /// The result reached the target that the caller set; something better may exist.
    TargetReached,
    /// The cancel token was cancelled.
    Cancelled,
    /// The time limit was reached.
    TimeUp,
}

impl Stop {
    /// Whether the caller ended the search before its work was done.
    pub fn is_interrupted(self) -> bool {
        matches!(self, Self::Cancelled | Self::TimeUp)
    }
}

impl From<Interrupted> for Stop {
    fn from(interrupted: Interrupted) -> Self {
        match interrupted {
            Interrupted::Cancelled => Self::Cancelled,
            Interrupted::TimeUp => Self::TimeUp,
        }
    }
}

/// Costs at which a search ends early.
#[derive(Clone, Copy)]
pub(crate) struct Goal {
    /// A lower bound that the caller has proven.
    pub(crate) proven_bound: Option<i64>,
    /// A cost that is good enough.
    pub(crate) target: Option<i64>,
}

impl Goal {
    /// The reason to stop a search with this best cost; `None` if it has to go on.
    #[inline]
    pub(crate) fn reached(self, best: i64) -> Option<Stop> {
        if self.proven_bound.is_some_and(|bound| best <= bound) {
            Some(Stop::Optimal)
        } else if self.target.is_some_and(|target| best <= target) {
            Some(Stop::TargetReached)
        } else {
            None
        }
    }
}
