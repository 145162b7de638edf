//! Where a training stands, in one file that is whole or absent.

use std::path::{Path, PathBuf};

use tch::Tensor;
use tch::nn::VarStore;
use thiserror::Error;

use crate::adamw::AdamW;
use crate::weights::{self, WeightsError};

/// How far a training has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps made.
    pub steps: u64,
    /// The epoch of the last batch.
    pub epoch: u64,
    /// Batches taken from that epoch.
    pub batches: u64,
    /// Lowest loss of an evaluation.
    pub best_loss: f64,
    /// Evaluations since then.
    pub waited: u64,
}

impl Default for Progress {
    fn default() -> Self {
        Self { steps: 0, epoch: 0, batches: 0, best_loss: f64::INFINITY, waited: 0 }
    }
}

/// Why a checkpoint can't be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It is no checkpoint, or one of another network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// It lacks something that every checkpoint has.
    #[error("'{}' is no checkpoint: it has no '{name}'", path.display())]
    Lacks {
        /// The file.
        path: PathBuf,
        /// What it lacks.
        name: &'static str,
    },
    /// It belongs to a run with another configuration or dataset.
    #[error("'{}' belongs to another run, with '{theirs}' where this one has '{ours}': choose another folder", path.display())]
    OtherRun {
        /// The file.
        path: PathBuf,
        /// The first line of its configuration that differs.
        theirs: String,
        /// What this run's says there.
        ours: String,
    },
    /// What it holds is not of the shape that it must have.
    #[error("'{}' is damaged: its '{name}' is not as it was written", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is not.
        name: &'static str,
    },
}

/// The checkpoint of one run.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    /// The run's configuration, which is kept with it.
    echo: String,
}

const ECHO: &str = "run.configuration";
const PROGRESS: &str = "run.progress";
const BEST: &str = "run.best_loss";
const MEAN: &str = "adamw.mean";
const SQUARE: &str = "adamw.square";

impl Checkpoint {
    /// For a run that is told by a text.
    pub fn new(path: &Path, echo: &str) -> Self {
        Self { path: path.into(), echo: echo.into() }
    }

    /// Writes where a run stands.
    pub fn save(
        &self,
        variables: &VarStore,
        optimiser: &AdamW,
        progress: Progress,
    ) -> Result<(), CheckpointError> {
        let (mean, square, steps) = optimiser.state();
        let Progress { steps: made, epoch, batches, best_loss, waited } = progress;
        let counts = [made, epoch, batches, waited, steps as u64].map(|count| count as i64);
        let mut named = weights::named(variables);
        named.extend([
            (ECHO.to_owned(), Tensor::from_slice(self.echo.as_bytes())),
            (PROGRESS.to_owned(), Tensor::from_slice(&counts)),
            (BEST.to_owned(), Tensor::from_slice(&[best_loss])),
            (MEAN.to_owned(), mean.shallow_clone()),
            (SQUARE.to_owned(), square.shallow_clone()),
        ]);
        Ok(weights::save_tensors(&named, &self.path)?)
    }

    /// Goes on from where a run stood; `None`, and nothing changed, where there is no checkpoint
    /// yet.
    pub fn load(
        &self,
        variables: &VarStore,
        optimiser: &mut AdamW,
    ) -> Result<Option<Progress>, CheckpointError> {
        if !self.path.exists() {
            return Ok(None);
        }
        let mut read = weights::read_tensors(&self.path)?;
        let mut take = |name| {
            read.remove(name)
                .ok_or_else(|| CheckpointError::Lacks { path: self.path.clone(), name })
        };
        let (echo, counts, best) = (take(ECHO)?, take(PROGRESS)?, take(BEST)?);
        let (mean, square) = (take(MEAN)?, take(SQUARE)?);
        let damaged = |name| CheckpointError::Damaged { path: self.path.clone(), name };
        let echo = Vec::<u8>::try_from(echo).ok().and_then(|echo| String::from_utf8(echo).ok());
        self.compare(&echo.ok_or_else(|| damaged(ECHO))?)?;
        let counts =
            Vec::<i64>::try_from(counts).ok().and_then(|counts| <[i64; 5]>::try_from(counts).ok());
        let [steps, epoch, batches, waited, optimised] = counts.ok_or_else(|| damaged(PROGRESS))?;
        let best = Vec::<f64>::try_from(best).ok().and_then(|best| <[f64; 1]>::try_from(best).ok());
        let [best_loss] = best.ok_or_else(|| damaged(BEST))?;
        let (of_optimiser, ..) = optimiser.state();
        for (name, moments) in [(MEAN, &mean), (SQUARE, &square)] {
            if moments.size() != of_optimiser.size() {
                return Err(damaged(name));
            }
        }
        weights::fill(variables, &mut read, &self.path)?;
        optimiser.restore(&mean, &square, optimised);
        Ok(Some(Progress {
            steps: steps as u64,
            epoch: epoch as u64,
            batches: batches as u64,
            best_loss,
            waited: waited as u64,
        }))
    }

    /// Whether a checkpoint with this text is this run's.
    fn compare(&self, echo: &str) -> Result<(), CheckpointError> {
        if echo == self.echo {
            return Ok(());
        }
        let (mut theirs, mut ours) = (echo.lines(), self.echo.lines());
        loop {
            let (its, own) = (theirs.next(), ours.next());
            // Texts whose lines are equal differ in their ends.
            if its != own || its.is_none() {
                let told = |line: Option<&str>| line.unwrap_or_default().to_owned();
                return Err(CheckpointError::OtherRun {
                    path: self.path.clone(),
                    theirs: told(its),
                    ours: told(own),
                });
            }
        }
    }
}
