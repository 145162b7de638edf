//! Lines in the order that a linear model calls most even, line by line.

use beadwork_base::Control;
use beadwork_grid::Region;
use beadwork_part::{Axis, Corner, Ends, LineOrder, Order, Sequence};

use super::Settings;
use super::setup::{Options, check_time, chosen, complete_interrupted, finish};
use crate::model::ThermalModel;
use crate::plan::{Draft, HeatPlan, PlanError, regions};
use crate::trials::try_orders;

/// Tries the sequences of the linear model along both axes, and goes on from the cheapest order.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    let regions = regions(model.part())?;
    let own = control.without_progress();
    let mut state = model.clone();
    let mut layers: Vec<Option<Options>> = Vec::new();
    let mut deposited_layers = 0;
    for (layer, region) in (0..).zip(&regions) {
        control.report(layers.len(), regions.len());
        let Some(region) = region else {
            layers.push(None);
            continue;
        };
        let drafts = sequences(&state, layer, region, &own)?;
        let mut options = Options::of(&state, layer, drafts, &own);
        let trials = try_orders(&state, layer, &options.cells(), 1, |_, cost| cost, &own)?;
        if let Some(reason) = trials.interrupted.or_else(|| control.interrupted()) {
            let limit = settings.max_seconds;
            return complete_interrupted(model, &layers, &regions, limit, reason);
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
    let (drafts, _) = chosen(model, &layers, &regions, settings.max_seconds);
    let mut plan = check_time(finish(model, drafts, &own)?, settings.max_seconds)?;
    plan.deposited_layers += deposited_layers;
    Ok(plan)
}

/// The conventional order, and the sequences of the lines along x and along y.
fn sequences<M: ThermalModel>(
    state: &M,
    layer: u32,
    region: &Region,
    control: &Control<'_>,
) -> Result<Vec<Draft>, PlanError> {
    let linear = state.linear_layer(layer).ok_or(PlanError::NotLinear)?;
    let along = |&axis: &Axis| {
        let order = LineOrder { sequence: Sequence::Golden, axis, corner: Corner::MinXMinY };
        let lines = order.lines(region);
        let sequence = linear.greedy_sequence(&lines.iter().collect::<Vec<_>>());
        let ends = Ends::Nearest { from: state.last_cell() };
        Draft { cells: lines.flatten(&sequence, ends), order: None }
    };
    let conventional = Order::CONVENTIONAL;
    let mut drafts = vec![Draft { cells: conventional.order(region), order: Some(conventional) }];
    drafts.extend(control.threads.map(&[Axis::X, Axis::Y], along));
    Ok(drafts)
}
