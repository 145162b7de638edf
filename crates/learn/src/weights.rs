//! Parameters in files: safetensors, by the names that PyTorch gives them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use tch::nn::VarStore;
use tch::{TchError, Tensor, no_grad};
use thiserror::Error;

/// Why a file's parameters are not those of a network. Nothing is changed by what is refused.
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

/// Reads all parameters of a network: the file must have just these names and shapes. Numbers of other kinds are converted.
pub fn load(variables: &mut VarStore, path: &Path) -> Result<(), WeightsError> {
    let whole = |source| WeightsError::Unreadable { path: path.into(), source };
    let mut read: HashMap<String, Tensor> =
        Tensor::read_safetensors(path).map_err(whole)?.into_iter().collect();
    let mut own: Vec<_> = variables.variables().into_iter().collect();
    own.sort_by(|(name, _), (other, _)| name.cmp(other));
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
    if let Some(name) = read.into_keys().min() {
        return Err(WeightsError::Unknown { path: path.into(), name });
    }
    no_grad(|| pairs.iter_mut().for_each(|(variable, tensor)| variable.copy_(tensor)));
    Ok(())
}
