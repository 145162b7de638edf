//! Training of `FusionNet`, from a dataset of recorded searches to weights.
//!
//! Aali et al., section FusionNet, with `AdamW`, warm-up and cosine.
//! A run is told by its configuration and seed: what a batch holds and which features are dropped
//! depend on the number of the step alone, so that a run which was stopped goes on with the same
//! losses from its last checkpoint.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use beadwork_dataset::{Dataset, FileError, write_whole};
use serde::{Deserialize, Serialize};
use tch::nn::VarStore;
use tch::{Device, no_grad};
use thiserror::Error;

use super::loss::{Hits, LossSettings, loss};
use super::model::{Model, Origin};
use super::odds::Odds;
use super::samples::{Batch, Batches, Rivals, SampleError, SampleSettings, Split};
use super::{Config, FusionNet, PLACES, Precision, Without, ask};
use crate::adamw::{AdamW, AdamWSettings};
use crate::checkpoint::{Checkpoint, CheckpointError, Progress};
use crate::weights::{self, WeightsError};

/// Everything that tells a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Training {
    /// Seed of the first weights, the batches and the dropped features.
    pub seed: u64,
    /// Channels of the network, f.
    pub width: i64,
    /// Units of its recurrent layers.
    pub hidden: i64,
    /// Moves it remembers, K.
    pub history: i64,
    /// What is left out of it.
    pub without: Without,
    /// What its features are computed in.
    pub precision: Precision,
    /// Steps, each with one batch, unless it stops early.
    pub steps: u64,
    /// Examples in a batch on a canvas of 32 x 32 cells; on larger ones fewer in proportion.
    pub batch: usize,
    /// Examples from a trajectory in an epoch, on a canvas of 32 x 32 cells; on larger ones fewer
    /// in proportion.
    pub per_trajectory: usize,
    /// Share of the examples that are drawn from all depths alike, from the layer's sides inwards.
    pub balance: f64,
    /// Batches that wait for each canvas, to be mixed.
    pub pool: usize,
    /// What the true position is ranked above.
    pub rivals: Rivals,
    /// The loss.
    pub loss: LossSettings,
    /// Highest learning rate.
    pub rate: f64,
    /// Steps in which it rises to that.
    pub warm_up: u64,
    /// Share of it that is left at the end, falling with a cosine.
    pub final_rate: f64,
    /// `AdamW`'s decay of the weights.
    pub weight_decay: f64,
    /// Length to which longer gradients are shortened.
    pub clip: f64,
    /// Steps between two evaluations, after each of which a checkpoint is written.
    pub evaluate_every: u64,
    /// Examples from each of the trajectories that steer it, of all layouts and sizes, in an
    /// evaluation.
    pub valid_per_trajectory: usize,
    /// Evaluations without a better one after which the run stops early, at least 1.
    pub patience: u64,
    /// Threads of libtorch; 0 for one a core.
    pub threads: usize,
}

impl Default for Training {
    fn default() -> Self {
        Self {
            seed: 0,
            width: 32,
            hidden: 192,
            history: 32,
            without: Without::Nothing,
            precision: Precision::Single,
            steps: 10_000,
            batch: 64,
            per_trajectory: 96,
            balance: 0.3,
            pool: 24,
            rivals: Rivals::Applicable,
            loss: LossSettings::default(),
            rate: 4e-4,
            warm_up: 300,
            final_rate: 0.02,
            weight_decay: 1e-2,
            clip: 1.0,
            evaluate_every: 500,
            valid_per_trajectory: 2,
            patience: 40,
            threads: 0,
        }
    }
}

/// Why a run can't begin or go on.
/// Checkpoints stay as they are.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrainError {
    /// The configuration contradicts itself.
    #[error("'{field}' is {value}, it must be {must}")]
    Config {
        /// Which field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        must: &'static str,
    },
    /// The examples can't be read.
    #[error(transparent)]
    Samples(#[from] SampleError),
    /// A part of the dataset holds nothing.
    #[error("the dataset has no examples {0}")]
    Empty(&'static str),
    /// The loss or its gradient is no number any more.
    #[error(
        "the {what} of step {step} is no number: a lower rate may help; the checkpoints are those before"
    )]
    NotANumber {
        /// The loss or the gradient.
        what: &'static str,
        /// Which step.
        step: u64,
    },
    /// A checkpoint can't be read or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The configuration can't be written.
    #[error(transparent)]
    File(FileError),
    /// Weights can't be written.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

