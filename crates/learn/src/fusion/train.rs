//! Training of FusionNet: from a dataset of recorded searches to weights.
//!
//! Aali et al., section FusionNet, with `AdamW`, linear warm-up and cosine decay.
//!
//! A run can be resumed: the batch and the dropout of a step depend on the configuration and the
//! step's number alone, so a run that continues from its last checkpoint has the same losses as one
//! that was never stopped.
//! [`train`] is the whole loop; [`training_step`] is one step of it, for custom loops.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::thread;

use beadwork_base::{Control, Interrupted};
use beadwork_dataset::{Dataset, FileError, write_atomic};
use tch::Device;
use tch::nn::VarStore;
use thiserror::Error;

use super::evaluate::{Evaluation, evaluate};
use super::loss::fusion_loss;
use super::model::{Model, Origin};
use super::network::FusionNet;
use super::prefetch::{Prefetched, Prefetcher};
use super::samples::{Batch, Batches, SampleError, Split};
use super::training_config::{TrainingConfig, TrainingConfigError};
use crate::adamw::{self, AdamW};
use crate::checkpoint::{Checkpoint, CheckpointError, TrainingState};
use crate::weights::{self, WeightsError};

/// Why a run cannot start or continue.
/// Existing checkpoints stay as they are.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A field of the configuration is outside its range.
    #[error(transparent)]
    Config(#[from] TrainingConfigError),
    /// The dataset cannot be read, or a split of it is empty.
    #[error(transparent)]
    Samples(#[from] SampleError),
    /// Training diverged: the loss or the gradient overflowed.
    #[error(
        "{what} is not finite at step {step}; try a lower learning rate \
         (the last checkpoint is from an earlier step)"
    )]
    NotFinite {
        /// The loss or the gradient.
        what: &'static str,
        /// The step, from 1.
        step: u64,
    },
    /// A checkpoint cannot be read or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The resolved configuration cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// Weights cannot be written.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

/// An event of a run, for logs.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The run started, or resumed from a checkpoint.
    /// Events of later steps, if the interrupted run has logged any, will be repeated.
    Started {
        /// Steps completed; 0 for a new run.
        steps: u64,
    },
    /// A step is complete.
    Step {
        /// Its number, from 1.
        step: u64,
        /// Examples in its batch.
        examples: usize,
        /// Loss of the batch, before the step.
        loss: f64,
        /// Learning rate of the step.
        learning_rate: f64,
        /// Norm of the gradient, before it was scaled down.
        gradient_norm: f64,
    },
    /// The network was evaluated; a checkpoint is written next.
    Evaluated {
        /// The step after which it was evaluated.
        step: u64,
        /// Loss and accuracy on the validation examples.
        evaluation: Evaluation,
        /// Whether the loss is the lowest so far; the weights have then been saved.
        best: bool,
    },
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All steps are complete.
    Done,
    /// Early stopping: the validation loss stopped falling.
    Early,
    /// [`Control::cancel`] was cancelled; the run can be resumed.
    Cancelled,
    /// [`Control::time_is_up`] returned true; the run can be resumed.
    TimeUp,
}

impl From<Interrupted> for End {
    fn from(interrupted: Interrupted) -> Self {
        match interrupted {
            Interrupted::Cancelled => Self::Cancelled,
            Interrupted::TimeUp => Self::TimeUp,
        }
    }
}

/// Device, output directory and callback of a run.
pub struct Run<'a> {
    /// The device to compute on.
    pub device: Device,
    /// Folder of the run's checkpoint and of its best [`Model`] so far; it must exist.
    pub out: &'a Path,
    /// Called with each event, on the calling thread.
    pub observer: &'a mut dyn FnMut(&Event),
}

/// The file of the last checkpoint in a run's folder.
pub fn last_checkpoint(out: &Path) -> PathBuf {
    out.join("last.checkpoint")
}

