//! Evaluation of a network on examples that it was not trained on.

use std::collections::BTreeMap;

use beadwork_base::{Control, Interrupted};
use tch::{Device, Kind, no_grad};

use super::baseline::Baseline;
use super::loss::{actions_at, fusion_loss};
use super::network::{FusionNet, Proposals};
use super::samples::{Batch, Targets};
use super::training_config::TrainingConfig;

/// Loss and accuracy of a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Mean loss of the batches, each with the same weight, whatever its size.
    pub loss: f64,
    /// Accuracy on all examples.
    pub all: Hits,
    /// Accuracy on the examples of each layout, and the baselines of these examples, added up.
    pub by_layout: BTreeMap<String, (Hits, Baseline)>,
}

/// How many examples a network predicts correctly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hits {
    /// Number of examples.
    pub count: u64,
    /// Examples whose recorded position scores above all negatives.
    pub top_1: u64,
    /// Examples for which at most four negatives score at least as high as the recorded position.
    pub top_5: u64,
    /// Examples whose recorded variant is the most likely one at the recorded position.
    pub action: u64,
}

/// Evaluates a network on batches, without changing it.
///
/// The accuracy counts each example once.
/// The loss is a mean over batches, so examples in small batches weigh more.
///
/// Progress counts batches.
/// The threads of `control` are not used: libtorch has its own.
pub fn evaluate(
    network: &FusionNet,
    batches: &[Batch],
    config: &TrainingConfig,
    device: Device,
    control: &Control<'_>,
) -> Result<Evaluation, Interrupted> {
    let mut evaluation = Evaluation::default();
    for (done, batch) in batches.iter().enumerate() {
        control.check()?;
        control.report(done, batches.len());
        let (image, history) = batch.inputs.tensors(device);
        let targets = batch.targets(device);
        let proposals = network.infer(&image, &history, config.precision);
        let loss = no_grad(|| fusion_loss(&proposals, &targets, &config.loss));
        evaluation.loss += loss.double_value(&[]);
        let hits = Hits::of_examples(&proposals, &targets);
        for (hits, (layout, &baseline)) in
            hits.into_iter().zip(batch.layouts.iter().zip(&batch.baselines))
        {
            evaluation.all.add(hits);
            let by_layout = evaluation.by_layout.entry(layout.clone()).or_default();
            by_layout.0.add(hits);
            by_layout.1.add(baseline);
        }
    }
    evaluation.loss /= batches.len().max(1) as f64;
    control.report(batches.len(), batches.len());
    Ok(evaluation)
}

impl Hits {
    /// The hits of each example of a batch, all with a count of 1.
    pub fn of_examples(proposals: &Proposals, targets: &Targets) -> Vec<Self> {
        let scores = proposals.position.flatten(1, -1);
        let target = scores.gather(1, &targets.position.unsqueeze(1), false);
        // A tie counts against the network.
        let above = scores.ge_tensor(&target).logical_and(&targets.negatives);
        let ranks =
            Vec::<i64>::try_from(above.sum_dim_intlist(1, false, Kind::Int64)).expect("one axis");
        let most_likely = actions_at(proposals, &targets.position).argmax(1, false);
        let is_right = most_likely.eq_tensor(&targets.action).to_kind(Kind::Int64);
        let is_right = Vec::<i64>::try_from(is_right).expect("one axis");
        let hits = ranks.into_iter().zip(is_right).map(|(rank, is_right)| Self {
            count: 1,
            top_1: u64::from(rank < 1),
            top_5: u64::from(rank < 5),
            action: is_right as u64,
        });
        hits.collect()
    }

    /// Adds the hits of other examples.
    pub fn add(&mut self, other: Self) {
        self.count += other.count;
        self.top_1 += other.top_1;
        self.top_5 += other.top_5;
        self.action += other.action;
    }
}
