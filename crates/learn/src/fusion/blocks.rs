//! What the network is made of.

use tch::Tensor;
use tch::nn::{self, Module, Path};

use super::KIND;

/// A convolution that keeps the image's size.
///
/// It computes in the kind of the features it is given; its parameters stay in single precision,
/// for the small steps of training would be lost in half.
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

/// Of so many cells' width, without bias, as a norm follows it.
pub(super) fn conv(vs: &Path<'_>, from: i64, to: i64, width: i64) -> Conv {
    Conv::new(vs, from, to, width, false)
}

/// Of each cell alone, with bias: what a head ends with.
pub(super) fn readout(vs: &Path<'_>, from: i64, to: i64) -> Conv {
    Conv::new(vs, from, to, 1, true)
}

/// In eight groups, or as many as there are channels.
///
/// # Panics
/// If there are more than eight channels, and they can't be shared out among the groups.
pub(super) fn norm(vs: &Path<'_>, channels: i64) -> nn::GroupNorm {
    let groups = channels.min(8);
    assert!(channels % groups == 0, "{channels} channels are shared out among {groups} groups");
    nn::group_norm(vs, groups, channels, nn::GroupNormConfig::default())
}

/// `LeakyReLU` with a slope of 0.01.
pub(super) fn activate(x: &Tensor) -> Tensor {
    x.leaky_relu()
}

/// Two convolutions beside the way through.
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

/// A change of the number of channels, cell by cell.
fn project(vs: &Path<'_>, from: i64, to: i64) -> nn::Sequential {
    nn::seq().add(conv(&(vs / 0), from, to, 1)).add(norm(&(vs / 1), to)).add_fn(activate)
}

/// A level of the encoder, before its image is halved.
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

/// A level of the decoder: from an image of half the size and the encoder's of its own.
#[derive(Debug)]
pub(super) struct Up(Down);

impl Up {
    /// `from` counts the channels of both.
    pub(super) fn new(vs: &Path<'_>, from: i64, to: i64) -> Self {
        Self(Down::new(vs, from, to))
    }

    pub(super) fn forward(&self, x: &Tensor, skip: &Tensor) -> Tensor {
        let size = skip.size();
        let x = x.upsample_bilinear2d([size[2], size[3]], true, None, None);
        self.0.forward(&Tensor::cat(&[&x, skip], 1))
    }
}

/// Of all cells to all, with four heads.
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
    /// If the channels can't be shared out among the heads.
    pub(super) fn new(vs: &Path<'_>, channels: i64) -> Self {
        assert!(channels % HEADS == 0, "{channels} channels are shared out among {HEADS} heads");
        let inner = vs / "attn";
        // As PyTorch begins: Xavier's range for the three of them as one, and no biases.
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
        let all = cells.linear(&self.in_weight, Some(&self.in_bias)).chunk(3, -1);
        let [query, key, value] =
            <[Tensor; 3]>::try_from(all).expect("three chunks of three").map(heads);
        let scale = 1.0 / ((channels / HEADS) as f64).sqrt();
        let shares = (query * scale).matmul(&key.transpose(-2, -1)).softmax(-1, KIND);
        let seen = shares.matmul(&value).transpose(1, 2).reshape([batch, -1, channels]);
        let cells = self.norm.forward(&(cells + self.out.forward(&seen)));
        cells.transpose(1, 2).reshape([batch, channels, y, width]).to_kind(kind)
    }
}
