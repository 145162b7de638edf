//! Training configuration of PPO.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::fields::FieldsConfig;
use super::network::NetworkConfig;
use super::range::{RangeError, require};

/// Training configuration of PPO.
///
/// The source of each default is given in brackets:
/// - \[PPO\]: Schulman et al., "Proximal Policy Optimization Algorithms" (2017);
/// - \[paper\]: Kim et al. 2026, the paper on toolpaths for even temperature;
/// - \[reference\]: the file `ppo.py` of `CleanRL`, which follows "The 37 Implementation Details of
///   Proximal Policy Optimization" (Huang et al. 2022);
/// - \[own\]: chosen here.
///
/// A run's results depend on the configuration, the environment, and rounding, which differs
/// between machines and numbers of threads of libtorch.
/// Construct it with `..TrainingConfig::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingConfig {
    /// Seed of the initial weights, the episodes, the actions and the minibatches.
    pub seed: u64,
    /// Steps in all environments together, 500,000 \[paper\]; a last incomplete rollout is left
    /// out.
    pub steps: u64,
    /// Environments that are stepped together, 8 \[PPO, its Atari experiments\].
    pub environments: usize,
    /// Environments begin at different steps of their first episodes: each makes a random number of
    /// random permitted steps, up to this number, before the run; 0 \[reference\].
    ///
    /// Without it, environments whose episodes have the same length stay in step, and a rollout
    /// that is shorter than an episode sees a part of it only.
    #[serde(skip_serializing_if = "is_zero")]
    pub stagger: u32,
    /// Steps in each environment between two updates, 128 \[PPO, its Atari experiments;
    /// reference\].
    pub rollout: usize,
    /// Discount of the reward of the next step, 0..=1: 0.99 \[PPO; reference\].
    pub gamma: f64,
    /// Decay of the generalised advantage estimate, 0..=1: 0.95 \[PPO; reference\].
    /// At 0 the critic's next value stands for all rewards after the next, at 1 none of them.
    pub gae_lambda: f64,
    /// Factor of rewards before anything is computed from them, 1 \[own\].
    /// Returns in logs are without it.
    /// The critic learns best if it makes returns about as large as 1.
    pub reward_scale: f64,
    /// Passes over the steps of a rollout in an update, 4 \[reference\].
    pub epochs: usize,
    /// Minibatches of a pass, 4 \[reference\]; they must divide `environments * rollout`.
    pub minibatches: usize,
    /// Learning rate of Adam, 3e-4 \[paper; PPO, its `MuJoCo` experiments\].
    pub learning_rate: f64,
    /// Whether the learning rate falls linearly from update to update, towards 0 after the last one
    /// \[reference\].
    pub anneal_learning_rate: bool,
    /// Added to the root of the mean of squares in Adam, 1e-5 \[reference\].
    pub adam_epsilon: f64,
    /// Change of the probability ratio beyond which the policy gains nothing, 0.2 \[paper; PPO\].
    pub clip: f64,
    /// Whether advantages are brought to mean 0 and standard deviation 1 in each minibatch
    /// \[reference\].
    pub normalise_advantages: bool,
    /// Weight of the entropy bonus, 0.01 \[PPO, its Atari experiments; reference\].
    pub entropy: f64,
    /// Weight of the value loss, 0.5 \[reference\].
    pub value: f64,
    /// Whether the value loss is the larger one of two: of the value, and of the value whose change
    /// since the rollout is clipped to `clip` \[reference\].
    pub clip_value: bool,
    /// Maximum norm of the gradient of all parameters together, 0.5 \[reference\]; longer gradients
    /// are scaled down to it.
    pub max_grad_norm: f64,
    /// Approximate KL divergence from the rollout's policy after which no further pass is made;
    /// compared with the last minibatch of a pass.
    /// Without a value all passes are made \[reference\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_kl: Option<f64>,
    /// Episodes between evaluations, 50 \[paper\].
    /// An evaluation waits for the update that follows the last of these episodes.
    pub evaluate_every: u64,
    /// Episodes of an evaluation, in which the most likely actions are chosen: 1 \[own\], enough if
    /// all episodes are alike.
    pub evaluation_episodes: usize,
    /// Weights are kept whenever the mean return of this number of episodes improves, 100
    /// \[paper\].
    pub window: usize,
    /// Number of threads of libtorch; 0 for one thread per core.
    pub threads: usize,
    /// The network.
    pub network: NetworkConfig,
}

