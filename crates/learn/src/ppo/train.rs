//! Proximal policy optimisation, from top to bottom: configuration, seeds, storage, rollout,
//! advantages, update, logs.
//!
//! Schulman et al., "Proximal Policy Optimization Algorithms" (2017), with the implementation
//! details of the reference (`CleanRL`, `ppo.py`), from which it differs in four points:
//! - an episode that was truncated is continued in the estimate by the critic's value of its last
//!   observation, where the reference treats it as terminated;
//! - actions can be masked;
//! - environments can begin at different steps of their episodes;
//! - random numbers are those of [`random`](super::random), and a run can be resumed exactly.

use std::io::Write;
use std::path::{Path, PathBuf};

use beadwork_base::{Control, Interrupted};
use beadwork_dataset::{FileError, write_atomic};
use rand::seq::SliceRandom;
use tch::nn::VarStore;
use tch::{Device, Kind, Tensor, no_grad};
use thiserror::Error;

use super::categorical::{Categorical, draw};
use super::environment::{Environment, EpisodeEnd, Observation};
use super::evaluate::{Evaluation, evaluate};
use super::network::{Output, SpaceError, batch, permitted};
use super::policy::{Kept, Policy};
use super::random::{Purpose, action_draw, generator};
use super::range::RangeError;
use super::state::State;
use super::training_config::TrainingConfig;
use super::worker::{Finished, Worker};
use crate::adamw::{self, AdamW};
use crate::checkpoint::{Checkpoint, CheckpointError};
use crate::weights::{self, WeightsError};

/// Why a run cannot start or continue.
/// Existing checkpoints stay as they are.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A field of the configuration is outside its range.
    #[error(transparent)]
    Config(#[from] RangeError),
    /// The network cannot observe the environment.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// Training diverged, or a reward or an observation is not finite.
    #[error(
        "{what} is not finite in update {update}; check the environment's numbers, or try a lower \
         learning rate (the last checkpoint is from an earlier update)"
    )]
    NotFinite {
        /// The loss or the gradient.
        what: &'static str,
        /// The update, from 1.
        update: u64,
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
/// Steps are counted in all environments together.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The run started, or resumed from a checkpoint.
    /// Events of later steps, if the interrupted run has logged any, will be repeated.
    Started {
        /// Steps completed; 0 for a new run.
        steps: u64,
        /// Episodes completed.
        episodes: u64,
    },
    /// An episode is complete.
    Episode {
        /// Steps completed.
        steps: u64,
        /// Its number, from 1, in the order of completion.
        episode: u64,
        /// Sum of its rewards, as its environment [scores](Environment::score) it.
        episode_return: f64,
        /// Number of its steps.
        length: u64,
    },
    /// The mean return of the last episodes is the highest so far, and the policy was saved.
    Kept {
        /// Steps completed.
        steps: u64,
        /// Mean return of the last [`TrainingConfig::window`] episodes.
        mean_return: f64,
    },
    /// An update is complete.
    Updated(Update),
    /// The policy was evaluated.
    Evaluated {
        /// Steps completed.
        steps: u64,
        /// Episodes completed.
        episodes: u64,
        /// Returns of the evaluation's episodes.
        evaluation: Evaluation,
        /// Whether their mean is the highest so far; the policy has then been saved.
        best: bool,
    },
}