/// Trains a network, or resumes the run whose checkpoint is in the output directory.
///
/// Every `evaluate_every` steps the network is evaluated on the validation split, the weights are
/// saved if their loss is the lowest so far, and a checkpoint is written.
/// Checkpoints are also written at the start and when the run is interrupted.
///
/// Dropout draws from libtorch's global random number generator: other code that draws from it at
/// the same time changes the run.
///
/// With f = 32, a step on 64 examples of 32 x 32 cells takes about 0.35 s on two cores, and its
/// features take 1 GB of memory.
/// The dataset is streamed from disk, not loaded into memory.
///
/// Progress counts steps.
/// When `control` interrupts the run, it completes the current step and its evaluation, writes a
/// checkpoint and returns [`End::Cancelled`] or [`End::TimeUp`].
/// The threads of `control` are not used: libtorch has its own, [`TrainingConfig::threads`] of
/// them, and one more thread reads the dataset.
pub fn train(
    dataset: &Dataset,
    config: &TrainingConfig,
    run: Run<'_>,
    control: &Control<'_>,
) -> Result<End, TrainError> {
    config.check()?;
    let Run { device, out, observer } = run;

    // The network and its optimiser.
    if config.threads > 0 {
        tch::set_num_threads(config.threads as i32);
    }
    tch::manual_seed(config.seed as i64);
    let variables = VarStore::new(device);
    let network = FusionNet::new(&variables.root(), config.network());
    let parameters =
        weights::named(&variables).into_iter().map(|(_, parameter)| parameter).collect();
    let settings =
        adamw::Settings { weight_decay: config.weight_decay, ..adamw::Settings::default() };
    let mut optimiser = AdamW::new(parameters, settings);

    // Resume from the checkpoint, or write the first one.
    // It is written before all other files, so that a run killed at any time can be resumed.
    let (resolved, origin) = (config.resolved(), Origin::of(dataset).to_toml());
    let checkpoint = Checkpoint::new(
        &last_checkpoint(out),
        &format!("{resolved}{origin}"),
        TrainingConfig::upgrade_resolved,
    );
    let resumed: Option<TrainingState> = checkpoint.load(&variables, &mut optimiser)?;
    let mut state = resumed.unwrap_or_default();
    if resumed.is_none() {
        checkpoint.save(&variables, &optimiser, &state)?;
    }
    write_atomic(&Model::config_file(out), |file| file.write_all(resolved.as_bytes()))?;
    write_atomic(&Model::origin_file(out), |file| file.write_all(origin.as_bytes()))?;
    observer(&Event::Started { steps: state.steps });
    control.report(state.steps as usize, config.steps as usize);
    if state.evaluations_since_best >= config.patience {
        return Ok(End::Early);
    }

    // Validation examples are drawn once and are the same in each evaluation; training batches are
    // made on a second thread.
    let held_out = config.held_out(config.valid_per_trajectory);
    let validation: Vec<Batch> =
        Batches::new(dataset, Split::Valid, &held_out, 0).collect::<Result<_, _>>()?;
    if validation.is_empty() {
        return Err(SampleError::NoExamples { split: Split::Valid }.into());
    }
    let samples = config.samples();
    thread::scope(|scope| {
        let training = Prefetcher::spawn(scope, dataset, &samples, (state.epoch, state.batches));

        while state.steps < config.steps {
            if let Some(interrupted) = control.interrupted() {
                checkpoint.save(&variables, &optimiser, &state)?;
                return Ok(interrupted.into());
            }

            // One step, whose dropout depends on the seed and the step's number alone.
            let Prefetched { epoch, batches, batch } = training.next()?;
            let step = state.steps + 1;
            tch::manual_seed((config.seed << 32 ^ step) as i64);
            let learning_rate = config.learning_rate_at(step);
            let StepResult { loss, gradient_norm } =
                training_step(&network, &mut optimiser, &batch, config, learning_rate, device);
            for (what, value) in [("loss", loss), ("gradient", gradient_norm)] {
                if !value.is_finite() {
                    return Err(TrainError::NotFinite { what, step });
                }
            }
            state = TrainingState { steps: step, epoch, batches, ..state };
            let examples = batch.len();
            observer(&Event::Step { step, examples, loss, learning_rate, gradient_norm });
            control.report(step as usize, config.steps as usize);
            if !step.is_multiple_of(config.evaluate_every) && step != config.steps {
                continue;
            }

            // Evaluation, early stopping, checkpoint.
            // The evaluation cannot be interrupted: the checkpoint of a step must include it.
            let evaluation = evaluate(&network, &validation, config, device, &Control::default())
                .expect("a default control never interrupts");
            let best = evaluation.loss < state.best_loss;
            if best {
                weights::save(&variables, &Model::weights_file(out))?;
                state.best_loss = evaluation.loss;
                state.evaluations_since_best = 0;
            } else {
                state.evaluations_since_best += 1;
            }
            // Logged before the checkpoint is written, so that a resumed run never misses an event.
            observer(&Event::Evaluated { step, evaluation, best });
            checkpoint.save(&variables, &optimiser, &state)?;
            if state.evaluations_since_best >= config.patience {
                return Ok(End::Early);
            }
        }
        Ok(End::Done)
    })
}

/// What a training step measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepResult {
    /// Loss of the batch, before the step.
    pub loss: f64,
    /// Norm of the gradient, before it was scaled down to [`TrainingConfig::max_grad_norm`].
    pub gradient_norm: f64,
}

/// One step of gradient descent on a batch: forward pass, loss, backward pass, optimiser.
///
/// Of the configuration it uses the precision, the loss and the maximum gradient norm.
/// If the loss or the gradient norm is not finite, the network stays as it is; the gradient norm is
/// 0 if the loss is not finite.
pub fn training_step(
    network: &FusionNet,
    optimiser: &mut AdamW,
    batch: &Batch,
    config: &TrainingConfig,
    learning_rate: f64,
    device: Device,
) -> StepResult {
    let (image, history) = batch.inputs.tensors(device);
    let proposals = network.forward(&image, &history, config.precision, true);
    let loss = fusion_loss(&proposals, &batch.targets(device), &config.loss);
    let value = loss.double_value(&[]);
    if !value.is_finite() {
        return StepResult { loss: value, gradient_norm: 0.0 };
    }
    optimiser.zero_grad();
    loss.backward();
    let gradient_norm = optimiser.step(learning_rate, config.max_grad_norm);
    StepResult { loss: value, gradient_norm }
}
