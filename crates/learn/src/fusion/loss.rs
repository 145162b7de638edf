//! The training loss.
//!
//! Aali et al., section FusionNet: a margin ranking loss of the recorded position against the
//! highest-scoring negatives (hard negative mining), plus the cross entropy of its action, plus,
//! with less weight, the cross entropy of the same action at the four neighbouring cells.

use serde::{Deserialize, Serialize};
use tch::{Kind, Reduction, Tensor};

use super::network::Proposals;
use super::samples::Targets;

/// The loss of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PositionLoss {
    /// Margin ranking against the hardest negatives, as in the paper.
    #[default]
    Ranking,
    /// Cross entropy among the recorded position and all negatives.
    Classification,
}

/// Weights and margins of the loss.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The loss of positions.
    pub position: PositionLoss,
    /// Ranking: the margin by which the recorded position should score above each negative.
    pub margin: f64,
    /// Ranking: number of negatives per example that enter the loss, those with the highest scores.
    pub hardest: i64,
    /// Label smoothing of the action at the recorded position, 0..=1.
    pub smoothing: f64,
    /// Weight of the action at the four neighbours of the recorded position.
    pub neighbours: f64,
    /// Label smoothing of the action at the neighbours, 0..=1.
    pub neighbour_smoothing: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            position: PositionLoss::Ranking,
            margin: 1.0,
            hardest: 32,
            smoothing: 0.1,
            neighbours: 0.3,
            neighbour_smoothing: 0.2,
        }
    }
}

/// The mean loss of a batch, a scalar.
pub fn fusion_loss(proposals: &Proposals, targets: &Targets, settings: &Settings) -> Tensor {
    position_loss(proposals, targets, settings) + action_loss(proposals, targets, settings)
}

fn position_loss(proposals: &Proposals, targets: &Targets, settings: &Settings) -> Tensor {
    /// Lower than any score that the network gives, but small enough in magnitude that sums with it
    /// stay finite.
    const MASKED: f64 = -1e4;
    let scores = proposals.position.flatten(1, -1);
    let target = scores.gather(1, &targets.position.unsqueeze(1), false);
    let negatives = scores.masked_fill(&targets.negatives.logical_not(), MASKED);
    match settings.position {
        PositionLoss::Ranking => {
            let count = settings.hardest.min(negatives.size()[1]);
            let (hardest, _) = negatives.topk(count, 1, true, false);
            // Examples with fewer negatives than `count` fill up with masked cells.
            let is_negative = hardest.gt(MASKED / 2.0).to_kind(Kind::Float);
            let shortfall = (hardest - target + settings.margin).relu() * &is_negative;
            shortfall.sum(Kind::Float) / is_negative.sum(Kind::Float).clamp_min(1.0)
        }
        PositionLoss::Classification => {
            let all = Tensor::cat(&[&target, &negatives], 1);
            -all.log_softmax(1, Kind::Float).select(1, 0).mean(Kind::Float)
        }
    }
}

fn action_loss(proposals: &Proposals, targets: &Targets, settings: &Settings) -> Tensor {
    let (.., height, width) = proposals.action.size4().expect("an image has four axes");
    let device = proposals.action.device();
    let cross_entropy = |logits: &Tensor, smoothing: f64| {
        logits.cross_entropy_loss::<Tensor>(&targets.action, None, Reduction::None, -100, smoothing)
    };
    let at_target = cross_entropy(&actions_at(proposals, &targets.position), settings.smoothing)
        .mean(Kind::Float);
    if settings.neighbours == 0.0 {
        return at_target;
    }
    // Neighbours outside the canvas are clamped into it, and their loss is multiplied by 0.
    let x = targets.position.remainder(width);
    let y = targets.position.divide_scalar_mode(width, "floor");
    let mut sum = Tensor::zeros([], (Kind::Float, device));
    let mut count = Tensor::zeros([], (Kind::Float, device));
    for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
        let (x, y) = (&x + dx, &y + dy);
        let inside =
            x.ge(0).logical_and(&x.lt(width)).logical_and(&y.ge(0)).logical_and(&y.lt(height));
        let inside = inside.to_kind(Kind::Float);
        let position = y.clamp(0, height - 1) * width + x.clamp(0, width - 1);
        let logits = actions_at(proposals, &position);
        let losses = cross_entropy(&logits, settings.neighbour_smoothing);
        sum += (losses * &inside).sum(Kind::Float);
        count += inside.sum(Kind::Float);
    }
    at_target + settings.neighbours * (sum / count)
}

/// The logits of the actions at one cell of each canvas, `[batch, 12]`.
pub(super) fn actions_at(proposals: &Proposals, position: &Tensor) -> Tensor {
    let (batch, actions, ..) = proposals.action.size4().expect("an image has four axes");
    let index = position.view([batch, 1, 1]).expand([batch, actions, 1], false);
    proposals.action.flatten(2, -1).gather(2, &index, false).squeeze_dim(2)
}