/// What a run tells its observer.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// It begins, or goes on from a checkpoint after so many steps: whatever was told of later ones
    /// will be told anew.
    Began {
        /// Steps made, 0 where there is no checkpoint.
        steps: u64,
    },
    /// A step was made.
    Step {
        /// Its number, from 1.
        step: u64,
        /// Examples in it.
        examples: usize,
        /// Its loss.
        loss: f64,
        /// The learning rate.
        rate: f64,
        /// Length of the gradient before it was shortened.
        gradient: f64,
    },
    /// The network was evaluated; a checkpoint is written next.
    Evaluated {
        /// After which step.
        step: u64,
        /// What it came to.
        evaluation: Evaluation,
        /// Whether it is the best so far.
        best: bool,
    },
}

/// How well a network does on examples that it has not learned from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Mean loss of the batches.
    pub loss: f64,
    /// All examples.
    pub all: Hits,
    /// Those of each layout, and how often they would be met without a network.
    pub by_layout: BTreeMap<String, (Hits, Odds)>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All steps are made.
    Done,
    /// It stopped getting better.
    Early,
    /// It was cancelled, and can go on.
    Cancelled,
}

/// Where and under whose eyes a run takes place.
pub struct Run<'a> {
    /// Where it computes.
    pub device: Device,
    /// Folder of its checkpoint and of the [`Model`] that did best so far.
    pub out: &'a Path,
    /// Stops it after the present step, with a checkpoint.
    pub cancel: &'a AtomicBool,
    /// Told of its steps and evaluations.
    pub observer: &'a mut dyn FnMut(&Event),
}

/// The last checkpoint of a run's folder.
pub fn last_checkpoint(out: &Path) -> PathBuf {
    out.join("last.checkpoint")
}

impl Training {
    /// The network's sizes.
    pub fn network(&self) -> Config {
        Config {
            width: self.width,
            hidden: self.hidden,
            history: self.history,
            without: self.without,
            ..Config::small(PLACES.into())
        }
    }

    /// How so many examples of each trajectory are drawn to evaluate it: seen as they were
    /// recorded.
    pub fn held_out(&self, per_trajectory: usize) -> SampleSettings {
        SampleSettings { held_out: true, per_trajectory, ..self.samples() }
    }

    /// How its batches are drawn.
    pub fn samples(&self) -> SampleSettings {
        SampleSettings {
            seed: self.seed,
            batch: self.batch,
            per_trajectory: self.per_trajectory,
            balance: self.balance,
            pool: self.pool,
            history: self.history as usize,
            rivals: self.rivals,
            held_out: false,
        }
    }

    /// Whether all fields are in their ranges.
    pub fn check(&self) -> Result<(), TrainError> {
        let must = |holds: bool, field, value: &dyn Display, must| {
            if holds {
                Ok(())
            } else {
                Err(TrainError::Config { field, value: value.to_string(), must })
            }
        };
        let width = self.width;
        let suits = matches!(width, 2 | 4 | 8) || width > 0 && width % 16 == 0;
        must(suits, "width", &width, "2, 4, 8 or a multiple of 16")?;
        let whole: [(&str, i64); 9] = [
            ("hidden", self.hidden),
            ("history", self.history),
            ("steps", self.steps as i64),
            ("batch", self.batch as i64),
            ("per_trajectory", self.per_trajectory as i64),
            ("evaluate_every", self.evaluate_every as i64),
            ("valid_per_trajectory", self.valid_per_trajectory as i64),
            ("patience", self.patience as i64),
            ("loss.hardest", self.loss.hardest),
        ];
        for (field, value) in whole {
            must(value > 0, field, &value, "positive")?;
        }
        for (field, value) in [("rate", self.rate), ("clip", self.clip)] {
            must(value > 0.0 && value.is_finite(), field, &value, "positive")?;
        }
        let weights = [
            ("weight_decay", self.weight_decay),
            ("loss.margin", self.loss.margin),
            ("loss.neighbours", self.loss.neighbours),
        ];
        for (field, value) in weights {
            must(value >= 0.0 && value.is_finite(), field, &value, "0 or more")?;
        }
        let shares = [
            ("balance", self.balance),
            ("final_rate", self.final_rate),
            ("loss.smoothing", self.loss.smoothing),
            ("loss.neighbour_smoothing", self.loss.neighbour_smoothing),
        ];
        for (field, value) in shares {
            must((0.0..=1.0).contains(&value), field, &value, "between 0 and 1")?;
        }
        Ok(())
    }

