//! An actor-critic that sees fields: convolutional extractors of volumes and images, whose features
//! both branches share.
//!
//! The network of the paper on toolpaths for even temperature (Kim et al. 2026): a 3D extractor for
//! temperatures and a 2D extractor for designs of layers, made of residual blocks that halve the
//! size, with group norms; their features are concatenated for the branches of actor and critic.
//! Beyond the paper, an observation may describe each action, and a small network then adds to the
//! actor's logits what it makes of the description.
//! The paper does not give channels, depths and branches: those of the presets are chosen here.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use tch::nn::{self, GroupNorm, Linear, Module, Path};
use tch::{Kind, Tensor};

use super::environment::Space;
use super::init::{ACTOR, CRITIC, HIDDEN, linear, weight};
use super::network::{ActorCritic, Output, SpaceError};
use super::range::{RangeError, require};

/// Sizes of the network.
///
/// Construct it with `..FieldsConfig::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FieldsConfig {
    /// Channels of each block of the extractor of volumes; each block halves the sides.
    /// At most eight groups of channels are normalised, so channels are at most 8 or a multiple
    /// of 8.
    pub volume: Vec<i64>,
    /// Channels of each block of the extractor of images.
    pub image: Vec<i64>,
    /// Cells along x and along y to which features are averaged before the branches, 1 for an
    /// average over everything; layers are always averaged.
    /// So any size of volume or image fits the network.
    pub pooled: i64,
    /// Units of the hidden layer of each branch.
    pub units: i64,
    /// Units of the hidden layer that scores actions by what an observation says about each of
    /// them; without effect if it says nothing.
    pub action_units: i64,
}

impl FieldsConfig {
    /// For volumes of 128 x 128 x 128 voxels, as the paper's.
    pub fn paper() -> Self {
        Self {
            volume: vec![16, 32, 64, 128, 128],
            image: vec![16, 32, 64, 128, 128],
            pooled: 1,
            units: 256,
            action_units: 64,
        }
    }

    /// For processors and cropped, coarse observations of up to some thousand voxels.
    pub fn small() -> Self {
        Self {
            volume: vec![8, 16, 32],
            image: vec![8, 16, 32],
            pooled: 2,
            units: 64,
            action_units: 32,
        }
    }

    pub(super) fn check(&self) -> Result<(), RangeError> {
        for (field, channels) in [("network.volume", &self.volume), ("network.image", &self.image)]
        {
            require(!channels.is_empty(), field, &"empty", "channels of at least one block")?;
            for channels in channels {
                let fits = (1..=8).contains(channels) || *channels > 0 && channels % 8 == 0;
                require(fits, field, channels, "1 to 8 channels, or a multiple of 8")?;
            }
        }
        require((1..=64).contains(&self.pooled), "network.pooled", &self.pooled, "1 to 64")?;
        require(self.units > 0, "network.units", &self.units, "at least 1")?;
        let units = self.action_units;
        require(units > 0, "network.action_units", &units, "at least 1")
    }
}

impl Default for FieldsConfig {
    fn default() -> Self {
        Self::small()
    }
}

/// A convolution without bias, of volumes or images, with a kernel of `width` cells along each
/// axis.
#[derive(Debug)]
struct Conv {
    weight: Tensor,
    stride: i64,
    padding: i64,
}

impl Conv {
    fn new(
        vs: &Path<'_>,
        rng: &mut ChaCha8Rng,
        axes: usize,
        (from, to): (i64, i64),
        (width, stride): (i64, i64),
    ) -> Self {
        let shape: Vec<i64> = [to, from].into_iter().chain(vec![width; axes]).collect();
        Self { weight: weight(vs, rng, &shape, HIDDEN), stride, padding: width / 2 }
    }

    fn forward(&self, x: &Tensor) -> Tensor {
        let (stride, padding) = (self.stride, self.padding);
        if self.weight.dim() == 5 {
            let bias: Option<Tensor> = None;
            x.conv3d(&self.weight, bias, [stride; 3], [padding; 3], [1; 3], 1)
        } else {
            let bias: Option<Tensor> = None;
            x.conv2d(&self.weight, bias, [stride; 2], [padding; 2], [1; 2], 1)
        }
    }
}

fn norm(vs: &Path<'_>, channels: i64) -> GroupNorm {
    nn::group_norm(vs, channels.min(8), channels, nn::GroupNormConfig::default())
}

/// A residual block that halves the sides, rounding up.
#[derive(Debug)]
struct Block {
    first: Conv,
    first_norm: GroupNorm,
    second: Conv,
    second_norm: GroupNorm,
    skip: Conv,
    skip_norm: GroupNorm,
}

impl Block {
    fn new(vs: &Path<'_>, rng: &mut ChaCha8Rng, axes: usize, (from, to): (i64, i64)) -> Self {
        Self {
            first: Conv::new(&(vs / "conv1"), rng, axes, (from, to), (3, 2)),
            first_norm: norm(&(vs / "norm1"), to),
            second: Conv::new(&(vs / "conv2"), rng, axes, (to, to), (3, 1)),
            second_norm: norm(&(vs / "norm2"), to),
            skip: Conv::new(&(vs / "skip"), rng, axes, (from, to), (1, 2)),
            skip_norm: norm(&(vs / "skip_norm"), to),
        }
    }

    fn forward(&self, x: &Tensor) -> Tensor {
        let inner = self.first_norm.forward(&self.first.forward(x)).relu();
        let inner = self.second_norm.forward(&self.second.forward(&inner));
        (inner + self.skip_norm.forward(&self.skip.forward(x))).relu()
    }
}

