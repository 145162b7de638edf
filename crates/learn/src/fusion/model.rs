//! A trained network in a folder: its configuration beside its weights.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

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
    /// The network.
    pub network: FusionNet,
    /// Its parameters.
    pub variables: VarStore,
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
    /// The configuration is none.
    #[error("'{}' is no configuration of a training: {message}", path.display())]
    Config {
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

    /// Reads a model, such as training leaves it: `config.toml` and `best.safetensors`.
    pub fn open(folder: &Path, device: Device) -> Result<Self, ModelError> {
        let path = Self::config_file(folder);
        let text = fs::read_to_string(&path)
            .map_err(|cause| ModelError::Unreadable { path: path.clone(), cause })?;
        let config = |message: String| ModelError::Config { path: path.clone(), message };
        let training: Training = toml::from_str(&text).map_err(|error| config(error.message().into()))?;
        training.check().map_err(|error| config(error.to_string()))?;
        let variables = VarStore::new(device);
        let network = FusionNet::new(&variables.root(), training.network());
        weights::load(&variables, &Self::weights_file(folder))?;
        Ok(Self { training, network, variables })
    }
}
