//! Checkpoints: the complete state of a training run in one file.

use std::path::{Path, PathBuf};

use tch::Tensor;
use tch::nn::VarStore;
use thiserror::Error;

use crate::adamw::AdamW;
use crate::weights::{self, WeightsError};

/// Position of a run in its training schedule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingState {
    /// Steps completed.
    pub steps: u64,
    /// Epoch of the last batch.
    pub epoch: u64,
    /// Batches of that epoch used so far.
    pub batches: u64,
    /// Lowest validation loss so far; infinity before the first evaluation.
    pub best_loss: f64,
    /// Evaluations since the one with the lowest loss.
    pub evaluations_since_best: u64,
}

impl Default for TrainingState {
    fn default() -> Self {
        Self { steps: 0, epoch: 0, batches: 0, best_loss: f64::INFINITY, evaluations_since_best: 0 }
    }
}

/// Why a checkpoint cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file is not a safetensors file, or holds another network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// A tensor that every checkpoint has is missing: the file may hold weights only.
    #[error("'{}' is not a checkpoint: tensor '{name}' is missing", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: &'static str,
    },
    /// The checkpoint belongs to a run with another configuration or dataset.
    #[error(
        "'{}' belongs to another run: it has '{theirs}', this run has '{ours}'; \
         choose another folder",
        path.display()
    )]
    OtherRun {
        /// The file.
        path: PathBuf,
        /// The first line that differs, in the checkpoint's resolved configuration.
        theirs: String,
        /// The same line in this run's.
        ours: String,
    },
    /// A tensor has the wrong type or shape.
    #[error("'{}' is damaged: tensor '{name}' has the wrong type or shape", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: &'static str,
    },
}

/// The checkpoint file of one run.
///
/// It holds the network's parameters, the optimiser's state, the [`TrainingState`] and the run's
/// resolved configuration, by which a checkpoint of another run is recognised.
/// Writing replaces the file as a whole: a run that is killed meanwhile leaves the old one.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    resolved: String,
    upgrade: fn(&str) -> String,
}

const CONFIGURATION: &str = "run.configuration";
const PROGRESS: &str = "run.progress";
const BEST: &str = "run.best_loss";
const MEAN: &str = "adamw.mean";
const SQUARE: &str = "adamw.square";

impl Checkpoint {
    /// The checkpoint of a run with this resolved configuration.
    ///
    /// `upgrade` brings a resolved configuration that an earlier version wrote up to date, before
    /// the two are compared.
    pub fn new(path: &Path, resolved: &str, upgrade: fn(&str) -> String) -> Self {
        Self { path: path.into(), resolved: resolved.into(), upgrade }
    }

    /// Writes the state of the run.
    pub fn save(
        &self,
        variables: &VarStore,
        optimiser: &AdamW,
        state: TrainingState,
    ) -> Result<(), CheckpointError> {
        let (mean, square, optimiser_steps) = optimiser.state();
        let TrainingState { steps, epoch, batches, best_loss, evaluations_since_best } = state;
        let counts = [steps, epoch, batches, evaluations_since_best, optimiser_steps as u64];
        let counts = counts.map(|count| count as i64);
        let mut named = weights::named(variables);
        named.extend([
            (CONFIGURATION.to_owned(), Tensor::from_slice(self.resolved.as_bytes())),
            (PROGRESS.to_owned(), Tensor::from_slice(&counts)),
            (BEST.to_owned(), Tensor::from_slice(&[best_loss])),
            (MEAN.to_owned(), mean.shallow_clone()),
            (SQUARE.to_owned(), square.shallow_clone()),
        ]);
        Ok(weights::save_tensors(&named, &self.path)?)
    }

    /// Restores the state of the run.
    /// Returns `None` and changes nothing if there is no checkpoint yet; on an error nothing
    /// changes either.
    pub fn load(
        &self,
        variables: &VarStore,
        optimiser: &mut AdamW,
    ) -> Result<Option<TrainingState>, CheckpointError> {
        if !self.path.exists() {
            return Ok(None);
        }
        let mut tensors = weights::read_tensors(&self.path)?;
        let mut take = |name| {
            tensors
                .remove(name)
                .ok_or_else(|| CheckpointError::Missing { path: self.path.clone(), name })
        };
        let (configuration, counts, best) = (take(CONFIGURATION)?, take(PROGRESS)?, take(BEST)?);
        let (mean, square) = (take(MEAN)?, take(SQUARE)?);

        let damaged = |name| CheckpointError::Damaged { path: self.path.clone(), name };
        let configuration = Vec::<u8>::try_from(configuration).ok();
        let configuration = configuration.and_then(|bytes| String::from_utf8(bytes).ok());
        self.check_configuration(&configuration.ok_or_else(|| damaged(CONFIGURATION))?)?;
        let counts =
            Vec::<i64>::try_from(counts).ok().and_then(|counts| <[i64; 5]>::try_from(counts).ok());
        let counts = counts.ok_or_else(|| damaged(PROGRESS))?;
        let [steps, epoch, batches, evaluations_since_best, optimiser_steps] = counts;
        let best = Vec::<f64>::try_from(best).ok().and_then(|best| <[f64; 1]>::try_from(best).ok());
        let [best_loss] = best.ok_or_else(|| damaged(BEST))?;
        let (expected, ..) = optimiser.state();
        for (name, moments) in [(MEAN, &mean), (SQUARE, &square)] {
            if moments.size() != expected.size() {
                return Err(damaged(name));
            }
        }

        weights::fill(variables, &mut tensors, &self.path)?;
        optimiser.restore(&mean, &square, optimiser_steps);
        Ok(Some(TrainingState {
            steps: steps as u64,
            epoch: epoch as u64,
            batches: batches as u64,
            best_loss,
            evaluations_since_best: evaluations_since_best as u64,
        }))
    }

    /// Checks that a checkpoint's resolved configuration is this run's.
    fn check_configuration(&self, theirs: &str) -> Result<(), CheckpointError> {
        let theirs = (self.upgrade)(theirs);
        if theirs == self.resolved {
            return Ok(());
        }
        let (mut theirs, mut ours) = (theirs.lines(), self.resolved.lines());
        loop {
            let (their_line, our_line) = (theirs.next(), ours.next());
            // If all lines are equal, the texts differ in their line ends.
            if their_line != our_line || their_line.is_none() {
                return Err(CheckpointError::OtherRun {
                    path: self.path.clone(),
                    theirs: their_line.unwrap_or_default().to_owned(),
                    ours: our_line.unwrap_or_default().to_owned(),
                });
            }
        }
    }
}