/// What an update measured.
/// Losses and shares are means over all minibatches, from before each one's optimiser step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Its number, from 1.
    pub update: u64,
    /// Steps completed.
    pub steps: u64,
    /// Episodes completed.
    pub episodes: u64,
    /// Mean return of the last [`TrainingConfig::window`] episodes; `None` before the first one.
    pub mean_return: Option<f64>,
    /// Learning rate.
    pub learning_rate: f64,
    /// Passes over the rollout, fewer than [`TrainingConfig::epochs`] if
    /// [`TrainingConfig::target_kl`] was exceeded.
    pub epochs: usize,
    /// Loss of the policy: minus the clipped objective.
    pub policy_loss: f64,
    /// Half the mean squared error of the critic.
    pub value_loss: f64,
    /// Mean entropy of the policy over permitted actions, in nats.
    pub entropy: f64,
    /// Approximate Kullback-Leibler divergence from the rollout's policy: the mean of
    /// `ratio - 1 - ln(ratio)`.
    pub approximate_kl: f64,
    /// Share of steps whose probability ratio was outside of `1 - clip ..= 1 + clip`.
    pub clip_fraction: f64,
    /// Share of the variance of returns that the critic explained before the update, at most 1;
    /// `None` if all returns are equal.
    pub explained_variance: Option<f64>,
    /// Norm of the gradient, before it was scaled down.
    pub gradient_norm: f64,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All steps are complete.
    Done,
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
    /// Folder of the run's checkpoint and of its best [policies](Policy); it must exist.
    pub out: &'a Path,
    /// Called with each event, on the calling thread.
    pub observer: &'a mut dyn FnMut(&Event),
}

/// The file of the last checkpoint in a run's folder.
pub fn last_checkpoint(out: &Path) -> PathBuf {
    out.join("last.checkpoint")
}