impl Default for TrainingConfig {
    fn default() -> Self {
        Self {
            seed: 0,
            steps: 500_000,
            environments: 8,
            stagger: 0,
            rollout: 128,
            gamma: 0.99,
            gae_lambda: 0.95,
            reward_scale: 1.0,
            epochs: 4,
            minibatches: 4,
            learning_rate: 3e-4,
            anneal_learning_rate: true,
            adam_epsilon: 1e-5,
            clip: 0.2,
            normalise_advantages: true,
            entropy: 0.01,
            value: 0.5,
            clip_value: true,
            max_grad_norm: 0.5,
            target_kl: None,
            evaluate_every: 50,
            evaluation_episodes: 1,
            window: 100,
            threads: 0,
            network: NetworkConfig::default(),
        }
    }
}

/// Whether a setting is off, so that it is not written.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(value: &u32) -> bool {
    *value == 0
}

/// Why a training configuration is invalid.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TrainingConfigError {
    /// The text is not valid TOML, or has an unknown key or a value of the wrong type.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A field is outside its range.
    #[error(transparent)]
    Range(#[from] RangeError),
}

impl TrainingConfig {
    /// The configuration of the reference implementation for the task `CartPole-v1`: four
    /// environments, learning rate 2.5e-4, evaluations of ten episodes.
    ///
    /// `CleanRL`, `ppo.py`: 490.04 ± 6.12 after 500,000 steps, the mean return of three seeds.
    pub fn cart_pole() -> Self {
        Self { environments: 4, learning_rate: 2.5e-4, evaluation_episodes: 10, ..Self::default() }
    }

    /// The paper's training of a policy for one part, as far as the paper gives it.
    ///
    /// Rollouts are short, so that their observations of 128 x 128 x 128 voxels take 2 GB.
    pub fn paper() -> Self {
        let network = NetworkConfig::Fields(FieldsConfig::paper());
        Self { rollout: 32, network, ..Self::default() }
    }

    /// A policy for one part on a processor: few channels and few steps.
    ///
    /// The order of a layer hardly changes what later layers gain, so the discount is low: rewards
    /// of later layers would mostly add noise.
    /// Differences between the best orders are some hundredths of a kelvin a layer, so the rewards
    /// are scaled up and the entropy bonus is small.
    pub fn small() -> Self {
        Self {
            steps: 16_000,
            environments: 16,
            rollout: 24,
            gamma: 0.2,
            gae_lambda: 0.9,
            reward_scale: 4.0,
            entropy: 0.003,
            clip_value: false,
            network: NetworkConfig::Fields(FieldsConfig::small()),
            ..Self::default()
        }
    }

    /// A policy for one part whose candidates are described by estimates
    /// ([`HeatSettings::estimated`](super::HeatSettings::estimated)), on a processor.
    ///
    /// Differs from [`small`](Self::small) as follows:
    /// - rollouts of 96 steps in place of 384, since estimates lead to good candidates within some
    ///   updates: the policies of the paper's parts are nearly the best after some 40 updates;
    /// - environments are staggered, so that a rollout sees all heights of a part: with the 77
    ///   layers of the paper's pyramid in step, the policy forgot lower layers while it saw higher
    ///   ones;
    /// - the learning rate and the entropy bonus are higher, so that it learns within few steps and
    ///   does not settle on the first candidate that is good in all layers;
    /// - the discount is 0: the order of a layer hardly changes what others gain.
    pub fn estimated() -> Self {
        Self {
            steps: 9600,
            stagger: 80,
            rollout: 6,
            gamma: 0.0,
            learning_rate: 5e-4,
            entropy: 0.01,
            threads: 1,
            ..Self::small()
        }
    }

