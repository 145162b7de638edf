//! Orders of lines: a screen picks candidates, the model decides, and the lines are annealed.

use beadwork_base::Control;

use super::Settings;
use super::refine::Refinement;
use super::setup::{Options, check_time, chosen, complete_interrupted, finish};
use super::shortlist::shortlist;
use crate::model::ThermalModel;
use crate::plan::{HeatPlan, PlanError, regions};
use crate::trials::try_orders;

/// Plans with named orders first, then anneals the lines of each layer within the time that is
/// left.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    assert!(settings.screened > 0, "at least one order of a layer is tried");
    let regions = regions(model.part())?;
    let own = control.without_progress();
    let steps = regions.len() * (2 + usize::from(settings.annealing.is_some()));
    let report = |done: usize| control.report(done, steps);
    let limits = (settings.screened, settings.max_seconds);
    let shortlist = match shortlist(model, &regions, &settings.orders, limits, report, &own)? {
        Ok(shortlist) => shortlist,
        Err(reason) => {
            return complete_interrupted(model, &[], &regions, settings.max_seconds, reason);
        }
    };
    let mut deposited_layers = regions.iter().flatten().count();
    let mut state = model.clone();
    let mut layers: Vec<Option<Options>> = Vec::new();
    let mut interrupted = None;
    for ((layer, region), orders) in (0..).zip(&regions).zip(&shortlist.orders) {
        report(regions.len() + layers.len());
        let Some(region) = region else {
            layers.push(None);
            continue;
        };
        let mut options = Options::new(&state, layer, region, orders, &own);
        let score = |index: usize, cost: f64| shortlist.score(cost, options.choices[index].seconds);
        let trials = try_orders(&state, layer, &options.cells(), 1, score, &own)?;
        interrupted = trials.interrupted.or_else(|| control.interrupted());
        if interrupted.is_some() {
            break;
        }
        deposited_layers += trials.costs.len();
        for (choice, cost) in options.choices.iter_mut().zip(&trials.costs) {
            choice.cost = cost.unwrap_or(f64::INFINITY);
        }
        if let Some(best) = trials.best.into_iter().next() {
            state = best.model;
        }
        layers.push(Some(options));
    }
    if let Some(reason) = interrupted {
        return complete_interrupted(model, &layers, &regions, settings.max_seconds, reason);
    }
    let (drafts, price) = chosen(model, &layers, &regions, settings.max_seconds);
    let mut plan = match &settings.annealing {
        None => finish(model, drafts, &own)?,
        Some(annealing) => {
            let Settings { max_seconds, seed, .. } = *settings;
            let refinement =
                Refinement { model, annealing, regions: &regions, price, max_seconds, seed };
            refinement.run(&drafts, |done| report(2 * regions.len() + done), &own)?
        }
    };
    plan.deposited_layers += deposited_layers;
    check_time(plan, settings.max_seconds)
}