/// Trains a policy, or resumes the run whose checkpoint is in the output directory.
///
/// `make` makes an environment; all of them must be alike, and differ in their episodes by the
/// seeds that they are reset with.
/// They are stepped on the threads of `control`; the network computes on libtorch's threads, while
/// the environments wait.
/// The results are the same for any threads of `control`.
///
/// The policy is saved whenever the mean return of the last [`TrainingConfig::window`] episodes is
/// the highest so far ([`Kept::Training`]), whenever the mean return of an evaluation is
/// ([`Kept::Evaluation`]), and at the end ([`Kept::Last`]).
/// A checkpoint is written at the start, after each evaluation, at the end, and when the run is
/// interrupted.
/// A run that was interrupted or killed, and then resumed, ends with the same bytes as one that was
/// not.
///
/// Progress counts steps.
/// When `control` interrupts the run, it drops the rollout that it is in, which the resumed run
/// repeats, writes a checkpoint and returns [`End::Cancelled`] or [`End::TimeUp`].
///
/// # Panics
/// If an observation does not have the form of its environment's [`Space`](super::Space).
#[allow(clippy::too_many_lines, reason = "the algorithm is read from top to bottom")]
pub fn train<E: Environment>(
    make: &dyn Fn() -> E,
    config: &TrainingConfig,
    run: Run<'_>,
    control: &Control<'_>,
) -> Result<End, TrainError> {
    config.check()?;
    let Run { device, out, observer } = run;
    let &TrainingConfig { seed, environments: count, rollout: length, .. } = config;
    let per_update = config.steps_per_update();

    // The network and its optimiser.
    // The optimiser is Adam: AdamW without weight decay.
    if config.threads > 0 {
        tch::set_num_threads(config.threads as i32);
    }
    let environment = make();
    let (space, identity) = (environment.space(), environment.identity());
    drop(environment);
    let mut variables = VarStore::new(Device::Cpu);
    let mut weights_rng = generator(seed, Purpose::Weights, 0);
    let network = config.network.build(&variables.root(), &mut weights_rng, &space)?;
    variables.set_device(device);
    let parameters =
        weights::named(&variables).into_iter().map(|(_, parameter)| parameter).collect();
    let settings = adamw::Settings {
        epsilon: config.adam_epsilon,
        weight_decay: 0.0,
        ..adamw::Settings::default()
    };
    let mut optimiser = AdamW::new(parameters, settings);

    // Resume from the checkpoint, or write the first one.
    // It is written before all other files, so that a run killed at any time can be resumed.
    let resolved = config.resolved();
    let checkpoint =
        Checkpoint::new(&last_checkpoint(out), &format!("{identity}\n{resolved}"), str::to_owned);
    let resumed: Option<State> = checkpoint.load(&variables, &mut optimiser)?;
    let is_new = resumed.is_none();
    let mut state = resumed.unwrap_or_else(|| State::new(count));
    if is_new {
        checkpoint.save(&variables, &optimiser, &state)?;
    }
    write_atomic(&Policy::config_file(out), |file| file.write_all(resolved.as_bytes()))?;
    write_atomic(&Policy::space_file(out), |file| file.write_all(space.to_toml().as_bytes()))?;
    let mut steps = state.updates * per_update as u64;
    observer(&Event::Started { steps, episodes: state.episodes });
    control.report(steps as usize, config.steps as usize);

    // The environments, where the checkpoint left them.
    let new_worker = |number: usize| Worker::new(make(), number, seed, &state.positions[number]);
    let mut workers: Vec<Worker<E>> = (0..count).map(new_worker).collect();
    if state.updates == 0 && config.stagger > 0 {
        control.threads.map_mut(&mut workers, |_, worker| worker.stagger(config.stagger));
    }

    while state.updates < config.updates() {
        let update = state.updates + 1;
        let evaluations = state.episodes / config.evaluate_every;
        let before = state.clone();

        // Rollout: every environment makes the same number of steps with the same policy.
        // Storage has the axes [step, environment].
        let mut observations: Vec<Vec<Tensor>> = Vec::with_capacity(length);
        let mut masks: Vec<Tensor> = Vec::with_capacity(length);
        let mut actions: Vec<i64> = Vec::with_capacity(per_update);
        let mut log_probabilities: Vec<Tensor> = Vec::with_capacity(length);
        let mut values: Vec<f64> = Vec::with_capacity(per_update + count);
        let mut rewards: Vec<f64> = Vec::with_capacity(per_update);
        let mut ends: Vec<Option<EpisodeEnd>> = Vec::with_capacity(per_update);
        let mut truncated: Vec<(usize, Observation)> = Vec::new();
        for step in 0..length {
            if let Some(interrupted) = control.interrupted() {
                checkpoint.save(&variables, &optimiser, &before)?;
                return Ok(interrupted.into());
            }
            let seen: Vec<&Observation> = workers.iter().map(Worker::observation).collect();
            let (tensors, mask) = (batch(&seen, &space, device), permitted(&seen, device));
            let Output { logits, value } = no_grad(|| network.forward(&tensors));
            let policy = Categorical::new(&logits, &mask);
            let probabilities = to_vec(&policy.probabilities());
            if !probabilities.iter().all(|probability| probability.is_finite()) {
                return Err(TrainError::NotFinite { what: "a probability", update });
            }
            let draw = |(number, probabilities): (usize, &[f32])| {
                let number_of_step = state.updates * length as u64 + step as u64;
                draw(probabilities, action_draw(seed, number, number_of_step)) as i64
            };
            let chosen: Vec<i64> =
                probabilities.chunks_exact(space.actions).enumerate().map(draw).collect();
            let chosen_tensor = Tensor::from_slice(&chosen).to_device(device);
            log_probabilities.push(policy.log_probability(&chosen_tensor));
            values.extend(to_vec(&value).into_iter().map(f64::from));

            let step_worker =
                |number: usize, worker: &mut Worker<E>| worker.step(chosen[number] as usize);
            let outcomes = control.threads.map_mut(&mut workers, step_worker);
            steps += count as u64;
            for (number, outcome) in outcomes.into_iter().enumerate() {
                rewards.push(config.reward_scale * outcome.reward);
                ends.push(outcome.end);
                truncated.extend(outcome.truncated_at.map(|last| (step * count + number, last)));
                if let Some(Finished { episode_return, length }) = outcome.finished {
                    state.add_return(episode_return, config.window);
                    let episode = state.episodes;
                    observer(&Event::Episode { steps, episode, episode_return, length });
                }
            }
            observations.push(tensors);
            masks.push(mask);
            actions.extend(chosen);
            control.report(steps as usize, config.steps as usize);
        }

        // The policy that made these episodes is kept if they are the best so far.
        if state.recent.len() == config.window
            && let Some(mean_return) = state.mean_return()
            && mean_return > state.best_mean
        {
            state.best_mean = mean_return;
            weights::save_exact(&variables, &Policy::weights_file(out, Kept::Training))?;
            observer(&Event::Kept { steps, mean_return });
        }

        // Advantages and returns.
        // The value after a step is the next step's, 0 after the episode's end, or the value of the
        // last observation if the episode was truncated.
        let value_of = |observations: &[&Observation]| -> Vec<f64> {
            let output = no_grad(|| network.forward(&batch(observations, &space, device)));
            to_vec(&output.value).into_iter().map(f64::from).collect()
        };
        let last: Vec<&Observation> = workers.iter().map(Worker::observation).collect();
        let mut next_values = [&values[count..], &value_of(&last)].concat();
        let ended: Vec<bool> = ends.iter().map(Option::is_some).collect();
        for (next, _) in next_values.iter_mut().zip(&ended).filter(|(_, ended)| **ended) {
            *next = 0.0;
        }
        if !truncated.is_empty() {
            let last: Vec<&Observation> = truncated.iter().map(|(_, last)| last).collect();
            for ((index, _), value) in truncated.iter().zip(value_of(&last)) {
                next_values[*index] = value;
            }
        }
        let (gamma, lambda) = (config.gamma, config.gae_lambda);
        let advantages =
            advantages(&rewards, &values, &next_values, &ended, count, (gamma, lambda));
        let returns: Vec<f64> = advantages.iter().zip(&values).map(|(a, v)| a + v).collect();

        // Update: several passes over the rollout in shuffled minibatches.
        let axes = 0..space.observation.len();
        let all = Batch {
            observation: axes
                .map(|axis| {
                    let steps: Vec<&Tensor> = observations.iter().map(|step| &step[axis]).collect();
                    Tensor::cat(&steps, 0)
                })
                .collect(),
            permitted: Tensor::cat(&masks, 0),
            actions: Tensor::from_slice(&actions).to_device(device),
            log_probabilities: Tensor::cat(&log_probabilities, 0),
            values: single(&values, device),
            advantages: single(&advantages, device),
            returns: single(&returns, device),
        };
        drop((observations, masks, log_probabilities));
        let learning_rate = config.learning_rate_at(update);
        let mut order: Vec<i64> = (0..per_update as i64).collect();
        let mut shuffle = generator(seed, Purpose::Shuffle, update);
        let mut sums = [0.0; 6];
        let (mut minibatches, mut epochs) = (0, 0);
        for _ in 0..config.epochs {
            order.shuffle(&mut shuffle);
            let mut last_kl = 0.0;
            for indices in order.chunks_exact(per_update / config.minibatches) {
                let minibatch = all.select(&Tensor::from_slice(indices).to_device(device));
                let output = network.forward(&minibatch.observation);
                let losses = losses(&output, &minibatch, config);
                optimiser.zero_grad();
                losses.total.backward();
                let gradient_norm = optimiser.step(learning_rate, config.max_grad_norm);
                let [policy, value, entropy, kl, clipped] = losses.measures();
                for (what, value) in
                    [("loss", policy + value + entropy), ("gradient", gradient_norm)]
                {
                    if !value.is_finite() {
                        return Err(TrainError::NotFinite { what, update });
                    }
                }
                let measured = [policy, value, entropy, kl, clipped, gradient_norm];
                sums.iter_mut().zip(measured).for_each(|(sum, value)| *sum += value);
                last_kl = kl;
                minibatches += 1;
            }
            epochs += 1;
            if config.target_kl.is_some_and(|target| last_kl > target) {
                break;
            }
        }
        state.updates = update;
        state.positions = workers.iter().map(|worker| worker.position().clone()).collect();

        // Logs.
        let [policy_loss, value_loss, entropy, approximate_kl, clip_fraction, gradient_norm] =
            sums.map(|sum| sum / f64::from(minibatches));
        observer(&Event::Updated(Update {
            update,
            steps,
            episodes: state.episodes,
            mean_return: state.mean_return(),
            learning_rate,
            epochs,
            policy_loss,
            value_loss,
            entropy,
            approximate_kl,
            clip_fraction,
            explained_variance: explained_variance(&values, &returns),
            gradient_norm,
        }));

        // Evaluation and checkpoint.
        // The evaluation cannot be interrupted: the checkpoint of an update must include it.
        let is_last = update == config.updates();
        if state.episodes / config.evaluate_every > evaluations || is_last {
            let seeds = Evaluation::seeds(seed, config.evaluation_episodes);
            let threads = Control::on(control.threads);
            let evaluation = evaluate(make, network.as_ref(), &seeds, device, &threads)
                .expect("a control without limits never interrupts");
            let mean = evaluation.mean();
            let best = mean > state.best_evaluation;
            if best {
                state.best_evaluation = mean;
                weights::save_exact(&variables, &Policy::weights_file(out, Kept::Evaluation))?;
            }
            // Logged before the checkpoint is written, so that a resumed run never misses an event.
            observer(&Event::Evaluated { steps, episodes: state.episodes, evaluation, best });
            checkpoint.save(&variables, &optimiser, &state)?;
        }
    }
    weights::save_exact(&variables, &Policy::weights_file(out, Kept::Last))?;
    Ok(End::Done)
}