/// What turns one tensor of an observation into features.
#[derive(Debug)]
enum Extractor {
    /// The numbers of a vector, or of all actions, are features themselves.
    Vector,
    /// Blocks, and an average over the cells that are pooled.
    Field { blocks: Vec<Block>, axes: usize, pooled: i64 },
}

impl Extractor {
    /// Creates the extractor of a tensor of this shape, and returns the number of its features.
    fn new(
        vs: &Path<'_>,
        rng: &mut ChaCha8Rng,
        config: &FieldsConfig,
        shape: &[i64],
        actions: usize,
    ) -> Result<(Self, i64), SpaceError> {
        let (channels, axes) = match *shape {
            [values] => return Ok((Self::Vector, values)),
            [rows, values] if rows == actions as i64 => return Ok((Self::Vector, rows * values)),
            [_, _, _] => (&config.image, 2),
            [_, _, _, _] => (&config.volume, 3),
            _ => {
                let expected = "[values], [action, values], [channel, y, x] or [channel, z, y, x]";
                return Err(SpaceError { shape: shape.to_vec(), expected });
            }
        };
        let sizes: Vec<i64> = [shape[0]].into_iter().chain(channels.iter().copied()).collect();
        let block = |(index, sizes): (usize, &[i64])| {
            Block::new(&(vs / index), rng, axes, (sizes[0], sizes[1]))
        };
        let blocks = sizes.windows(2).enumerate().map(block).collect();
        let pooled = config.pooled;
        let features = sizes[sizes.len() - 1] * pooled * pooled;
        Ok((Self::Field { blocks, axes, pooled }, features))
    }

    fn forward(&self, x: &Tensor) -> Tensor {
        let Self::Field { blocks, axes, pooled } = self else {
            return x.flatten(1, -1);
        };
        let x = blocks.iter().fold(x.shallow_clone(), |x, block| block.forward(&x));
        let x = if *axes == 3 { x.mean_dim([2_i64].as_slice(), false, Kind::Float) } else { x };
        x.adaptive_avg_pool2d([*pooled, *pooled]).flatten(1, -1)
    }
}

/// What scores each action by the numbers that a tensor of the observation has for it.
///
/// The same weights score all actions, so what is learned of one holds for all.
#[derive(Debug)]
struct Scorer {
    /// Index of the tensor.
    tensor: usize,
    /// Of the numbers of an action.
    own: Linear,
    /// Of the common features.
    context: Linear,
    last: Linear,
}

impl Scorer {
    /// Scores, `[batch, action]`.
    fn forward(&self, observation: &[Tensor], features: &Tensor) -> Tensor {
        let own = self.own.forward(&observation[self.tensor]);
        let hidden = (own + self.context.forward(features).unsqueeze(1)).relu();
        self.last.forward(&hidden).squeeze_dim(2)
    }
}

/// Extractors, and two branches.
#[derive(Debug)]
pub(super) struct Fields {
    extractors: Vec<Extractor>,
    /// Adds to the actor's logits.
    scorers: Vec<Scorer>,
    actor: [Linear; 2],
    critic: [Linear; 2],
}

impl Fields {
    pub(super) fn new(
        vs: &Path<'_>,
        rng: &mut ChaCha8Rng,
        config: &FieldsConfig,
        space: &Space,
    ) -> Result<Self, SpaceError> {
        let mut features = 0;
        let mut extractors = Vec::new();
        for (index, shape) in space.observation.iter().enumerate() {
            let vs = &(vs / "extractor" / index);
            let (extractor, own) = Extractor::new(vs, rng, config, shape, space.actions)?;
            extractors.push(extractor);
            features += own;
        }
        let mut branch = |name: &str, outputs: i64, gain: f64| {
            let vs = vs / name;
            [
                linear(&(&vs / 0), rng, features, config.units, HIDDEN),
                linear(&(&vs / 2), rng, config.units, outputs, gain),
            ]
        };
        let critic = branch("critic", 1, CRITIC);
        let actor = branch("actor", space.actions as i64, ACTOR);
        let mut scorers = Vec::new();
        for (tensor, shape) in space.observation.iter().enumerate() {
            let &[_, values] = shape.as_slice() else { continue };
            let (vs, units) = (&(vs / "scorer" / tensor), config.action_units);
            scorers.push(Scorer {
                tensor,
                own: linear(&(vs / "own"), rng, values, units, HIDDEN),
                context: linear(&(vs / "context"), rng, features, units, HIDDEN),
                last: linear(&(vs / "last"), rng, units, 1, ACTOR),
            });
        }
        Ok(Self { extractors, scorers, actor, critic })
    }
}

impl ActorCritic for Fields {
    fn forward(&self, observation: &[Tensor]) -> Output {
        let features: Vec<Tensor> = self
            .extractors
            .iter()
            .zip(observation)
            .map(|(extractor, tensor)| extractor.forward(tensor))
            .collect();
        let features = Tensor::cat(&features, 1);
        let branch = |[hidden, last]: &[Linear; 2]| last.forward(&hidden.forward(&features).relu());
        let score =
            |logits: Tensor, scorer: &Scorer| logits + scorer.forward(observation, &features);
        let logits = self.scorers.iter().fold(branch(&self.actor), score);
        Output { logits, value: branch(&self.critic).squeeze_dim(1) }
    }
}
