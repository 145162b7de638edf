//! Actor and critic as two separate perceptrons.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use tch::Tensor;
use tch::nn::{Linear, Module, Path};

use super::environment::Space;
use super::init::{ACTOR, CRITIC, HIDDEN, linear};
use super::network::{ActorCritic, Output, SpaceError};
use super::range::{RangeError, require};

/// Sizes of the perceptrons of the actor and the critic, for observations without fields.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PerceptronConfig {
    /// Units of each hidden layer, of the actor and of the critic.
    /// Two layers of 64 units: reference implementation.
    pub hidden: Vec<i64>,
}

impl Default for PerceptronConfig {
    fn default() -> Self {
        Self { hidden: vec![64, 64] }
    }
}

impl PerceptronConfig {
    pub(super) fn check(&self) -> Result<(), RangeError> {
        let expected = "at least 1 unit in each layer";
        let mut units = self.hidden.iter();
        units.try_for_each(|units| require(*units > 0, "network.hidden", units, expected))
    }
}

/// A perceptron with hyperbolic tangents as actor, and another one as critic.
///
/// Names of the parameters: `actor.0.weight`, `actor.2.bias`, as in the reference implementation.
#[derive(Debug)]
pub(super) struct Perceptron {
    actor: Vec<Linear>,
    critic: Vec<Linear>,
}

impl Perceptron {
    pub(super) fn new(
        vs: &Path<'_>,
        rng: &mut ChaCha8Rng,
        config: &PerceptronConfig,
        space: &Space,
    ) -> Result<Self, SpaceError> {
        if let Some(shape) = space.observation.iter().find(|shape| shape.len() != 1) {
            return Err(SpaceError { shape: shape.clone(), expected: "vectors, [values]" });
        }
        let inputs: i64 = space.observation.iter().flatten().sum();
        let mut layers = |name: &str, outputs: i64, gain: f64| {
            let vs = vs / name;
            let sizes: Vec<i64> =
                [inputs].into_iter().chain(config.hidden.clone()).chain([outputs]).collect();
            let last = sizes.len() - 2;
            // Activations have the odd numbers.
            let layer = |(index, sizes): (usize, &[i64])| {
                let gain = if index == last { gain } else { HIDDEN };
                linear(&(&vs / (2 * index)), rng, sizes[0], sizes[1], gain)
            };
            sizes.windows(2).enumerate().map(layer).collect()
        };
        let critic = layers("critic", 1, CRITIC);
        Ok(Self { actor: layers("actor", space.actions as i64, ACTOR), critic })
    }
}

/// All layers, with activations between them.
fn forward(layers: &[Linear], input: &Tensor) -> Tensor {
    let (last, hidden) = layers.split_last().expect("a perceptron has an output layer");
    let features = hidden.iter().fold(input.shallow_clone(), |x, layer| layer.forward(&x).tanh());
    last.forward(&features)
}

impl ActorCritic for Perceptron {
    fn forward(&self, observation: &[Tensor]) -> Output {
        let input = Tensor::cat(observation, 1);
        Output {
            logits: forward(&self.actor, &input),
            value: forward(&self.critic, &input).squeeze_dim(1),
        }
    }
}
