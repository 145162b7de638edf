//! Replaying a trajectory, which checks every number of its record.

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Crossings, Path, StartError, VerifyError, Zones, verify};
use thiserror::Error;

use super::record::{DrawError, Trajectory};

/// What is wrong with a trajectory.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReplayError {
    /// Its instance cannot be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// Its start path does not exist on the instance's region.
    #[error(transparent)]
    Start(StartError),
    /// A number of the record differs from the replay.
    #[error("{what}: record says {got}, replay gives {expected}")]
    Number {
        /// What was counted.
        what: &'static str,
        /// The number in the replay.
        expected: u32,
        /// The number in the record.
        got: u32,
    },
    /// The columns of the record hold no valid move at this index.
    #[error("move {index} is missing or invalid")]
    NoMove {
        /// Index of the move.
        index: usize,
    },
    /// A move does not apply to the path.
    #[error("move {index} does not apply")]
    Refused {
        /// Index of the move.
        index: usize,
    },
    /// The number of crossings after a move differs from the replay.
    #[error("move {index}: record says {got} crossings, replay gives {expected}")]
    Crossings {
        /// Index of the move.
        index: usize,
        /// The number in the replay.
        expected: u32,
        /// The number in the record.
        got: u32,
    },
    /// The path after the last move is not a valid path.
    #[error(transparent)]
    Path(#[from] VerifyError),
    /// The last move does not reach a new best: a record ends with the best path.
    #[error("last move does not reach a new best")]
    PastTheBest,
    /// The control ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<StartError> for ReplayError {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Start(error),
        }
    }
}

impl Trajectory {
    /// Draws the instance, applies all moves and checks every number of the record on the way.
    /// Returns the best path.
    ///
    /// Linear in the cells of the grid, plus the cost of each move on a [`Path`].
    /// No progress is reported.
    pub fn replay(&self, control: &Control<'_>) -> Result<Path, ReplayError> {
        let (region, zones) = self.draw()?;
        let mut path = self.start.path(&region, &control.without_progress())?;
        let crossings = Crossings::new(&region, &zones);
        let check = |what, expected: u32, got: u32| {
            if expected == got { Ok(()) } else { Err(ReplayError::Number { what, expected, got }) }
        };
        check("zones", zones.count(), u32::from(self.zones))?;
        check("pieces", path.pieces(), self.pieces)?;
        check("crossings of the start path", count_crossings(&path, &zones), self.initial)?;
        let bound = beadwork_search::bound::components(&region, &zones, self.pieces);
        check("lower bound of the crossings", bound, self.bound.unwrap_or(bound))?;

        let mut steps = self.steps();
        let mut last = None;
        for index in 0..self.moves.len() {
            control.check()?;
            let step = steps.next().ok_or(ReplayError::NoMove { index })?;
            if !step.action.apply(&mut path) {
                return Err(ReplayError::Refused { index });
            }
            let switches = step.action.switches(region.width());
            let change: i32 = switches.iter().map(|&switch| crossings.change(switch)).sum();
            let after = step.before.saturating_add_signed(change);
            if after != step.after {
                return Err(ReplayError::Crossings { index, expected: after, got: step.after });
            }
            last = Some(step);
        }
        verify(&region, path.order())?;
        check("crossings of the best path", count_crossings(&path, &zones), self.best)?;
        if last.is_some_and(|step| !step.effective) {
            return Err(ReplayError::PastTheBest);
        }
        Ok(path)
    }
}

/// Counts crossings along the path, independently of the tables that the search used.
fn count_crossings(path: &Path, zones: &Zones) -> u32 {
    let crossings = |piece: &[u32]| {
        piece.windows(2).filter(|step| zones.id(step[0]) != zones.id(step[1])).count()
    };
    path.iter_pieces().map(crossings).sum::<usize>() as u32
}