    /// A policy that acts on parts it was not trained on, on a processor.
    ///
    /// Every episode has another part, so that more steps are needed than for one part, and an
    /// evaluation takes several episodes.
    /// The order of a layer hardly changes what later layers gain, so the discount is 0. One thread
    /// of libtorch leaves the others to the solver.
    pub fn general() -> Self {
        Self {
            steps: 160_000,
            environments: 32,
            rollout: 16,
            gamma: 0.0,
            learning_rate: 5e-4,
            entropy: 0.005,
            evaluate_every: 500,
            evaluation_episodes: 32,
            window: 400,
            threads: 1,
            network: NetworkConfig::Fields(FieldsConfig { units: 128, ..FieldsConfig::small() }),
            ..Self::small()
        }
    }

    /// Reads and checks a configuration.
    /// Missing keys have their defaults.
    pub fn from_toml(text: &str) -> Result<Self, TrainingConfigError> {
        let config: Self = toml::from_str(text)?;
        config.check()?;
        Ok(config)
    }

    /// Steps of a rollout in all environments together.
    pub fn steps_per_update(&self) -> usize {
        self.environments * self.rollout
    }

    /// Number of updates of the run.
    pub fn updates(&self) -> u64 {
        self.steps / self.steps_per_update() as u64
    }

    /// Learning rate of an update, from 1.
    pub fn learning_rate_at(&self, update: u64) -> f64 {
        if !self.anneal_learning_rate {
            return self.learning_rate;
        }
        self.learning_rate * (1.0 - (update - 1) as f64 / self.updates() as f64)
    }

    /// Checks that all fields are in their ranges.
    pub fn check(&self) -> Result<(), RangeError> {
        let counts = [
            ("environments", self.environments as u64),
            ("rollout", self.rollout as u64),
            ("epochs", self.epochs as u64),
            ("minibatches", self.minibatches as u64),
            ("evaluate_every", self.evaluate_every),
            ("evaluation_episodes", self.evaluation_episodes as u64),
            ("window", self.window as u64),
        ];
        for (field, value) in counts {
            let range = 1..=u64::from(u32::MAX);
            require(range.contains(&value), field, &value, "at least 1 and below 2^32")?;
        }
        let steps = self.steps_per_update();
        require(
            steps.is_multiple_of(self.minibatches),
            "minibatches",
            &self.minibatches,
            "a divisor of environments times rollout",
        )?;
        require(
            !self.normalise_advantages || steps / self.minibatches > 1,
            "minibatches",
            &self.minibatches,
            "at least two steps in a minibatch, whose advantages are normalised",
        )?;
        let enough = self.steps >= steps as u64;
        require(enough, "steps", &self.steps, "at least environments times rollout")?;
        let positive = [
            ("learning_rate", self.learning_rate),
            ("adam_epsilon", self.adam_epsilon),
            ("clip", self.clip),
            ("max_grad_norm", self.max_grad_norm),
            ("reward_scale", self.reward_scale),
            ("target_kl", self.target_kl.unwrap_or(1.0)),
        ];
        for (field, value) in positive {
            require(value > 0.0 && value.is_finite(), field, &value, "a positive number")?;
        }
        for (field, value) in [("entropy", self.entropy), ("value", self.value)] {
            require(value >= 0.0 && value.is_finite(), field, &value, "0 or a positive number")?;
        }
        for (field, value) in [("gamma", self.gamma), ("gae_lambda", self.gae_lambda)] {
            require((0.0..=1.0).contains(&value), field, &value, "a number from 0 to 1")?;
        }
        self.network.check()
    }

    /// The resolved configuration: TOML text of all fields, defaults included.
    pub fn resolved(&self) -> String {
        toml::to_string(self).expect("a configuration is plain data")
    }
}