/// Advantages by the generalised estimate (Schulman et al., "High-Dimensional Continuous Control
/// Using Generalized Advantage Estimation", 2016, equation 16), cut off at the end of the rollout.
///
/// All slices have the axes `[step, environment]`.
/// `next_values` holds the value of the state after each step, which is 0 if the episode
/// terminated; `ended` says whether the episode ended with the step.
/// `gamma` and `lambda` are the discount and the decay, each from 0 to 1.
///
/// # Panics
/// If the slices differ in length.
pub fn advantages(
    rewards: &[f64],
    values: &[f64],
    next_values: &[f64],
    ended: &[bool],
    environments: usize,
    (gamma, lambda): (f64, f64),
) -> Vec<f64> {
    let count = rewards.len();
    let lengths = [values.len(), next_values.len(), ended.len()];
    assert!(lengths.iter().all(|&length| length == count), "{lengths:?}, {count} rewards");
    let mut advantages = vec![0.0; count];
    for index in (0..count).rev() {
        let surprise = rewards[index] + gamma * next_values[index] - values[index];
        let next = advantages.get(index + environments).copied().unwrap_or(0.0);
        let decay = if ended[index] { 0.0 } else { gamma * lambda };
        advantages[index] = surprise + decay * next;
    }
    advantages
}

