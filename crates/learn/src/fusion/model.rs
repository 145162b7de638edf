//! A trained network in a folder: its configuration, the identity of its dataset, its weights.

use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use beadwork_dataset::Dataset;
use serde::{Deserialize, Serialize};
use tch::Device;
use tch::nn::VarStore;
use thiserror::Error;

use super::network::FusionNet;
use super::training_config::TrainingConfig;
use crate::weights::{self, WeightsError};

/// A trained network.
#[derive(Debug)]
pub struct Model {
    /// Training configuration.
    pub config: TrainingConfig,
    /// Identity of the dataset it was trained on.
    pub origin: Origin,
    /// The network.
    pub network: FusionNet,
    /// Its parameters.
    pub variables: VarStore,
}

/// Identity of the dataset that a network was trained on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// The dataset's [`Manifest::fingerprint`](beadwork_dataset::Manifest::fingerprint) as sixteen
    /// hexadecimal digits.
    pub dataset: String,
    /// Number of its trajectories.
    pub trajectories: u64,
    /// Number of its moves.
    pub moves: u64,
}

impl Origin {
    /// The identity of a dataset.
    pub fn of(dataset: &Dataset) -> Self {
        let manifest = dataset.manifest();
        Self {
            dataset: format!("{:016x}", manifest.fingerprint()),
            trajectories: manifest.records,
            moves: manifest.moves,
        }
    }

    fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// The content of `dataset.toml`.
    pub(super) fn to_toml(&self) -> String {
        toml::to_string(self).expect("an origin is plain data")
    }
}

/// Why a model cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A file is missing or cannot be read.
    #[error("cannot read '{}': {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: io::Error,
    },
    /// `config.toml` or `dataset.toml` has a syntax error, an unknown key or a wrong value.
    #[error("'{}' is malformed: {message}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The weights are missing or belong to another network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

impl Model {
    /// The file of the training configuration in a model's folder, `config.toml`.
    pub fn config_file(folder: &Path) -> PathBuf {
        folder.join("config.toml")
    }

    /// The file of the weights in a model's folder, `best.safetensors`.
    pub fn weights_file(folder: &Path) -> PathBuf {
        folder.join("best.safetensors")
    }

    /// The file of the dataset's identity in a model's folder, `dataset.toml`.
    pub fn origin_file(folder: &Path) -> PathBuf {
        folder.join("dataset.toml")
    }

    /// Opens the model in a folder, as training leaves it.
    pub fn open(folder: &Path, device: Device) -> Result<Self, ModelError> {
        let config = read(&Self::config_file(folder), TrainingConfig::from_toml)?;
        let origin = read(&Self::origin_file(folder), Origin::from_toml)?;
        let variables = VarStore::new(device);
        let network = FusionNet::new(&variables.root(), config.network());
        weights::load(&variables, &Self::weights_file(folder))?;
        Ok(Self { config, origin, network, variables })
    }
}

fn read<T, E: Display>(path: &Path, parse: impl Fn(&str) -> Result<T, E>) -> Result<T, ModelError> {
    let text = fs::read_to_string(path)
        .map_err(|cause| ModelError::Unreadable { path: path.into(), cause })?;
    let malformed =
        |error: E| ModelError::Malformed { path: path.into(), message: error.to_string() };
    parse(&text).map_err(malformed)
}