    /// Warm-up, then a cosine; `step` from 1.
    fn rate_at(&self, step: u64) -> f64 {
        if step <= self.warm_up {
            return self.rate * step as f64 / self.warm_up as f64;
        }
        let share =
            (step - self.warm_up) as f64 / (self.steps.saturating_sub(self.warm_up)).max(1) as f64;
        let cosine = 0.5 * (1.0 + (std::f64::consts::PI * share.min(1.0)).cos());
        self.rate * (self.final_rate + (1.0 - self.final_rate) * cosine)
    }
}

fn in_toml(table: &impl Serialize) -> String {
    toml::to_string(table).expect("plain data")
}

/// Trains a network, or goes on with the training whose checkpoint lies in the folder.
///
/// libtorch's generator of random numbers, which drops features, belongs to the whole process:
/// whoever draws from it meanwhile makes this another run.
///
/// A step with 64 examples of 32 x 32 cells takes about 0.35 s on two cores with f = 32. Needs
/// memory for the features of a batch, 1 GB, beside a few batches of examples.
pub fn train(dataset: &Dataset, training: &Training, run: Run<'_>) -> Result<End, TrainError> {
    training.check()?;
    let origin = Origin::of(dataset);
    let Run { device, out, cancel, observer } = run;
    if training.threads > 0 {
        tch::set_num_threads(training.threads as i32);
    }
    tch::manual_seed(training.seed as i64);
    let variables = VarStore::new(device);
    let network = FusionNet::new(&variables.root(), training.network());
    let parameters =
        weights::named(&variables).into_iter().map(|(_, parameter)| parameter).collect();
    let decay = AdamWSettings { weight_decay: training.weight_decay, ..AdamWSettings::default() };
    let mut optimiser = AdamW::new(parameters, decay);
    let (config, origin) = (in_toml(training), in_toml(&origin));

    let checkpoint = Checkpoint::new(&last_checkpoint(out), &format!("{config}{origin}"));
    let begun = checkpoint.load(&variables, &mut optimiser)?;
    let mut progress = begun.unwrap_or_default();
    if begun.is_none() {
        // Before all else, so that whatever a kill leaves in the folder can be gone on with.
        checkpoint.save(&variables, &optimiser, progress)?;
    }
    for (file, text) in [(Model::config_file(out), &config), (Model::origin_file(out), &origin)] {
        write_whole(&file, |file| file.write_all(text.as_bytes())).map_err(TrainError::File)?;
    }
    observer(&Event::Began { steps: progress.steps });
    if progress.waited >= training.patience {
        return Ok(End::Early);
    }

    let settings = training.samples();
    let held_out = training.held_out(training.valid_per_trajectory);
    let valid: Vec<Batch> =
        Batches::new(dataset, Split::Valid, &held_out, 0).collect::<Result<_, _>>()?;
    if valid.is_empty() {
        return Err(TrainError::Empty(
            "to evaluate with: each layout and size needs ten random instances",
        ));
    }

    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let (sender, receiver) = mpsc::sync_channel(4);
        let from = (progress.epoch, progress.batches);
        let (stop, settings) = (&stop, &settings);
        scope.spawn(move || feed(dataset, settings, from, stop, &sender));
        // Whatever ends the run ends its feeder, which waits for room in the channel.
        let _ended = Ended(stop);
        let receiver = receiver;
        while progress.steps < training.steps {
            if cancel.load(Ordering::Relaxed) {
                checkpoint.save(&variables, &optimiser, progress)?;
                return Ok(End::Cancelled);
            }
            let (epoch, batches, batch) =
                receiver.recv().expect("the feeder sends until it fails")?;
            let step = progress.steps + 1;
            tch::manual_seed((training.seed << 32 ^ step) as i64);
            let rate = training.rate_at(step);
            let (value, gradient) = learn(&network, &mut optimiser, &batch, training, rate, device);
            for (what, number) in [("loss", value), ("gradient", gradient)] {
                if !number.is_finite() {
                    return Err(TrainError::NotANumber { what, step });
                }
            }
            progress = Progress { steps: step, epoch, batches, ..progress };
            observer(&Event::Step {
                step,
                examples: batch.inputs.len(),
                loss: value,
                rate,
                gradient,
            });
            if step.is_multiple_of(training.evaluate_every) || step == training.steps {
                let evaluation = evaluate(&network, &valid, training, device);
                let best = evaluation.loss < progress.best_loss;
                if best {
                    weights::save(&variables, &Model::weights_file(out))?;
                    progress.best_loss = evaluation.loss;
                    progress.waited = 0;
                } else {
                    progress.waited += 1;
                }
                // What is told comes first: a run that goes on from a checkpoint has then told all
                // before it.
                observer(&Event::Evaluated { step, evaluation, best });
                checkpoint.save(&variables, &optimiser, progress)?;
                if progress.waited >= training.patience {
                    return Ok(End::Early);
                }
            }
        }
        Ok(End::Done)
    })
}

