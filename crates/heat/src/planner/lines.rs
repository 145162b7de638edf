//! Orders of lines: a screen picks candidates, the model decides, and the lines are annealed.

use beadwork_base::Control;

use super::Settings;
use super::refine::Refinement;
use super::setup::{Options, check_time, chosen, complete_interrupted, try_layers};
use super::shortlist::shortlist;
use crate::fill::Fill;
use crate::model::{NameOf, ThermalModel};
use crate::plan::{PlanError, PlanOf, printed_layers};

/// Plans with named orders first, then anneals the lines of each layer within the time that is
/// left.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    assert!(settings.screened > 0, "at least one order of a layer is tried");
    let layers = model.fill().layer_count();
    let own = control.without_progress();
    let steps = layers * (2 + usize::from(settings.annealing.is_some()));
    let report = |done: usize| control.report(done, steps);
    let (count, limit) = (settings.screened, settings.max_seconds);
    let orders = &settings.orders;
    let shortlist = match shortlist(model, orders, (count, limit), report, &own)? {
        Ok(shortlist) => shortlist,
        Err(reason) => return complete_interrupted(model, &[], limit, reason),
    };
    let options = |state: &M, layer: u32| {
        Ok(Options::of(state, layer, shortlist.drafts[layer as usize].clone(), &own))
    };
    let score = |cost: f64, seconds: f64| shortlist.score(cost, seconds);
    let report_tried = |done: usize| report(layers + done);
    let tried = match try_layers(model, limit, options, score, (report_tried, &own))? {
        Err(plan) => return Ok(plan),
        Ok(tried) => tried,
    };
    let mut plan = match &settings.annealing {
        None => tried.plan(model, limit, &own)?.0,
        Some(annealing) => {
            let (drafts, price) = chosen(model, &tried.layers, limit);
            let seed = settings.seed;
            let refinement = Refinement { model, annealing, price, max_seconds: limit, seed };
            let report_refined = |done: usize| report(2 * layers + done);
            let mut plan = check_time(refinement.run(&drafts, report_refined, &own)?, limit)?;
            plan.deposited_layers += tried.deposited_layers;
            plan
        }
    };
    plan.deposited_layers += printed_layers(model.fill());
    Ok(plan)
}
