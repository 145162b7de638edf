//! Parameters in files: safetensors, by the names that PyTorch gives them.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use beadwork_dataset::{FileError, write_whole_at};
use tch::nn::VarStore;
use tch::{Kind, TchError, Tensor, no_grad};
use thiserror::Error;

/// Why a file's parameters are not those of a network.
/// Nothing is changed by what is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// The file can't be read: it is missing, cut short or something else.
    #[error("'{}' is no file of weights", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What libtorch says.
        source: TchError,
    },
    /// The network has a parameter that the file lacks.
    #[error("'{}' has no '{name}'", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The parameter.
        name: String,
    },
    /// The file has a parameter that the network lacks.
    #[error("'{}' has '{name}', which the network has not", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The parameter.
        name: String,
    },
    /// The file can't be written; what had its name stays.
    #[error(transparent)]
    Unwritten(#[from] FileError),
    /// A parameter has another shape.
    #[error("'{name}' in '{}' has the shape {got:?}: the network's is {expected:?}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// The parameter.
        name: String,
        /// The network's.
        expected: Vec<i64>,
        /// The file's.
        got: Vec<i64>,
    },
}

/// Writes all parameters of a network in half precision, as a file that is whole or absent.
///
/// That halves the file, and moves each parameter by less than the last steps of a training do: 1
/// part in 2000.
pub fn save(variables: &VarStore, path: &Path) -> Result<(), WeightsError> {
    let mut named = named(variables);
    named.iter_mut().for_each(|(_, parameter)| *parameter = parameter.to_kind(Kind::Half));
    save_tensors(&named, path)
}

/// All parameters of a network, in the order of their names.
pub(crate) fn named(variables: &VarStore) -> Vec<(String, Tensor)> {
    let mut named: Vec<_> = variables.variables().into_iter().collect();
    named.sort_by(|(name, _), (other, _)| name.cmp(other));
    named
}

/// Writes tensors by their names, as a file that is whole or absent.
pub(crate) fn save_tensors(named: &[(String, Tensor)], path: &Path) -> Result<(), WeightsError> {
    Ok(write_whole_at(path, |partial| {
        Tensor::write_safetensors(named, partial).map_err(io::Error::other)
    })?)
}

/// Reads all parameters of a network: the file must have just these names and shapes.
/// Numbers of other kinds are converted.
pub fn load(variables: &VarStore, path: &Path) -> Result<(), WeightsError> {
    fill(variables, &mut read_tensors(path)?, path)
}

/// All tensors of a file.
pub(crate) fn read_tensors(path: &Path) -> Result<HashMap<String, Tensor>, WeightsError> {
    let read = Tensor::read_safetensors(path);
    Ok(read
        .map_err(|source| WeightsError::Unreadable { path: path.into(), source })?
        .into_iter()
        .collect())
}

/// Sets all parameters of a network to the tensors of a file, which must be theirs and no others.
pub(crate) fn fill(
    variables: &VarStore,
    read: &mut HashMap<String, Tensor>,
    path: &Path,
) -> Result<(), WeightsError> {
    let own = named(variables);
    let mut pairs = Vec::with_capacity(own.len());
    for (name, variable) in own {
        let Some(tensor) = read.remove(&name) else {
            return Err(WeightsError::Missing { path: path.into(), name });
        };
        let (expected, got) = (variable.size(), tensor.size());
        if expected != got {
            return Err(WeightsError::Shape { path: path.into(), name, expected, got });
        }
        pairs.push((variable, tensor));
    }
    if let Some(name) = read.keys().min() {
        let name = name.clone();
        return Err(WeightsError::Unknown { path: path.into(), name });
    }
    no_grad(|| pairs.iter_mut().for_each(|(variable, tensor)| variable.copy_(tensor)));
    Ok(())
}
