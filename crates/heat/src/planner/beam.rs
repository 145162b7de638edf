//! Several sequences of orders, extended layer by layer.

use std::sync::Arc;

use beadwork_base::Control;

use super::Settings;
use super::greedy;
use super::setup::{Options, drafts, finish};
use crate::fill::Fill;
use crate::model::{ModelDraft, NameOf, ThermalModel};
use crate::plan::{HeatPlan, PlanError, PlanOf, drafts_seconds, layers};
use crate::trials::try_orders;

/// A sequence of orders of the layers so far.
struct Sequence<M> {
    model: M,
    score: f64,
    /// Index of each layer's order among its candidates, linked from the last layer back.
    path: Option<Arc<Step>>,
}

struct Step {
    index: usize,
    before: Option<Arc<Step>>,
}

/// Extends the best sequences by all named orders of the next layer and keeps the best again.
///
/// Time counts at the price that the greedy plan found.
/// Of this plan and the greedy one, the cheaper within the limit is the result, so that it is never
/// worse.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    assert!(settings.beam_width > 0, "a beam keeps at least one sequence");
    let greedy = greedy::search(model, settings, &control.without_progress())?;
    if greedy.plan.stop.is_interrupted() {
        return Ok(greedy.plan);
    }
    let own = control.without_progress();
    let mut deposited_layers = greedy.plan.deposited_layers;
    let mut beam = vec![Sequence { model: model.clone(), score: 0.0, path: None }];
    let mut candidates: Vec<Option<Options<M>>> = Vec::new();
    for (layer, is_printed) in layers(model.fill()) {
        if !is_printed {
            candidates.push(None);
            continue;
        }
        let options = Options::new(model, layer, &settings.orders, &own);
        let paths = options.paths();
        let mut next: Vec<Sequence<M>> = Vec::new();
        for sequence in &beam {
            let score = |index: usize, cost: f64| {
                let seconds = sequence.model.path_seconds(layer, paths[index]);
                sequence.score + cost + greedy.price * seconds
            };
            let trials =
                try_orders(&sequence.model, layer, &paths, settings.beam_width, score, &own)?;
            if let Some(reason) = trials.interrupted {
                return Ok(HeatPlan { stop: reason.into(), ..greedy.plan });
            }
            deposited_layers += paths.len();
            next.extend(trials.best.into_iter().map(|trial| {
                let path = Arc::new(Step { index: trial.index, before: sequence.path.clone() });
                Sequence { model: trial.model, score: trial.score, path: Some(path) }
            }));
            // Stable: of equal scores, the sequence that was ahead stays ahead.
            next.sort_by(|a, b| a.score.total_cmp(&b.score));
            next.truncate(settings.beam_width);
        }
        beam = next;
        candidates.push(Some(options));
        control.report(candidates.len(), model.fill().layer_count());
    }
    let drafts = beam.iter().map(|sequence| drafts(&candidates, &taken(sequence.path.as_ref())));
    let is_fast =
        |drafts: &Vec<ModelDraft<M>>| drafts_seconds(model, drafts) <= settings.max_seconds;
    // Sequences are sorted, and differ in their last layers only.
    let beam = drafts.filter(is_fast).take(1).map(|drafts| finish(model, drafts, &own)).next();
    let plan = match beam {
        Some(Ok(plan)) if plan.cost() < greedy.plan.cost() => plan,
        Some(Err(error)) => return Err(error),
        Some(Ok(_)) | None => greedy.plan,
    };
    Ok(HeatPlan { deposited_layers, ..plan })
}

/// Indices of the orders of all layers of a sequence.
fn taken(mut path: Option<&Arc<Step>>) -> Vec<usize> {
    let mut taken = Vec::new();
    while let Some(step) = path {
        taken.push(step.index);
        path = step.before.as_ref();
    }
    taken.reverse();
    taken
}
