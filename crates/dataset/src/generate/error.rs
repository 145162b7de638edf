//! Errors of making a dataset.

use std::path::PathBuf;

use beadwork_base::Interrupted;
use thiserror::Error;

use crate::file::FileError;
use crate::manifest::ManifestError;
use crate::shard::{PackError, ShardError};
use crate::stratum::FactoryError;

/// Why a dataset cannot be made.
/// The messages name the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A combination of the configuration is impossible.
    #[error(transparent)]
    Factory(FactoryError),
    /// The folder has a manifest that cannot be read.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// The folder holds another dataset.
    #[error(
        "'{path}' belongs to a dataset of another configuration or version: \
         choose another folder",
        path = path.display()
    )]
    OtherDataset {
        /// The shard or manifest.
        path: PathBuf,
    },
    /// A shard of an earlier run is damaged.
    #[error(
        "cannot continue from '{path}': {cause}; remove the file to make the shard again",
        path = path.display()
    )]
    Shard {
        /// The shard.
        path: PathBuf,
        /// What is wrong with it.
        cause: ShardError,
    },
    /// Trajectories cannot be packed into a block.
    #[error("cannot write '{path}': {cause}", path = path.display())]
    Pack {
        /// The shard.
        path: PathBuf,
        /// Why not.
        cause: PackError,
    },
    /// The control ended the call before the first search.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<FactoryError> for GenerateError {
    fn from(error: FactoryError) -> Self {
        match error {
            FactoryError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Factory(error),
        }
    }
}
