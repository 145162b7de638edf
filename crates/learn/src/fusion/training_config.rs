//! Training configuration: what `configs/train/*.toml` and a model's `config.toml` hold.

use std::fmt::Display;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::config::{Ablation, Config, MAX_SIDE, Precision};
use super::loss;
use super::samples::{Negatives, Settings};

/// Training configuration.
///
/// A run's results depend on the configuration, the dataset, and rounding, which differs between
/// machines and numbers of threads.
/// Construct it with `..TrainingConfig::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingConfig {
    /// Seed of the initial weights, the batches and dropout.
    pub seed: u64,
    /// Channels of the network's first level, f: 2, 4, 8 or a multiple of 16.
    pub width: i64,
    /// Hidden units of each recurrent layer.
    pub hidden: i64,
    /// Moves of the history that the network sees, K.
    pub history: i64,
    /// Part of the network that is bypassed.
    #[serde(alias = "without")]
    pub ablation: Ablation,
    /// Precision of convolutions.
    pub precision: Precision,
    /// Steps, each on one batch, unless training stops early.
    pub steps: u64,
    /// Examples in a batch on a canvas of 32 x 32 cells; larger canvases have proportionally fewer.
    pub batch: usize,
    /// Examples drawn from a trajectory in each epoch on a canvas of 32 x 32 cells; larger canvases
    /// have proportionally fewer.
    pub per_trajectory: usize,
    /// Share of the examples, 0..=1, that are drawn evenly from all depths, from the layer's sides
    /// to its centre.
    pub balance: f64,
    /// Size of the shuffle buffer of each canvas, in batches.
    pub pool: usize,
    /// Which positions are negatives.
    #[serde(alias = "rivals")]
    pub negatives: Negatives,
    /// Weights and margins of the loss.
    pub loss: loss::Settings,
    /// Maximum learning rate, reached after the warm-up.
    #[serde(alias = "rate")]
    pub learning_rate: f64,
    /// Steps of linear warm-up from 0 to the maximum learning rate.
    #[serde(alias = "warm_up")]
    pub warmup_steps: u64,
    /// Learning rate of the last step as a share of the maximum, 0..=1; the decay is a cosine.
    #[serde(alias = "final_rate")]
    pub final_learning_rate_ratio: f64,
    /// Decoupled weight decay of `AdamW`.
    pub weight_decay: f64,
    /// Maximum norm of the gradient of all parameters together; longer gradients are scaled down to
    /// it.
    #[serde(alias = "clip")]
    pub max_grad_norm: f64,
    /// Steps between evaluations; a checkpoint is written after each.
    pub evaluate_every: u64,
    /// Examples drawn from each validation trajectory, whatever its size.
    pub valid_per_trajectory: usize,
    /// Evaluations without a lower validation loss after which training stops early, at least 1.
    pub patience: u64,
    /// Number of threads of libtorch; 0 for one thread per core.
    pub threads: usize,
}

impl Default for TrainingConfig {
    fn default() -> Self {
        Self {
            seed: 0,
            width: 32,
            hidden: 192,
            history: 32,
            ablation: Ablation::None,
            precision: Precision::Single,
            steps: 10_000,
            batch: 64,
            per_trajectory: 96,
            balance: 0.3,
            pool: 24,
            negatives: Negatives::Applicable,
            loss: loss::Settings::default(),
            learning_rate: 4e-4,
            warmup_steps: 300,
            final_learning_rate_ratio: 0.02,
            weight_decay: 1e-2,
            max_grad_norm: 1.0,
            evaluate_every: 500,
            valid_per_trajectory: 2,
            patience: 40,
            threads: 0,
        }
    }
}

/// Why a training configuration is invalid.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TrainingConfigError {
    /// The text is not valid TOML, or has an unknown key or a value of the wrong type.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A field is outside its range.
    #[error("{field} is {value}: expected {expected}")]
    Range {
        /// The field's key.
        field: &'static str,
        /// Its value.
        value: String,
        /// Its range.
        expected: &'static str,
    },
}

/// Beginnings of lines in resolved configurations of earlier versions, and their replacements.
const RENAMED: [(&str, &str); 7] = [
    ("without = \"nothing\"", "ablation = \"none\""),
    ("without = ", "ablation = "),
    ("rivals = ", "negatives = "),
    ("rate = ", "learning_rate = "),
    ("warm_up = ", "warmup_steps = "),
    ("final_rate = ", "final_learning_rate_ratio = "),
    ("clip = ", "max_grad_norm = "),
];

impl TrainingConfig {
    /// Reads and checks a configuration.
    /// Missing keys have their defaults; the keys of earlier versions are accepted.
    pub fn from_toml(text: &str) -> Result<Self, TrainingConfigError> {
        let config: Self = toml::from_str(text)?;
        config.check()?;
        Ok(config)
    }