/// Steps of a rollout, or some of them; all tensors begin with the axis of steps.
#[derive(Debug)]
pub struct Batch {
    /// Tensors of the observations.
    pub observation: Vec<Tensor>,
    /// Whether each action was permitted, `[step, action]`.
    pub permitted: Tensor,
    /// Number of the action, `[step]`.
    pub actions: Tensor,
    /// Logarithm of the action's probability in the rollout's policy, `[step]`.
    pub log_probabilities: Tensor,
    /// The critic's value during the rollout, `[step]`.
    pub values: Tensor,
    /// Advantage, `[step]`.
    pub advantages: Tensor,
    /// Advantage plus value: what the critic learns, `[step]`.
    pub returns: Tensor,
}

impl Batch {
    /// The steps with these numbers.
    fn select(&self, indices: &Tensor) -> Self {
        let of = |tensor: &Tensor| tensor.index_select(0, indices);
        Self {
            observation: self.observation.iter().map(of).collect(),
            permitted: of(&self.permitted),
            actions: of(&self.actions),
            log_probabilities: of(&self.log_probabilities),
            values: of(&self.values),
            advantages: of(&self.advantages),
            returns: of(&self.returns),
        }
    }
}

/// The loss of a minibatch and its parts, all scalars.
#[derive(Debug)]
pub struct Losses {
    /// `policy + value weight * value - entropy weight * entropy`, to be minimised.
    pub total: Tensor,
    /// Loss of the policy; see [`Update::policy_loss`].
    pub policy: Tensor,
    /// Loss of the critic; see [`Update::value_loss`].
    pub value: Tensor,
    /// Mean entropy.
    pub entropy: Tensor,
    /// Approximate divergence from the rollout's policy; see [`Update::approximate_kl`].
    pub approximate_kl: Tensor,
    /// Share of clipped steps; see [`Update::clip_fraction`].
    pub clip_fraction: Tensor,
}

