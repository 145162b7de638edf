//! Building blocks of the network: convolutions, norms, levels of the U-Net, self-attention.

use tch::Tensor;
use tch::nn::{self, Module, Path};

use super::config::KIND;

/// A convolution whose output has the size of its input.
///
/// It computes in the precision of its input.
/// Its parameters stay in single precision: in bfloat16, rounding would swallow the small updates
/// of training.
#[derive(Debug)]
pub(super) struct Conv {
    weight: Tensor,
    bias: Option<Tensor>,
    padding: i64,
}

impl Conv {
    fn new(vs: &Path<'_>, from: i64, to: i64, width: i64, bias: bool) -> Self {
        Self {
            weight: vs.var("weight", &[to, from, width, width], nn::init::DEFAULT_KAIMING_UNIFORM),
            bias: bias.then(|| vs.var("bias", &[to], nn::Init::Const(0.0))),
            padding: width / 2,
        }
    }
}

impl Module for Conv {
    fn forward(&self, x: &Tensor) -> Tensor {
        let (kind, padding) = (x.kind(), [self.padding; 2]);
        let bias = self.bias.as_ref().map(|bias| bias.to_kind(kind));
        x.conv2d(&self.weight.to_kind(kind), bias, [1, 1], padding, [1, 1], 1)
    }
}

/// A convolution with a square kernel of `width` cells, without bias: a norm with a bias follows
/// it.
pub(super) fn conv(vs: &Path<'_>, from: i64, to: i64, width: i64) -> Conv {
    Conv::new(vs, from, to, width, false)
}

/// A 1 x 1 convolution with bias, the last layer of an output.
pub(super) fn readout(vs: &Path<'_>, from: i64, to: i64) -> Conv {
    Conv::new(vs, from, to, 1, true)
}

/// A group norm with eight groups, or with one group per channel if there are fewer than eight
/// channels.
///
/// # Panics
/// If the channels cannot be divided into groups of equal size.
pub(super) fn norm(vs: &Path<'_>, channels: i64) -> nn::GroupNorm {
    let groups = channels.min(8);
    assert!(channels % groups == 0, "{channels} channels cannot form {groups} equal groups");
    nn::group_norm(vs, groups, channels, nn::GroupNormConfig::default())
}

/// `LeakyReLU` with a negative slope of 0.01.
pub(super) fn activate(x: &Tensor) -> Tensor {
    x.leaky_relu()
}

/// A residual block of two 3 x 3 convolutions.
#[derive(Debug)]
pub(super) struct Residual {
    block: nn::Sequential,
}

impl Residual {
    pub(super) fn new(vs: &Path<'_>, channels: i64) -> Self {
        let vs = vs / "block";
        let block = nn::seq()
            .add(conv(&(&vs / 0), channels, channels, 3))
            .add(norm(&(&vs / 1), channels))
            .add_fn(activate)
            .add(conv(&(&vs / 3), channels, channels, 3))
            .add(norm(&(&vs / 4), channels));
        Self { block }
    }

    pub(super) fn forward(&self, x: &Tensor) -> Tensor {
        activate(&(x + self.block.forward(x)))
    }
}

/// A 1 x 1 convolution that changes the number of channels, with norm and activation.
fn project(vs: &Path<'_>, from: i64, to: i64) -> nn::Sequential {
    nn::seq().add(conv(&(vs / 0), from, to, 1)).add(norm(&(vs / 1), to)).add_fn(activate)
}

/// A level of the encoder, before max pooling.
#[derive(Debug)]
pub(super) struct Down {
    project: nn::Sequential,
    residual: Residual,
}

impl Down {
    pub(super) fn new(vs: &Path<'_>, from: i64, to: i64) -> Self {
        Self {
            project: project(&(vs / "proj"), from, to),
            residual: Residual::new(&(vs / "res"), to),
        }
    }

    pub(super) fn forward(&self, x: &Tensor) -> Tensor {
        self.residual.forward(&self.project.forward(x))
    }
}

/// A level of the decoder: upsamples the output of the level below, and appends the encoder's
/// features of the same size.
#[derive(Debug)]
pub(super) struct Up(Down);

impl Up {
    /// Creates the level; `from` is the total number of channels of its two inputs.
    pub(super) fn new(vs: &Path<'_>, from: i64, to: i64) -> Self {
        Self(Down::new(vs, from, to))
    }

    pub(super) fn forward(&self, x: &Tensor, skip: &Tensor) -> Tensor {
        let size = skip.size();
        let x = x.upsample_bilinear2d([size[2], size[3]], true, None, None);
        self.0.forward(&Tensor::cat(&[&x, skip], 1))
    }
}

/// Self-attention among all cells, with four heads, a residual connection and a layer norm.
///
/// Computes in single precision, whatever the precision of its input.
#[derive(Debug)]
pub(super) struct Attention {
    in_weight: Tensor,
    in_bias: Tensor,
    out: nn::Linear,
    norm: nn::LayerNorm,
}

const HEADS: i64 = 4;

impl Attention {
    /// # Panics
    /// If the channels cannot be divided among the heads.
    pub(super) fn new(vs: &Path<'_>, channels: i64) -> Self {
        assert!(channels % HEADS == 0, "{channels} channels cannot form {HEADS} equal heads");
        let inner = vs / "attn";
        // Initialised as in PyTorch: Xavier-uniform, with query, key and value as one matrix of 3 c
        // rows and c columns, so the bound is √(6 / (3 c + c)); biases are 0.
        let bound = (6.0 / (4 * channels) as f64).sqrt();
        let start = nn::Init::Uniform { lo: -bound, up: bound };
        let out =
            nn::LinearConfig { bs_init: Some(nn::Init::Const(0.0)), ..nn::LinearConfig::default() };
        Self {
            in_weight: inner.var("in_proj_weight", &[3 * channels, channels], start),
            in_bias: inner.var("in_proj_bias", &[3 * channels], nn::Init::Const(0.0)),
            out: nn::linear(&inner / "out_proj", channels, channels, out),
            norm: nn::layer_norm(vs / "norm", vec![channels], nn::LayerNormConfig::default()),
        }
    }

    pub(super) fn forward(&self, x: &Tensor) -> Tensor {
        let (batch, channels, y, width) = x.size4().expect("an image has four axes");
        let kind = x.kind();
        let cells = x.to_kind(KIND).flatten(2, 3).transpose(1, 2);
        let heads = |x: Tensor| x.reshape([batch, -1, HEADS, channels / HEADS]).transpose(1, 2);
        let projected = cells.linear(&self.in_weight, Some(&self.in_bias)).chunk(3, -1);
        let [query, key, value] =
            <[Tensor; 3]>::try_from(projected).expect("three chunks of three").map(heads);
        let scale = 1.0 / ((channels / HEADS) as f64).sqrt();
        let weights = (query * scale).matmul(&key.transpose(-2, -1)).softmax(-1, KIND);
        let attended = weights.matmul(&value).transpose(1, 2).reshape([batch, -1, channels]);
        let cells = self.norm.forward(&(cells + self.out.forward(&attended)));
        cells.transpose(1, 2).reshape([batch, channels, y, width]).to_kind(kind)
    }
}
