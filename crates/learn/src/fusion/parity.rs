//! The network beside another implementation of it, for the same weights and inputs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use tch::nn::VarStore;
use tch::{Device, Tensor, no_grad};
use thiserror::Error;

use super::{Config, FusionNet, History, Precision, Without};
use crate::weights::{self, WeightsError};

/// How far two implementations lie apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parity {
    /// The network's sizes, as its weights tell them.
    pub config: Config,
    /// Largest difference of a position's score.
    pub position: f64,
    /// Largest difference of an action's logit.
    pub action: f64,
}

/// Why they can't be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ParityError {
    /// A file can't be read, or the weights are no network's.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// A file lacks a tensor, or it has another number of axes than it should.
    #[error("'{}' has no '{name}' of {axes} axes", path.display())]
    Lacks {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: &'static str,
        /// Its axes.
        axes: usize,
    },
}

/// Compares with outputs in a file: `state`, `action`, `y`, `x`, `before`, `after` and `mask` are
/// its inputs, `position` and `action_logits` what came out.
pub fn compare(weights: &Path, io: &Path) -> Result<Parity, ParityError> {
    let read = weights::read_tensors(weights)?;
    let given = weights::read_tensors(io)?;
    let mask = find(&given, io, "mask", 2)?;
    let state = find(&given, io, "state", 4)?;
    let config = Config {
        width: find(&read, weights, "enc1.proj.0.weight", 4)?.size()[0],
        hidden: find(&read, weights, "history_encoder.gru.weight_hh_l0", 2)?.size()[1],
        places: find(&read, weights, "history_encoder.pos_y_embed.weight", 2)?.size()[0],
        history: mask.size()[1],
        canvas: state.size()[3],
        without: Without::Nothing,
    };
    let history = History {
        action: find(&given, io, "action", 2)?,
        y: find(&given, io, "y", 2)?,
        x: find(&given, io, "x", 2)?,
        before: find(&given, io, "before", 2)?,
        after: find(&given, io, "after", 2)?,
        mask,
    };
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), config);
    weights::load(&variables, weights)?;
    let proposals = no_grad(|| network.forward(&state, &history, Precision::Single, false));
    let apart = |own: &Tensor, other: Tensor| (own - other).abs().max().double_value(&[]);
    Ok(Parity {
        config,
        position: apart(&proposals.position, find(&given, io, "position", 4)?),
        action: apart(&proposals.action, find(&given, io, "action_logits", 4)?),
    })
}

fn find(
    tensors: &HashMap<String, Tensor>,
    path: &Path,
    name: &'static str,
    axes: usize,
) -> Result<Tensor, ParityError> {
    let found = tensors.get(name).filter(|tensor| tensor.dim() == axes);
    found.map(Tensor::shallow_clone).ok_or_else(|| ParityError::Lacks {
        path: path.into(),
        name,
        axes,
    })
}