impl Losses {
    /// Policy loss, value loss, entropy, divergence and share of clipped steps.
    fn measures(&self) -> [f64; 5] {
        let all =
            [&self.policy, &self.value, &self.entropy, &self.approximate_kl, &self.clip_fraction];
        all.map(|tensor| tensor.double_value(&[]))
    }
}

/// The loss of a minibatch (Schulman et al. 2017, equations 7 and 9).
///
/// Of the configuration it uses clipping, normalisation and weights.
pub fn losses(output: &Output, batch: &Batch, config: &TrainingConfig) -> Losses {
    let policy = Categorical::new(&output.logits, &batch.permitted);
    let log_ratio = policy.log_probability(&batch.actions) - &batch.log_probabilities;
    let ratio = log_ratio.exp();
    let (approximate_kl, clip_fraction) = no_grad(|| {
        let outside = (&ratio - 1.0).abs().gt(config.clip).to_kind(Kind::Float);
        ((&ratio - 1.0 - &log_ratio).mean(Kind::Float), outside.mean(Kind::Float))
    });

    let advantages = if config.normalise_advantages {
        let centred = &batch.advantages - batch.advantages.mean(Kind::Float);
        centred / (batch.advantages.std(true) + 1e-8)
    } else {
        batch.advantages.shallow_clone()
    };
    let clipped_ratio = ratio.clamp(1.0 - config.clip, 1.0 + config.clip);
    let gain = (&advantages * &ratio).minimum(&(&advantages * clipped_ratio));
    let policy_loss = -gain.mean(Kind::Float);

    let error = (&output.value - &batch.returns).square();
    let error = if config.clip_value {
        let change = (&output.value - &batch.values).clamp(-config.clip, config.clip);
        error.maximum(&(&batch.values + change - &batch.returns).square())
    } else {
        error
    };
    let value_loss = error.mean(Kind::Float) * 0.5;
    let entropy = policy.entropy().mean(Kind::Float);
    Losses {
        total: &policy_loss + &value_loss * config.value - &entropy * config.entropy,
        policy: policy_loss,
        value: value_loss,
        entropy,
        approximate_kl,
        clip_fraction,
    }
}

/// One minus the ratio of the variances of the critic's errors and of the returns; `None` if all
/// returns are equal.
fn explained_variance(values: &[f64], returns: &[f64]) -> Option<f64> {
    let variance = |numbers: &mut dyn Iterator<Item = f64>| {
        let numbers: Vec<f64> = numbers.collect();
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        numbers.iter().map(|number| (number - mean).powi(2)).sum::<f64>() / numbers.len() as f64
    };
    let of_returns = variance(&mut returns.iter().copied());
    let of_errors = variance(&mut returns.iter().zip(values).map(|(r, v)| r - v));
    (of_returns > 0.0).then(|| 1.0 - of_errors / of_returns)
}

/// All elements of a tensor in the order of its axes.
fn to_vec(tensor: &Tensor) -> Vec<f32> {
    Vec::try_from(tensor.contiguous().view([-1])).expect("single precision, one axis")
}

/// A vector in single precision.
fn single(values: &[f64], device: Device) -> Tensor {
    Tensor::from_slice(values).to_kind(Kind::Float).to_device(device)
}