/// One step of training on a batch; gives its loss and the length of the gradient.
/// Where one is no number, nothing changes.
fn learn(
    network: &FusionNet,
    optimiser: &mut AdamW,
    batch: &Batch,
    training: &Training,
    rate: f64,
    device: Device,
) -> (f64, f64) {
    let (state, history) = batch.inputs.tensors(device);
    let proposals = network.forward(&state, &history, training.precision, true);
    let loss = loss(&proposals, &batch.targets(device), &training.loss);
    let value = loss.double_value(&[]);
    if !value.is_finite() {
        return (value, 0.0);
    }
    optimiser.zero_grad();
    loss.backward();
    (value, optimiser.step(rate, training.clip))
}

/// Seconds of steps of training on one batch over and over, by a network of its own, on the
/// processor.
pub fn measure_steps(
    training: &Training,
    batch: &Batch,
    steps: usize,
) -> Result<Vec<f64>, TrainError> {
    training.check()?;
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), training.network());
    let mut optimiser = AdamW::new(variables.trainable_variables(), AdamWSettings::default());
    let seconds = (0..steps).map(|_| {
        let begin = Instant::now();
        learn(&network, &mut optimiser, batch, training, training.rate, Device::Cpu);
        begin.elapsed().as_secs_f64()
    });
    Ok(seconds.collect())
}

/// Sets a flag when it goes.
struct Ended<'a>(&'a AtomicBool);

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// What the feeder sends: after it the epoch, and the batches taken from that; the batch.
type Fed = Result<(u64, u64, Batch), TrainError>;

/// Sends the batches of epoch after epoch, from so many batches into one on.
fn feed(
    dataset: &Dataset,
    settings: &SampleSettings,
    (first, skip): (u64, u64),
    stop: &AtomicBool,
    sender: &mpsc::SyncSender<Fed>,
) {
    // A sender whose receiver is gone has nobody to tell.
    let send = |fed| !stop.load(Ordering::Relaxed) && sender.send(fed).is_ok();
    for epoch in first.. {
        let mut batches = Batches::new(dataset, Split::Train, settings, epoch);
        let mut taken = if epoch == first { skip } else { 0 };
        if let Err(error) = batches.skip_batches(taken) {
            send(Err(error.into()));
            return;
        }
        let before = taken;
        for batch in batches {
            taken += 1;
            let failed = batch.is_err();
            if !send(batch.map(|batch| (epoch, taken, batch)).map_err(TrainError::from)) || failed {
                return;
            }
        }
        if taken == before && before == 0 {
            send(Err(TrainError::Empty("to learn from")));
            return;
        }
    }
}

/// Evaluates a network on batches, without changing it.
pub fn evaluate(
    network: &FusionNet,
    batches: &[Batch],
    training: &Training,
    device: Device,
) -> Evaluation {
    let mut evaluation = Evaluation::default();
    for batch in batches {
        let (state, history) = batch.inputs.tensors(device);
        let targets = batch.targets(device);
        let proposals = ask(network, &state, &history, training.precision);
        evaluation.loss += no_grad(|| loss(&proposals, &targets, &training.loss)).double_value(&[]);
        let hits = Hits::each(&proposals, &targets).into_iter();
        for (hits, (layout, &odds)) in hits.zip(batch.layouts.iter().zip(&batch.odds)) {
            evaluation.all.add(hits);
            let of_layout = evaluation.by_layout.entry(layout.clone()).or_default();
            of_layout.0.add(hits);
            of_layout.1.add(odds);
        }
    }
    evaluation.loss /= batches.len().max(1) as f64;
    evaluation
}
