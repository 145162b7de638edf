//! Layer by layer, the best order now.

use beadwork_base::Control;

use super::Settings;
use super::setup::{Options, check_time, chosen, complete_interrupted, finish};
use crate::model::ThermalModel;
use crate::plan::{HeatPlan, PlanError, regions};
use crate::trials::try_orders;

/// A greedy plan, and what it found out.
pub(super) struct Greedy {
    pub(super) plan: HeatPlan,
    /// Price of time under the limit, in costs per second.
    pub(super) price: f64,
}

/// Tries all named orders of each layer in turn and goes on from the cheapest.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    search(model, settings, control).map(|greedy| greedy.plan)
}

/// As [`solve`].
///
/// If the cheapest orders together take longer than the limit, the costs found on the way decide
/// which layers get faster ones: layers hardly influence one another.
pub(super) fn search<M: ThermalModel>(
    model: &M,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Greedy, PlanError> {
    let regions = regions(model.part())?;
    let own = control.without_progress();
    let mut state = model.clone();
    let mut layers: Vec<Option<Options>> = Vec::new();
    let mut deposited_layers = 0;
    let mut interrupted = None;
    for (layer, region) in (0..).zip(&regions) {
        let Some(region) = region else {
            layers.push(None);
            continue;
        };
        let mut options = Options::new(&state, layer, region, &settings.orders, &own);
        let trials = try_orders(&state, layer, &options.cells(), 1, |_, cost| cost, &own)?;
        if let Some(reason) = trials.interrupted {
            interrupted = Some(reason);
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
        control.report(layers.len(), regions.len());
    }
    if let Some(reason) = interrupted {
        let plan = complete_interrupted(model, &layers, &regions, settings.max_seconds, reason)?;
        return Ok(Greedy { plan, price: 0.0 });
    }
    let (drafts, price) = chosen(model, &layers, &regions, settings.max_seconds);
    let mut plan = check_time(finish(model, drafts, &own)?, settings.max_seconds)?;
    plan.deposited_layers += deposited_layers;
    Ok(Greedy { plan, price })
}
