//! Test oracle: compares the network with another implementation on the same weights and inputs.
//! Feature `oracle`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use tch::nn::VarStore;
use tch::{Device, Tensor};
use thiserror::Error;

use super::config::{Ablation, Config, Precision};
use super::history::History;
use super::network::FusionNet;
use crate::weights::{self, WeightsError};

/// Differences between two implementations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parity {
    /// Sizes of the network, derived from the shapes of its weights.
    pub config: Config,
    /// Largest absolute difference of a position's score.
    pub position: f64,
    /// Largest absolute difference of an action's logit.
    pub action: f64,
}

/// Why two implementations cannot be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ParityError {
    /// A file cannot be read, or the weights do not form a network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// A file has no tensor of this name with this number of axes.
    #[error("'{}' has no tensor '{name}' with {axes} axes", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: &'static str,
        /// Its axes.
        axes: usize,
    },
}

/// Runs the network on the inputs of a file and compares the outputs with those in the file.
///
/// `weights` and `io` are safetensors files.
/// `io` holds the inputs `state` (the image), `action`, `y`, `x`, `before`, `after` and `mask`, and
/// the other implementation's outputs `position` and `action_logits`.
pub fn compare(weights: &Path, io: &Path) -> Result<Parity, ParityError> {
    let parameters = weights::read_tensors(weights)?;
    let tensors = weights::read_tensors(io)?;
    let mask = find(&tensors, io, "mask", 2)?;
    let image = find(&tensors, io, "state", 4)?;
    let config = Config {
        width: find(&parameters, weights, "enc1.proj.0.weight", 4)?.size()[0],
        hidden: find(&parameters, weights, "history_encoder.gru.weight_hh_l0", 2)?.size()[1],
        max_side: find(&parameters, weights, "history_encoder.pos_y_embed.weight", 2)?.size()[0],
        history: mask.size()[1],
        canvas: image.size()[3],
        ablation: Ablation::None,
    };
    let history = History {
        action: find(&tensors, io, "action", 2)?,
        y: find(&tensors, io, "y", 2)?,
        x: find(&tensors, io, "x", 2)?,
        before: find(&tensors, io, "before", 2)?,
        after: find(&tensors, io, "after", 2)?,
        mask,
    };
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), config);
    weights::load(&variables, weights)?;
    let proposals = network.infer(&image, &history, Precision::Single);
    let difference = |own: &Tensor, other: Tensor| (own - other).abs().max().double_value(&[]);
    Ok(Parity {
        config,
        position: difference(&proposals.position, find(&tensors, io, "position", 4)?),
        action: difference(&proposals.action, find(&tensors, io, "action_logits", 4)?),
    })
}

fn find(
    tensors: &HashMap<String, Tensor>,
    path: &Path,
    name: &'static str,
    axes: usize,
) -> Result<Tensor, ParityError> {
    let found = tensors.get(name).filter(|tensor| tensor.dim() == axes);
    found.map(Tensor::shallow_clone).ok_or_else(|| ParityError::Missing {
        path: path.into(),
        name,
        axes,
    })
}
