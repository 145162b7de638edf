//! What the network is trained for, and how well it does.
//!
//! Aali et al., section FusionNet: the true position is ranked above the hardest others by a
//! margin, its action classified, and with less weight that of its four neighbours.

use tch::{Kind, Reduction, Tensor};

use super::Proposals;
use super::samples::Targets;

/// How positions are learned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PositionLoss {
    /// Ranked above the hardest rivals, as in the paper.
    #[default]
    Ranking,
    /// Classified among all rivals.
    Classification,
}

/// Weights and margins of the loss.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LossSettings {
    /// How positions are learned.
    pub position: PositionLoss,
    /// By how much the true position shall score above others.
    pub margin: f64,
    /// Number of the others that score most.
    pub hardest: i64,
    /// Label smoothing of the action at the true position.
    pub smoothing: f64,
    /// Weight of the action at the four neighbours.
    pub neighbours: f64,
    /// Label smoothing there.
    pub neighbour_smoothing: f64,
}

impl Default for LossSettings {
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

/// A score that no cell reaches.
const LOWEST: f64 = -1e4;

/// The mean loss of a batch, a scalar.
pub fn loss(proposals: &Proposals, targets: &Targets, settings: &LossSettings) -> Tensor {
    position_loss(proposals, targets, settings) + action_loss(proposals, targets, settings)
}

fn position_loss(proposals: &Proposals, targets: &Targets, settings: &LossSettings) -> Tensor {
    let scores = proposals.position.flatten(1, -1);
    let truth = scores.gather(1, &targets.position.unsqueeze(1), false);
    let others = scores.masked_fill(&targets.rivals.logical_not(), LOWEST);
    match settings.position {
        PositionLoss::Ranking => {
            let count = settings.hardest.min(others.size()[1]);
            let (hardest, _) = others.topk(count, 1, true, false);
            let real = hardest.gt(LOWEST / 2.0).to_kind(Kind::Float);
            let short = (hardest - truth + settings.margin).relu() * &real;
            short.sum(Kind::Float) / real.sum(Kind::Float).clamp_min(1.0)
        }
        PositionLoss::Classification => {
            let all = Tensor::cat(&[&truth, &others], 1);
            -all.log_softmax(1, Kind::Float).select(1, 0).mean(Kind::Float)
        }
    }
}

fn action_loss(proposals: &Proposals, targets: &Targets, settings: &LossSettings) -> Tensor {
    let (.., height, width) = proposals.action.size4().expect("an image has four axes");
    let device = proposals.action.device();
    let entropy = |logits: &Tensor, smoothing: f64| {
        logits.cross_entropy_loss::<Tensor>(&targets.action, None, Reduction::None, -100, smoothing)
    };
    let own =
        entropy(&actions_at(proposals, &targets.position), settings.smoothing).mean(Kind::Float);
    if settings.neighbours == 0.0 {
        return own;
    }
    let x = targets.position.remainder(width);
    let y = targets.position.divide_scalar_mode(width, "floor");
    let mut sum = Tensor::zeros([], (Kind::Float, device));
    let mut count = Tensor::zeros([], (Kind::Float, device));
    for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
        let (x, y) = (&x + dx, &y + dy);
        let inside =
            x.ge(0).logical_and(&x.lt(width)).logical_and(&y.ge(0)).logical_and(&y.lt(height));
        let position = y.clamp(0, height - 1) * width + x.clamp(0, width - 1);
        let inside = inside.to_kind(Kind::Float);
        sum += (entropy(&actions_at(proposals, &position), settings.neighbour_smoothing) * &inside)
            .sum(Kind::Float);
        count += inside.sum(Kind::Float);
    }
    own + settings.neighbours * (sum / count)
}

/// The logits of the actions, `[batch, 12]`, at one cell of each canvas.
fn actions_at(proposals: &Proposals, position: &Tensor) -> Tensor {
    let (batch, actions, ..) = proposals.action.size4().expect("an image has four axes");
    let index = position.view([batch, 1, 1]).expand([batch, actions, 1], false);
    proposals.action.flatten(2, -1).gather(2, &index, false).squeeze_dim(2)
}

/// How many examples the network gets right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hits {
    /// Examples.
    pub count: u64,
    /// With the true position scored above all rivals.
    pub top_1: u64,
    /// With at most four rivals scored above it.
    pub top_5: u64,
    /// With the true action as the most likely at the true position.
    pub action: u64,
}

impl Hits {
    /// Those of each example.
    pub fn each(proposals: &Proposals, targets: &Targets) -> Vec<Self> {
        let scores = proposals.position.flatten(1, -1);
        let truth = scores.gather(1, &targets.position.unsqueeze(1), false);
        let above = scores.ge_tensor(&truth).logical_and(&targets.rivals);
        let ranks =
            Vec::<i64>::try_from(above.sum_dim_intlist(1, false, Kind::Int64)).expect("one axis");
        let likeliest =
            actions_at(proposals, &targets.position).argmax(1, false).eq_tensor(&targets.action);
        let right = Vec::<i64>::try_from(likeliest.to_kind(Kind::Int64)).expect("one axis");
        let hits = ranks.into_iter().zip(right).map(|(rank, right)| Self {
            count: 1,
            top_1: u64::from(rank < 1),
            top_5: u64::from(rank < 5),
            action: right as u64,
        });
        hits.collect()
    }

    /// Adds those of another batch.
    pub fn add(&mut self, other: Self) {
        self.count += other.count;
        self.top_1 += other.top_1;
        self.top_5 += other.top_5;
        self.action += other.action;
    }
}
