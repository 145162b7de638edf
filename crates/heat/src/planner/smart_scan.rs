//! Lines in the order that a linear model calls most even, line by line.

use beadwork_base::Control;
use beadwork_grid::Region;
use beadwork_part::{Axis, Corner, Ends, LineOrder, Order, Sequence};

use super::Settings;
use super::setup::{Options, try_layers};
use crate::model::ThermalModel;
use crate::plan::{Draft, HeatPlan, PlanError, regions};

/// Tries the sequences of the linear model along both axes, and goes on from the cheapest order.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    let regions = regions(model.part())?;
    let limit = settings.max_seconds;
    let own = control.without_progress();
    let options = |state: &M, layer: u32, region: &_| {
        let drafts = sequences(state, layer, region, &own)?;
        Ok(Options::of(state, layer, drafts, &own))
    };
    let report = |done: usize| control.report(done, regions.len());
    match try_layers(model, &regions, limit, options, |cost, _| cost, (report, &own))? {
        Err(plan) => Ok(plan),
        Ok(tried) => tried.plan(model, &regions, limit, &own).map(|(plan, _)| plan),
    }
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
