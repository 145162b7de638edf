//! Sizes of the network, its precision, and the parts that an ablation leaves out.

use serde::{Deserialize, Serialize};
use tch::Kind;

/// Number of channels of the image of a layer's state.
///
/// They are, in this order:
///
/// 0. the cell's zone, divided by the highest zone number (at least 1);
/// 1. 1 where the path links the cell with its right neighbour;
/// 2. 1 where the path links the cell with the neighbour below;
/// 3. 1 for cells of the layer, 0 for padding and cells outside the layer;
/// 4. 1 for cells with a neighbour in another zone;
/// 5. crossing links at the cell, divided by the largest number at any cell;
/// 6. crossings of the path, divided by those of the start path, in every cell of the layer;
/// 7. y, from 0 in the first row to 1 in the last;
/// 8. x, from 0 in the first column to 1 in the last.
pub const CHANNELS: i64 = 9;

/// Number of move variants, the classes of the network's action output.
pub const ACTIONS: i64 = 12;

/// Longest side of a layer, in cells, that the presets have coordinate embeddings for.
pub const MAX_SIDE: u32 = 128;

/// The element type of parameters, inputs and outputs.
pub(super) const KIND: Kind = Kind::Float;

/// Sizes of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Channels of the first and the last level, f: 2, 4, 8 or a multiple of 16. Group norms divide
    /// f and f / 2 channels into up to eight groups each.
    /// The deepest levels have 4 f channels.
    pub width: i64,
    /// Hidden units of each of the two recurrent layers of the history encoder.
    pub hidden: i64,
    /// Moves of the history that the network sees, K.
    pub history: i64,
    /// Entries of the embeddings of a move's x and y: the longest side of a layer, in cells.
    pub max_side: i64,
    /// Rows and columns of the largest image that the network is meant for: a multiple of 16.
    /// Parameters do not depend on it, and the network accepts any image whose sides are multiples
    /// of 16.
    pub canvas: i64,
    /// The part that is bypassed, to measure what it contributes.
    /// Its parameters exist nevertheless.
    pub ablation: Ablation,
}

/// A part of the network that is bypassed in an ablation study.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ablation {
    /// The full network.
    #[default]
    #[serde(alias = "nothing")]
    None,
    /// No history: the decoder's features are not modulated by the previous moves.
    History,
    /// No self-attention at the bottleneck.
    Attention,
}

impl Config {
    /// The paper's network: f = 48, K = 32, 192 hidden units, images of up to 128 x 128 cells.
    pub const fn paper() -> Self {
        Self {
            width: 48,
            hidden: 192,
            history: 32,
            max_side: MAX_SIDE as i64,
            canvas: 128,
            ablation: Ablation::None,
        }
    }

    /// A narrower network, f = 32, on the smallest canvas that holds a grid whose longer side is
    /// `side` cells.
    pub const fn small(side: i64) -> Self {
        Self {
            width: 32,
            hidden: 192,
            history: 32,
            max_side: MAX_SIDE as i64,
            canvas: (side + 15) / 16 * 16,
            ablation: Ablation::None,
        }
    }
}

/// The precision of the image's features, in convolutions, norms and `FiLM`.
/// Parameters and their gradients, the history encoder, self-attention and the outputs stay in
/// single precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 32 bits.
    #[default]
    Single,
    /// bfloat16, the upper 16 bits of single precision.
    /// About 1.6 times as fast in training on processors with AMX, slower on processors without
    /// instructions for it.
    Half,
}

impl Precision {
    pub(super) fn kind(self) -> Kind {
        match self {
            Self::Single => KIND,
            Self::Half => Kind::BFloat16,
        }
    }
}
