//! The distribution over permitted actions that logits stand for.
//!
//! Huang and Ontañón, "A Closer Look at Invalid Action Masking in Policy Gradient Algorithms"
//! (2022): logits of actions that are not permitted are replaced by a number so low that their
//! probability is exactly 0 and no gradient flows through them.

use tch::{Kind, Tensor};

/// The logit of an action that is not permitted: -1e8, as in the public implementation of the
/// paper.
/// It is finite, because infinities in a product with a probability of 0 are not numbers.
const NOT_PERMITTED: f64 = -1e8;

/// A distribution over actions for each row of a batch.
#[derive(Debug)]
pub struct Categorical {
    /// Natural logarithm of each action's probability, `[batch, action]`; about -1e8 for actions
    /// that are not permitted.
    pub log_probabilities: Tensor,
}

impl Categorical {
    /// The softmax of `logits` over the actions that are `permitted`, both `[batch, action]`.
    /// Each row must permit at least one action.
    pub fn new(logits: &Tensor, permitted: &Tensor) -> Self {
        let masked = logits.masked_fill(&permitted.logical_not(), NOT_PERMITTED);
        Self { log_probabilities: masked.log_softmax(-1, Kind::Float) }
    }

    /// Logarithm of the probability of each row's action; `actions` are numbers, `[batch]`.
    pub fn log_probability(&self, actions: &Tensor) -> Tensor {
        self.log_probabilities.gather(1, &actions.unsqueeze(1), false).squeeze_dim(1)
    }

    /// Entropy of each row in nats, `[batch]`: 0 if one action is certain, the logarithm of the
    /// number of permitted actions if all are equally likely.
    pub fn entropy(&self) -> Tensor {
        // A probability of exactly 0 has a finite logarithm here, so its product is 0.
        -(self.log_probabilities.exp() * &self.log_probabilities).sum_dim_intlist(
            [-1_i64].as_slice(),
            false,
            Kind::Float,
        )
    }

    /// Probabilities, `[batch, action]`; exactly 0 for actions that are not permitted.
    pub fn probabilities(&self) -> Tensor {
        self.log_probabilities.exp()
    }
}

/// The action that a number from 0 to 1 draws from a row of probabilities; actions with probability
/// 0 are never drawn.
///
/// # Panics
/// If no probability is positive.
pub(super) fn draw(probabilities: &[f32], number: f64) -> usize {
    let total: f64 = probabilities.iter().map(|&p| f64::from(p)).sum();
    let (mut sum, mut drawn) = (0.0, None);
    for (action, &probability) in probabilities.iter().enumerate() {
        if probability > 0.0 {
            sum += f64::from(probability);
            drawn = Some(action);
            if sum > number * total {
                break;
            }
        }
    }
    drawn.expect("a permitted action has a positive probability")
}

/// The most likely action of a row, the first of several; actions with probability 0 are never
/// chosen.
///
/// # Panics
/// If no probability is positive.
pub(super) fn likeliest(probabilities: &[f32]) -> usize {
    let mut best: Option<usize> = None;
    for (action, &probability) in probabilities.iter().enumerate() {
        if probability > best.map_or(0.0, |best| probabilities[best]) {
            best = Some(action);
        }
    }
    best.expect("a permitted action has a positive probability")
}
