//! A trained network in a folder: its configuration beside its weights.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use beadwork_dataset::Dataset;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tch::Device;
use tch::nn::VarStore;
use thiserror::Error;

use super::FusionNet;
use super::train::Training;
use crate::weights::{self, WeightsError};

/// A network that is ready to be asked.
#[derive(Debug)]
pub struct Model {
    /// How it was trained.
    pub training: Training,
    /// What on.
    pub origin: Origin,
    /// The network.
    pub network: FusionNet,
    /// Its parameters.
    pub variables: VarStore,
}

/// What dataset a network was trained on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Its [`Manifest::fingerprint`](beadwork_dataset::Manifest::fingerprint), sixteen hexadecimal
    /// digits.
    pub dataset: String,
    /// Its number of trajectories.
    pub trajectories: u64,
    /// Its number of moves.
    pub moves: u64,
}

impl Origin {
    /// Of networks that are trained on a dataset.
    pub fn of(dataset: &Dataset) -> Self {
        let manifest = dataset.manifest();
        Self {
            dataset: format!("{:016x}", manifest.fingerprint()),
            trajectories: manifest.records,
            moves: manifest.moves,
        }
    }
}

/// Why a folder holds no model that can be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A file is missing or can't be read.
    #[error("cannot read '{}': {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: io::Error,
    },
    /// A file does not say what it should.
    #[error("'{}' does not say how a network was trained: {message}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The weights are not those of the network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

impl Model {
    /// The file of the configuration in a folder.
    pub fn config_file(folder: &Path) -> PathBuf {
        folder.join("config.toml")
    }

    /// The file of the weights in a folder.
    pub fn weights_file(folder: &Path) -> PathBuf {
        folder.join("best.safetensors")
    }

    /// The file that names the dataset in a folder.
    pub fn origin_file(folder: &Path) -> PathBuf {
        folder.join("dataset.toml")
    }

    /// Reads a model, such as training leaves it: `config.toml`, `dataset.toml` and
    /// `best.safetensors`.
    pub fn open(folder: &Path, device: Device) -> Result<Self, ModelError> {
        let path = Self::config_file(folder);
        let training: Training = read(&path)?;
        training
            .check()
            .map_err(|error| ModelError::Malformed { path, message: error.to_string() })?;
        let origin = read(&Self::origin_file(folder))?;
        let variables = VarStore::new(device);
        let network = FusionNet::new(&variables.root(), training.network());
        weights::load(&variables, &Self::weights_file(folder))?;
        Ok(Self { training, origin, network, variables })
    }
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T, ModelError> {
    let text = fs::read_to_string(path)
        .map_err(|cause| ModelError::Unreadable { path: path.into(), cause })?;
    let malformed = |error: toml::de::Error| ModelError::Malformed {
        path: path.into(),
        message: error.to_string(),
    };
    toml::from_str(&text).map_err(malformed)
}