    /// Sizes of the network.
    pub fn network(&self) -> Config {
        Config {
            width: self.width,
            hidden: self.hidden,
            history: self.history,
            ablation: self.ablation,
            ..Config::small(MAX_SIDE.into())
        }
    }

    /// How training examples are drawn.
    pub fn samples(&self) -> Settings {
        Settings {
            seed: self.seed,
            batch: self.batch,
            per_trajectory: self.per_trajectory,
            balance: self.balance,
            pool: self.pool,
            history: self.history as usize,
            negatives: self.negatives,
            held_out: false,
        }
    }

    /// How examples for evaluation are drawn: `per_trajectory` from each trajectory, without
    /// symmetry.
    pub fn held_out(&self, per_trajectory: usize) -> Settings {
        Settings { held_out: true, per_trajectory, ..self.samples() }
    }

    /// Learning rate of a step, from 1: linear warm-up, then cosine decay.
    pub fn learning_rate_at(&self, step: u64) -> f64 {
        if step <= self.warmup_steps {
            return self.learning_rate * step as f64 / self.warmup_steps as f64;
        }
        let decay_steps = self.steps.saturating_sub(self.warmup_steps).max(1);
        let share = (step - self.warmup_steps) as f64 / decay_steps as f64;
        let cosine = 0.5 * (1.0 + (std::f64::consts::PI * share.min(1.0)).cos());
        let last = self.final_learning_rate_ratio;
        self.learning_rate * (last + (1.0 - last) * cosine)
    }

    /// Checks that all fields are in their ranges.
    pub fn check(&self) -> Result<(), TrainingConfigError> {
        let require = |holds: bool, field, value: &dyn Display, expected| {
            if holds {
                Ok(())
            } else {
                Err(TrainingConfigError::Range { field, value: value.to_string(), expected })
            }
        };
        let width = self.width;
        let is_divisible = matches!(width, 2 | 4 | 8) || width > 0 && width % 16 == 0;
        require(is_divisible, "width", &width, "2, 4, 8 or a multiple of 16")?;
        let counts: [(&str, i64); 9] = [
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
        for (field, value) in counts {
            require(value > 0, field, &value, "at least 1")?;
        }
        let rates = [("learning_rate", self.learning_rate), ("max_grad_norm", self.max_grad_norm)];
        for (field, value) in rates {
            require(value > 0.0 && value.is_finite(), field, &value, "a positive number")?;
        }
        let weights = [
            ("weight_decay", self.weight_decay),
            ("loss.margin", self.loss.margin),
            ("loss.neighbours", self.loss.neighbours),
        ];
        for (field, value) in weights {
            require(value >= 0.0 && value.is_finite(), field, &value, "0 or a positive number")?;
        }
        let shares = [
            ("balance", self.balance),
            ("final_learning_rate_ratio", self.final_learning_rate_ratio),
            ("loss.smoothing", self.loss.smoothing),
            ("loss.neighbour_smoothing", self.loss.neighbour_smoothing),
        ];
        for (field, value) in shares {
            require((0.0..=1.0).contains(&value), field, &value, "a number from 0 to 1")?;
        }
        Ok(())
    }

    /// The resolved configuration: TOML text of all fields, defaults included.
    pub fn resolved(&self) -> String {
        toml::to_string(self).expect("a configuration is plain data")
    }

    /// Brings the resolved configuration of an earlier version up to date, key by key, so that it
    /// can be compared with one of this version.
    pub(super) fn upgrade_resolved(text: &str) -> String {
        let upgrade = |line: &str| {
            let renamed = RENAMED.iter().find(|(old, _)| line.starts_with(old));
            renamed.map_or(line.to_owned(), |(old, new)| line.replacen(old, new, 1))
        };
        text.split_inclusive('\n').map(upgrade).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    /// As version 0.1.0 wrote it: the configuration of `models/fusion-small`.
    const OLD: &str = include_str!("../../../../models/fusion-small/config.toml");

    #[test]
    fn old_keys_are_read() {
        let old: TrainingConfig = toml::from_str(OLD).unwrap();
        assert_eq!(old, TrainingConfig { steps: 8000, ..TrainingConfig::default() });
        let both = "rate = 0.1\nlearning_rate = 0.1";
        assert!(toml::from_str::<TrainingConfig>(both).is_err());
    }

    #[test]
    fn old_resolved_configurations_are_upgraded() {
        let old: TrainingConfig = toml::from_str(OLD).unwrap();
        assert_eq!(TrainingConfig::upgrade_resolved(OLD), old.resolved());
        let new = old.resolved();
        assert_eq!(TrainingConfig::upgrade_resolved(&new), new);
        let history = TrainingConfig::upgrade_resolved("without = \"history\"\n");
        assert_eq!(history, "ablation = \"history\"\n");
    }
}
