//! A trained policy in a folder: configuration, form of observations and actions, weights.

use std::fmt;
use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tch::nn::VarStore;
use tch::{Device, no_grad};
use thiserror::Error;

use super::categorical::{Categorical, likeliest};
use super::environment::{Observation, Space};
use super::network::{ActorCritic, SpaceError, batch, permitted};
use super::random::{Purpose, generator};
use super::training_config::TrainingConfig;
use crate::weights::{self, WeightsError};

/// Which policy of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// The one with the highest mean return of [`TrainingConfig::window`] training episodes,
    /// `best.safetensors`: the paper's rule.
    Training,
    /// The one with the highest mean return in an evaluation, `greedy.safetensors`.
    Evaluation,
    /// The one after the last update of a complete run, `last.safetensors`.
    Last,
}

/// A trained policy.
pub struct Policy {
    /// Training configuration.
    pub config: TrainingConfig,
    /// Form of the observations and actions.
    pub space: Space,
    /// The network.
    pub network: Box<dyn ActorCritic>,
    /// Its parameters.
    pub variables: VarStore,
}

impl fmt::Debug for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { config, space, .. } = self;
        f.debug_struct("Policy")
            .field("config", config)
            .field("space", space)
            .finish_non_exhaustive()
    }
}

/// Why a policy cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PolicyError {
    /// A file is missing or cannot be read.
    #[error("cannot read '{}': {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: io::Error,
    },
    /// `config.toml` or `space.toml` has a syntax error, an unknown key or a wrong value.
    #[error("'{}' is malformed: {message}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The network of `config.toml` cannot observe what `space.toml` describes.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// The weights are missing or belong to another network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

impl Policy {
    /// The file of the training configuration in a folder, `config.toml`.
    pub fn config_file(folder: &Path) -> PathBuf {
        folder.join("config.toml")
    }

    /// The file of the form of observations and actions in a folder, `space.toml`.
    pub fn space_file(folder: &Path) -> PathBuf {
        folder.join("space.toml")
    }

    /// The file of a policy's weights in a folder.
    pub fn weights_file(folder: &Path, kept: Kept) -> PathBuf {
        folder.join(match kept {
            Kept::Training => "best.safetensors",
            Kept::Evaluation => "greedy.safetensors",
            Kept::Last => "last.safetensors",
        })
    }

    /// Opens a policy in a folder, as training leaves it.
    pub fn open(folder: &Path, kept: Kept, device: Device) -> Result<Self, PolicyError> {
        let config = read(&Self::config_file(folder), TrainingConfig::from_toml)?;
        let space = read(&Self::space_file(folder), Space::from_toml)?;
        let mut variables = VarStore::new(Device::Cpu);
        let mut rng = generator(config.seed, Purpose::Weights, 0);
        let network = config.network.build(&variables.root(), &mut rng, &space)?;
        variables.set_device(device);
        weights::load(&variables, &Self::weights_file(folder, kept))?;
        Ok(Self { config, space, network, variables })
    }

    /// Probability of each action; exactly 0 for those that are not permitted.
    ///
    /// # Panics
    /// If the observation does not fit the policy's space.
    pub fn probabilities(&self, observation: &Observation) -> Vec<f32> {
        assert!(self.space.fits(observation), "the observation does not fit the policy's space");
        let (seen, device) = (&[observation], self.variables.device());
        let output = no_grad(|| self.network.forward(&batch(seen, &self.space, device)));
        let policy = Categorical::new(&output.logits, &permitted(seen, device));
        Vec::try_from(policy.probabilities().contiguous().view([-1]))
            .expect("single precision, one axis")
    }

    /// The most likely permitted action, the first of several.
    ///
    /// # Panics
    /// If the observation does not fit the policy's space, or holds numbers that are not finite.
    pub fn act(&self, observation: &Observation) -> usize {
        likeliest(&self.probabilities(observation))
    }
}

fn read<T, E: Display>(
    path: &Path,
    parse: impl Fn(&str) -> Result<T, E>,
) -> Result<T, PolicyError> {
    let text = fs::read_to_string(path)
        .map_err(|cause| PolicyError::Unreadable { path: path.into(), cause })?;
    let malformed =
        |error: E| PolicyError::Malformed { path: path.into(), message: error.to_string() };
    parse(&text).map_err(malformed)
}
