//! Checkpoints: the complete state of a training run in one file.

use std::path::{Path, PathBuf};

use tch::Tensor;
use tch::nn::VarStore;
use thiserror::Error;

use crate::adamw::AdamW;
use crate::weights::{self, WeightsError};

/// The state of a run beside its parameters and its optimiser's means, in a checkpoint.
pub trait RunState: Sized {
    /// Names of its tensors.
    const NAMES: &'static [&'static str];

    /// Its tensors, in the order of their names; they include the optimiser's steps.
    fn to_tensors(&self, optimiser_steps: i64) -> Vec<Tensor>;

    /// The state and the optimiser's steps; the error is the name of a tensor with the wrong type
    /// or shape.
    fn from_tensors(tensors: &[Tensor]) -> Result<(Self, i64), &'static str>;
}

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
/// It holds the network's parameters, the optimiser's state, the run's position in its schedule and
/// its resolved configuration, by which a checkpoint of another run is recognised.
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

impl RunState for TrainingState {
    const NAMES: &'static [&'static str] = &[PROGRESS, BEST];

    fn to_tensors(&self, optimiser_steps: i64) -> Vec<Tensor> {
        let &Self { steps, epoch, batches, best_loss, evaluations_since_best } = self;
        let counts = [steps, epoch, batches, evaluations_since_best, optimiser_steps as u64];
        let counts = counts.map(|count| count as i64);
        vec![Tensor::from_slice(&counts), Tensor::from_slice(&[best_loss])]
    }

    fn from_tensors(tensors: &[Tensor]) -> Result<(Self, i64), &'static str> {
        let [counts, best] = tensors else { return Err(PROGRESS) };
        let counts =
            Vec::<i64>::try_from(counts).ok().and_then(|counts| <[i64; 5]>::try_from(counts).ok());
        let [steps, epoch, batches, evaluations_since_best, optimiser_steps] =
            counts.ok_or(PROGRESS)?;
        let best = Vec::<f64>::try_from(best).ok().and_then(|best| <[f64; 1]>::try_from(best).ok());
        let [best_loss] = best.ok_or(BEST)?;
        let state = Self {
            steps: steps as u64,
            epoch: epoch as u64,
            batches: batches as u64,
            best_loss,
            evaluations_since_best: evaluations_since_best as u64,
        };
        Ok((state, optimiser_steps))
    }
}

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
        state: &impl RunState,
    ) -> Result<(), CheckpointError> {
        let (mean, square, optimiser_steps) = optimiser.state();
        let mut named = weights::named(variables);
        named.extend([
            (CONFIGURATION.to_owned(), Tensor::from_slice(self.resolved.as_bytes())),
            (MEAN.to_owned(), mean.shallow_clone()),
            (SQUARE.to_owned(), square.shallow_clone()),
        ]);
        named.extend(names_of(state).zip(state.to_tensors(optimiser_steps)));
        Ok(weights::save_tensors(&named, &self.path)?)
    }

    /// Restores the state of the run.
    /// Returns `None` and changes nothing if there is no checkpoint yet; on an error nothing
    /// changes either.
    pub fn load<S: RunState>(
        &self,
        variables: &VarStore,
        optimiser: &mut AdamW,
    ) -> Result<Option<S>, CheckpointError> {
        if !self.path.exists() {
            return Ok(None);
        }
        let mut tensors = weights::read_tensors(&self.path)?;
        let mut take = |name| {
            tensors
                .remove(name)
                .ok_or_else(|| CheckpointError::Missing { path: self.path.clone(), name })
        };
        let configuration = take(CONFIGURATION)?;
        let (mean, square) = (take(MEAN)?, take(SQUARE)?);

        // The configuration is compared first: another kind of run has other tensors, too.
        let damaged = |name| CheckpointError::Damaged { path: self.path.clone(), name };
        let configuration = Vec::<u8>::try_from(configuration).ok();
        let configuration = configuration.and_then(|bytes| String::from_utf8(bytes).ok());
        self.check_configuration(&configuration.ok_or_else(|| damaged(CONFIGURATION))?)?;
        let state = S::NAMES.iter().map(|name| take(name)).collect::<Result<Vec<_>, _>>()?;
        let (state, optimiser_steps) = S::from_tensors(&state).map_err(damaged)?;
        let (expected, ..) = optimiser.state();
        for (name, moments) in [(MEAN, &mean), (SQUARE, &square)] {
            if moments.size() != expected.size() {
                return Err(damaged(name));
            }
        }

        weights::fill(variables, &mut tensors, &self.path)?;
        optimiser.restore(&mean, &square, optimiser_steps);
        Ok(Some(state))
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

/// The names of a state's tensors.
fn names_of<S: RunState>(_: &S) -> impl Iterator<Item = String> {
    S::NAMES.iter().map(|&name| name.to_owned())
}
