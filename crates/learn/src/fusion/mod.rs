//! FusionNet: a U-Net over the layer, led by the last moves, that proposes where to move next and
//! how.
//!
//! Aali et al., "Sequence-Based Evolutionary and Neural Strategies for Reducing Zone Crossings in
//! Toolpaths", section FusionNet; details that the text leaves open are those of its public
//! implementation, whose parameter names are kept: a state dict of PyTorch loads by name and shape.
//! All images are `[batch, channel, y, x]`.

mod blocks;
pub mod episode;
mod history;
pub mod layer;
pub mod loss;
pub mod model;
pub mod odds;
pub mod parity;
pub mod propose;
pub mod samples;
pub mod train;
pub mod walk;

use tch::nn::{self, Module, Path};
use tch::{Kind, Tensor, no_grad};

use self::blocks::{Attention, Down, Residual, Up, activate, conv, norm, readout};
use self::history::HistoryEncoder;

pub use self::history::History;
pub use tch::nn::VarStore;

/// Channels of the layer's image: zone by the greatest zone, edges of the path to the right and
/// down, what belongs to the layer, cells beside another zone, crossings at a cell by their
/// greatest number, crossings by those at the start, y and x.
pub const CHANNELS: i64 = 9;

/// Variants of a move.
pub const ACTIONS: i64 = 12;

/// Places along each axis that the presets know: the longest side of a layer, in cells.
pub const PLACES: u32 = 128;

/// The kind of parameters, inputs and outputs.
const KIND: Kind = Kind::Float;

/// Sizes of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Channels of the first and last level, f: 2, 4, 8 or a multiple of 16, for norms share out f
    /// channels and half of them among up to eight groups.
    /// The deepest levels have four times as many.
    pub width: i64,
    /// Units of each of the two recurrent layers.
    pub hidden: i64,
    /// Moves that are remembered, K.
    pub history: i64,
    /// Places along y and x that moves in the history may have.
    pub places: i64,
    /// Rows and columns of the largest image that it is meant for: a multiple of 16. Parameters do
    /// not depend on it, and images of any other multiples of 16 are taken too.
    pub canvas: i64,
    /// What is left out, to see what it is worth.
    /// Its parameters stay, and are not used.
    pub without: Without,
}

/// A part of the network that can be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Without {
    /// Nothing is left out.
    #[default]
    Nothing,
    /// The moves made before: features are not led by them.
    History,
    /// The look from each cell of the deepest level to all others.
    Attention,
}

impl Config {
    /// As the paper has it: f = 48, K = 32, 192 hidden units, on up to 128 x 128 cells.
    pub const fn paper() -> Self {
        Self {
            width: 48,
            hidden: 192,
            history: 32,
            places: PLACES as i64,
            canvas: 128,
            without: Without::Nothing,
        }
    }

    /// Narrower, f = 32, on the smallest canvas that holds a grid of so many cells along its longer
    /// side.
    pub const fn small(grid: i64) -> Self {
        Self {
            width: 32,
            hidden: 192,
            history: 32,
            places: PLACES as i64,
            canvas: (grid + 15) / 16 * 16,
            without: Without::Nothing,
        }
    }
}

/// What the features are computed in; parameters, their gradients and all that is not convolved
/// stay in single precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 32 bits.
    #[default]
    Single,
    /// The upper 16 of them (bfloat16): about 1.6 times as fast in training on processors with AMX,
    /// slower on those that can't multiply them.
    Half,
}

impl Precision {
    fn kind(self) -> Kind {
        match self {
            Self::Single => KIND,
            Self::Half => Kind::BFloat16,
        }
    }
}

/// What the network says of each layer of a batch.
#[derive(Debug)]
pub struct Proposals {
    /// Scores of all cells as the anchor of the next move, `[batch, 1, y, x]`: more is better, and
    /// only differences count.
    pub position: Tensor,
    /// Logits of the move's variants at each cell, `[batch, 12, y, x]`.
    pub action: Tensor,
}

/// The network.
#[derive(Debug)]
pub struct FusionNet {
    config: Config,
    encoder: [Down; 4],
    bottleneck: Residual,
    attention: Attention,
    decoder: [Up; 4],
    history: HistoryEncoder,
    film: nn::Linear,
    position: nn::Sequential,
    action: nn::Sequential,
}

