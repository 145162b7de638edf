//! The network itself.

use tch::nn::{self, Module, Path};
use tch::{Tensor, no_grad};

use super::blocks::{Attention, Down, Residual, Up, activate, conv, norm, readout};
use super::config::{ACTIONS, Ablation, CHANNELS, Config, KIND, Precision};
use super::history::{History, HistoryEncoder};

/// The network's output for a batch of layers.
#[derive(Debug)]
pub struct Proposals {
    /// Score of each cell as the top-left cell of the next move's window, `[batch, 1, y, x]`.
    /// Higher is better; only differences within a layer have a meaning.
    pub position: Tensor,
    /// Logits of the move's variants at each cell, `[batch, 12, y, x]`.
    pub action: Tensor,
}

/// A U-Net of four levels with self-attention at its bottleneck.
///
/// A recurrent encoder of the last moves scales and shifts the features of each decoder level
/// (`FiLM`, Perez et al. 2018).
/// Two convolutional heads score positions and variants of the next move.
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
    /// Creates the network's parameters in `vs`, drawn at random by libtorch's global generator.
    ///
    /// `FiLM` starts as the identity, with scale 1 and shift 0.
    ///
    /// # Panics
    /// If a size is outside the range that [`Config`] states.
    pub fn new(vs: &Path<'_>, config: Config) -> Self {
        let Config { width: f, hidden, history, max_side, canvas, .. } = config;
        assert!(
            f >= 2 && hidden > 0 && history > 0 && max_side > 0,
            "sizes must be positive: {config:?}"
        );
        assert!(
            canvas > 0 && canvas % 16 == 0,
            "canvas is {canvas}: expected a positive multiple of 16"
        );
        let encoder = [
            Down::new(&(vs / "enc1"), CHANNELS, f),
            Down::new(&(vs / "enc2"), f, 2 * f),
            Down::new(&(vs / "enc3"), 2 * f, 4 * f),
            Down::new(&(vs / "enc4"), 4 * f, 4 * f),
        ];
        // From the deepest level up.
        // The input of a level is the output of the level below and the encoder's features of the
        // same size.
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
        // 8 f scales, then 8 f shifts: one of each for every channel of the decoder.
        let mut film = nn::linear(vs / "film_proj" / 0, hidden, 16 * f, film);
        if let Some(bias) = &mut film.bs {
            no_grad(|| _ = bias.slice(0, 0, 8 * f, 1).fill_(1.0));
        }
        let layers = vs / "position_head";
        let position = nn::seq()
            .add(conv(&(&layers / 0), f, f, 3))
            .add(norm(&(&layers / 1), f))
            .add_fn(activate)
            .add(conv(&(&layers / 3), f, f / 2, 3))
            .add(norm(&(&layers / 4), f / 2))
            .add_fn(activate)
            .add(readout(&(&layers / 6), f / 2, 1));
        let layers = vs / "action_head";
        let action = nn::seq()
            .add(conv(&(&layers / 0), f, f, 3))
            .add(norm(&(&layers / 1), f))
            .add_fn(activate)
            .add(readout(&(&layers / 3), f, ACTIONS));
        Self {
            config,
            encoder,
            bottleneck: Residual::new(&(vs / "bottleneck" / 0), 4 * f),
            attention: Attention::new(&(vs / "bottleneck_attn"), 4 * f),
            decoder,
            history: HistoryEncoder::new(&(vs / "history_encoder"), hidden, max_side),
            film,
            position,
            action,
        }
    }

    /// The network's sizes.
    pub fn config(&self) -> Config {
        self.config
    }

    /// Scores positions and variants for a batch of images, `[batch, 9, y, x]`, and the moves that
    /// led to each.
    ///
    /// With `train`, dropout is active and draws from libtorch's global generator.
    ///
    /// # Panics
    /// If shapes do not agree, or y or x is not a multiple of 16.
    pub fn forward(
        &self,
        image: &Tensor,
        history: &History,
        precision: Precision,
        train: bool,
    ) -> Proposals {
        let size = image.size();
        assert!(
            matches!(size[..], [_, CHANNELS, y, x] if y % 16 == 0 && x % 16 == 0),
            "image has shape {size:?}: expected [batch, {CHANNELS}, y, x], y and x multiples of 16"
        );
        let kind = precision.kind();

        let mut x = image.to_kind(kind);
        let mut skips = Vec::with_capacity(self.encoder.len());
        for down in &self.encoder {
            let skip = down.forward(&x);
            x = skip.max_pool2d(2, 2, 0, 1, false);
            skips.push(skip);
        }

        let x = self.bottleneck.forward(&x).feature_dropout(0.15, train);
        let mut x = match self.config.ablation {
            Ablation::Attention => x,
            Ablation::None | Ablation::History => self.attention.forward(&x),
        };

        let f = self.config.width;
        let film = self.film.forward(&self.history.forward(history, train)).dropout(0.1, train);
        let widths = [4 * f, 2 * f, f, f, 4 * f, 2 * f, f, f];
        let film = film.to_kind(kind).unsqueeze(-1).unsqueeze(-1).split_with_sizes(widths, 1);
        let (scales, shifts) = film.split_at(4);
        for ((up, skip), (scale, shift)) in
            self.decoder.iter().zip(skips.iter().rev()).zip(scales.iter().zip(shifts))
        {
            x = up.forward(&x, skip);
            if self.config.ablation != Ablation::History {
                x = scale * x + shift;
            }
        }

        let output = |layers: &nn::Sequential| layers.forward(&x).to_kind(KIND);
        Proposals { position: output(&self.position), action: output(&self.action) }
    }

    /// [`FusionNet::forward`] without dropout and without recording gradients.
    pub fn infer(&self, image: &Tensor, history: &History, precision: Precision) -> Proposals {
        no_grad(|| self.forward(image, history, precision, false))
    }
}
