//! The moves that led to a layer's current path, and their encoder.

use tch::nn::{self, Module, Path};
use tch::{Kind, Tensor};

use super::config::{ACTIONS, KIND};

/// The last moves of each layer of a batch: tensors of shape `[batch, K]`.
///
/// The moves of a layer start at index 0, oldest first.
/// Entries after the last move are padding.
#[derive(Debug)]
pub struct History {
    /// Variants of the moves, 0 to 11, 64-bit integers.
    pub action: Tensor,
    /// Rows of their windows' top-left cells, 64-bit integers.
    pub y: Tensor,
    /// Columns of their windows' top-left cells, 64-bit integers.
    pub x: Tensor,
    /// Crossings before the move, divided by the crossings of the start path.
    pub before: Tensor,
    /// Crossings after the move, divided by the crossings of the start path.
    pub after: Tensor,
    /// 1 for a move, 0 for padding.
    pub mask: Tensor,
}

/// Number of features in which each of the five properties of a move is embedded.
const EMBEDDED: i64 = 16;

/// Stacked recurrent layers.
const LAYERS: i64 = 2;

/// Embeds each move and runs a gated recurrent unit (GRU) over them.
#[derive(Debug)]
pub(super) struct HistoryEncoder {
    action: nn::Embedding,
    y: nn::Embedding,
    x: nn::Embedding,
    before: nn::Linear,
    after: nn::Linear,
    /// For each layer: weights of its input, weights of its state, and the biases of both.
    gru: Vec<Tensor>,
    hidden: i64,
}

impl HistoryEncoder {
    pub(super) fn new(vs: &Path<'_>, hidden: i64, max_side: i64) -> Self {
        let embed = |name: &str, count| {
            nn::embedding(vs / name, count, EMBEDDED, nn::EmbeddingConfig::default())
        };
        let linear =
            |name: &str| nn::linear(vs / name / 0, 1, EMBEDDED, nn::LinearConfig::default());
        let inner = vs / "gru";
        let bound = 1.0 / (hidden as f64).sqrt();
        let mut gru = Vec::new();
        for layer in 0..LAYERS {
            let from = if layer == 0 { 5 * EMBEDDED } else { hidden };
            let shapes: [(&str, &[i64]); 4] = [
                ("weight_ih", &[3 * hidden, from]),
                ("weight_hh", &[3 * hidden, hidden]),
                ("bias_ih", &[3 * hidden]),
                ("bias_hh", &[3 * hidden]),
            ];
            gru.extend(shapes.map(|(name, shape)| {
                inner.var(
                    &format!("{name}_l{layer}"),
                    shape,
                    nn::Init::Uniform { lo: -bound, up: bound },
                )
            }));
        }
        Self {
            action: embed("action_embed", ACTIONS),
            y: embed("pos_y_embed", max_side),
            x: embed("pos_x_embed", max_side),
            before: linear("cb_proj"),
            after: linear("ca_proj"),
            gru,
            hidden,
        }
    }

    /// The state of the upper layer after the last move, `[batch, hidden]`; zeros where there is no
    /// move.
    pub(super) fn forward(&self, history: &History, train: bool) -> Tensor {
        let History { action, y, x, before, after, mask } = history;
        let crossings =
            |linear: &nn::Linear, share: &Tensor| linear.forward(&share.unsqueeze(-1)).relu();
        let moves = Tensor::cat(
            &[
                self.action.forward(action),
                self.y.forward(y),
                self.x.forward(x),
                crossings(&self.before, before),
                crossings(&self.after, after),
            ],
            -1,
        );
        let (batch, _) = mask.size2().expect("a history has two axes");
        let start = Tensor::zeros([LAYERS, batch, self.hidden], (KIND, moves.device()));
        // The GRU also runs over the padding after the last move; its states there are not read.
        let (states, _) = moves.gru(&start, &self.gru, true, LAYERS, 0.15, train, false, true);
        let count = mask.sum_dim_intlist(1, false, Kind::Int64);
        let last =
            (&count - 1).clamp_min(0).view([batch, 1, 1]).expand([batch, 1, self.hidden], false);
        let has_moves = count.gt(0).to_kind(KIND).unsqueeze(1);
        states.gather(1, &last, false).squeeze_dim(1) * has_moves
    }
}