impl FusionNet {
    /// With parameters as at the start of training; those of `FiLM` leave features as they are.
    ///
    /// # Panics
    /// If a size is none that [`Config`] allows.
    pub fn new(vs: &Path<'_>, config: Config) -> Self {
        let Config { width: f, hidden, history, places, canvas, .. } = config;
        assert!(
            f >= 2 && hidden > 0 && history > 0 && places > 0,
            "all sizes are positive: {config:?}"
        );
        assert!(canvas > 0 && canvas % 16 == 0, "the canvas of {canvas} can be halved four times");
        let encoder = [
            Down::new(&(vs / "enc1"), CHANNELS, f),
            Down::new(&(vs / "enc2"), f, 2 * f),
            Down::new(&(vs / "enc3"), 2 * f, 4 * f),
            Down::new(&(vs / "enc4"), 4 * f, 4 * f),
        ];
        // Each takes what comes from below and the encoder's features of its own size.
        // From the deepest up.
        let decoder = [
            Up::new(&(vs / "dec4"), 8 * f, 4 * f),
            Up::new(&(vs / "dec3"), 8 * f, 2 * f),
            Up::new(&(vs / "dec2"), 4 * f, f),
            Up::new(&(vs / "dec1"), 2 * f, f),
        ];
        let film = nn::LinearConfig {
            ws_init: nn::Init::Const(0.0),
            bs_init: Some(nn::Init::Const(0.0)),
            bias: true,
        };
        let mut film = nn::linear(vs / "film_proj" / 0, hidden, 16 * f, film);
        if let Some(bias) = &mut film.bs {
            no_grad(|| _ = bias.slice(0, 0, 8 * f, 1).fill_(1.0));
        }
        let head = vs / "position_head";
        let position = nn::seq()
            .add(conv(&(&head / 0), f, f, 3))
            .add(norm(&(&head / 1), f))
            .add_fn(activate)
            .add(conv(&(&head / 3), f, f / 2, 3))
            .add(norm(&(&head / 4), f / 2))
            .add_fn(activate)
            .add(readout(&(&head / 6), f / 2, 1));
        let head = vs / "action_head";
        let action = nn::seq()
            .add(conv(&(&head / 0), f, f, 3))
            .add(norm(&(&head / 1), f))
            .add_fn(activate)
            .add(readout(&(&head / 3), f, ACTIONS));
        Self {
            config,
            encoder,
            bottleneck: Residual::new(&(vs / "bottleneck" / 0), 4 * f),
            attention: Attention::new(&(vs / "bottleneck_attn"), 4 * f),
            decoder,
            history: HistoryEncoder::new(&(vs / "history_encoder"), hidden, places),
            film,
            position,
            action,
        }
    }

    /// Its sizes.
    pub fn config(&self) -> Config {
        self.config
    }

    /// What it proposes for a batch of layers, `[batch, 9, y, x]`, and the moves that led to each.
    /// In training, parts of the features are dropped at random, by libtorch's own generator.
    ///
    /// # Panics
    /// If shapes do not agree, or y and x are no multiples of 16.
    pub fn forward(
        &self,
        state: &Tensor,
        history: &History,
        precision: Precision,
        train: bool,
    ) -> Proposals {
        let size = state.size();
        assert!(
            matches!(size[..], [_, CHANNELS, y, x] if y % 16 == 0 && x % 16 == 0),
            "{size:?} is a batch of layers of {CHANNELS} channels, whose sides are multiples of 16"
        );
        let kind = precision.kind();
        let mut x = state.to_kind(kind);
        let mut skips = Vec::with_capacity(self.encoder.len());
        for down in &self.encoder {
            let skip = down.forward(&x);
            x = skip.max_pool2d(2, 2, 0, 1, false);
            skips.push(skip);
        }
        let x = self.bottleneck.forward(&x).feature_dropout(0.15, train);
        let mut x =
            if self.config.without == Without::Attention { x } else { self.attention.forward(&x) };
        let f = self.config.width;
        let film = self.film.forward(&self.history.forward(history, train)).dropout(0.1, train);
        let widths = [4 * f, 2 * f, f, f, 4 * f, 2 * f, f, f];
        let film = film.to_kind(kind).unsqueeze(-1).unsqueeze(-1).split_with_sizes(widths, 1);
        let (scales, shifts) = film.split_at(4);
        for ((up, skip), (scale, shift)) in
            self.decoder.iter().zip(skips.iter().rev()).zip(scales.iter().zip(shifts))
        {
            x = up.forward(&x, skip);
            if self.config.without != Without::History {
                x = scale * x + shift;
            }
        }
        let head = |head: &nn::Sequential| head.forward(&x).to_kind(KIND);
        Proposals { position: head(&self.position), action: head(&self.action) }
    }
}

/// What a network proposes, without what training would need; see [`FusionNet::forward`].
pub fn ask(
    network: &FusionNet,
    state: &Tensor,
    history: &History,
    precision: Precision,
) -> Proposals {
    no_grad(|| network.forward(state, history, precision, false))
}
