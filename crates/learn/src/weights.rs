//! Network parameters in safetensors files, under the names that PyTorch gives them.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use beadwork_dataset::{FileError, write_atomic_at};
use tch::nn::VarStore;
use tch::{Kind, TchError, Tensor, no_grad};
use thiserror::Error;

/// Why parameters cannot be read or written.
/// After an error the network is unchanged.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// The file is missing, truncated or not in safetensors format.
    #[error("'{}' is not a readable safetensors file", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// libtorch's error.
        source: TchError,
    },
    /// A parameter of the network is not in the file.
    #[error("'{}' has no parameter '{name}'", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The parameter.
        name: String,
    },
    /// A tensor of the file is not a parameter of the network.
    #[error("'{}' has a tensor '{name}', which the network does not have", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The parameter.
        name: String,
    },
    /// The file cannot be written; an existing file of that name is unchanged.
    #[error(transparent)]
    Unwritten(#[from] FileError),
    /// A parameter has the wrong shape.
    #[error("'{}': '{name}' has shape {got:?}, the network needs {expected:?}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// The parameter.
        name: String,
        /// Shape in the network.
        expected: Vec<i64>,
        /// Shape in the file.
        got: Vec<i64>,
    },
}

/// Writes all parameters of a network, rounded to half precision, and replaces the file as a whole.
///
/// Rounding halves the file's size and changes each parameter by at most 1 part in 2000, less than
/// the last training steps change it.
pub fn save(variables: &VarStore, path: &Path) -> Result<(), WeightsError> {
    let mut named = named(variables);
    named.iter_mut().for_each(|(_, parameter)| *parameter = parameter.to_kind(Kind::Half));
    save_tensors(&named, path)
}

/// Writes all parameters of a network as they are, and replaces the file as a whole.
pub fn save_exact(variables: &VarStore, path: &Path) -> Result<(), WeightsError> {
    save_tensors(&named(variables), path)
}

/// All parameters of a network, sorted by name.
pub(crate) fn named(variables: &VarStore) -> Vec<(String, Tensor)> {
    let mut named: Vec<_> = variables.variables().into_iter().collect();
    named.sort_by(|(name, _), (other, _)| name.cmp(other));
    named
}

/// Writes named tensors, and replaces the file as a whole.
pub(crate) fn save_tensors(named: &[(String, Tensor)], path: &Path) -> Result<(), WeightsError> {
    Ok(write_atomic_at(path, |partial| {
        Tensor::write_safetensors(named, partial).map_err(io::Error::other)
    })?)
}

/// Reads all parameters of a network.
/// The file must have exactly the network's names and shapes; other element types are converted.
pub fn load(variables: &VarStore, path: &Path) -> Result<(), WeightsError> {
    fill(variables, &mut read_tensors(path)?, path)
}

/// Reads all tensors of a file.
pub(crate) fn read_tensors(path: &Path) -> Result<HashMap<String, Tensor>, WeightsError> {
    let read = Tensor::read_safetensors(path);
    Ok(read
        .map_err(|source| WeightsError::Unreadable { path: path.into(), source })?
        .into_iter()
        .collect())
}

/// Sets all parameters of a network to the tensors of a file, after checking names and shapes.
pub(crate) fn fill(
    variables: &VarStore,
    tensors: &mut HashMap<String, Tensor>,
    path: &Path,
) -> Result<(), WeightsError> {
    let own = named(variables);
    let mut pairs = Vec::with_capacity(own.len());
    for (name, variable) in own {
        let Some(tensor) = tensors.remove(&name) else {
            return Err(WeightsError::Missing { path: path.into(), name });
        };
        let (expected, got) = (variable.size(), tensor.size());
        if expected != got {
            return Err(WeightsError::Shape { path: path.into(), name, expected, got });
        }
        pairs.push((variable, tensor));
    }
    if let Some(name) = tensors.keys().min() {
        let name = name.clone();
        return Err(WeightsError::Unknown { path: path.into(), name });
    }
    no_grad(|| pairs.iter_mut().for_each(|(variable, tensor)| variable.copy_(tensor)));
    Ok(())
}
