//! The actor-critic interface, and the networks that a configuration can name.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use tch::nn::Path;
use tch::{Device, Tensor};
use thiserror::Error;

use super::environment::{Observation, Space};
use super::fields::{Fields, FieldsConfig};
use super::perceptron::{Perceptron, PerceptronConfig};
use super::range::RangeError;

/// The output of a network for a batch of observations.
#[derive(Debug)]
pub struct Output {
    /// Logit of each action, `[batch, action]`.
    pub logits: Tensor,
    /// Expected return, `[batch]`.
    pub value: Tensor,
}

/// A policy and a value function of an observation.
pub trait ActorCritic {
    /// Evaluates a batch: `observation` holds the tensors of the observations, each with a batch
    /// axis in front.
    fn forward(&self, observation: &[Tensor]) -> Output;
}

/// The network of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum NetworkConfig {
    /// Two perceptrons, for observations that are vectors.
    Perceptron(PerceptronConfig),
    /// Convolutional extractors with common features for both heads, for observations with volumes
    /// or images.
    Fields(FieldsConfig),
}

impl Default for NetworkConfig {
    fn default() -> Self {
        Self::Perceptron(PerceptronConfig::default())
    }
}

/// A network and an environment that do not fit together.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("network cannot observe tensors of shape {shape:?}: expected {expected}")]
pub struct SpaceError {
    /// Shape of a tensor of the environment's observations.
    pub shape: Vec<i64>,
    /// What the network can observe.
    pub expected: &'static str,
}

impl NetworkConfig {
    /// Checks that all sizes are in their ranges.
    pub(super) fn check(&self) -> Result<(), RangeError> {
        match self {
            Self::Perceptron(config) => config.check(),
            Self::Fields(config) => config.check(),
        }
    }

    /// Creates the network's variables, with initial values from `rng`.
    pub(super) fn build(
        &self,
        vs: &Path<'_>,
        rng: &mut ChaCha8Rng,
        space: &Space,
    ) -> Result<Box<dyn ActorCritic>, SpaceError> {
        match self {
            Self::Perceptron(config) => Ok(Box::new(Perceptron::new(vs, rng, config, space)?)),
            Self::Fields(config) => Ok(Box::new(Fields::new(vs, rng, config, space)?)),
        }
    }
}

/// The tensors of several observations, each with a batch axis in front.
pub(super) fn batch(observations: &[&Observation], space: &Space, device: Device) -> Vec<Tensor> {
    let tensor = |(index, shape): (usize, &Vec<i64>)| {
        let values: Vec<f32> = observations
            .iter()
            .flat_map(|observation| observation.tensors[index].iter().copied())
            .collect();
        let shape: Vec<i64> = std::iter::once(-1).chain(shape.iter().copied()).collect();
        Tensor::from_slice(&values).view(shape.as_slice()).to_device(device)
    };
    space.observation.iter().enumerate().map(tensor).collect()
}

/// Which actions several observations permit, `[batch, action]`.
pub(super) fn permitted(observations: &[&Observation], device: Device) -> Tensor {
    let values: Vec<bool> =
        observations.iter().flat_map(|observation| observation.permitted.iter().copied()).collect();
    Tensor::from_slice(&values).view([observations.len() as i64, -1]).to_device(device)
}
