//! Lines in the order that a linear model calls most even, line by line.

use beadwork_base::Control;
use beadwork_grid::Cell;

use super::Settings;
use super::setup::{Options, try_layers};
use crate::fill::{Draft, Fill, LineSet};
use crate::model::{ModelDraft, NameOf, ThermalModel};
use crate::plan::{PlanError, PlanOf};

/// Tries the sequences of the linear model along both axes, and goes on from the cheapest order.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    let limit = settings.max_seconds;
    let own = control.without_progress();
    let options =
        |state: &M, layer: u32| Ok(Options::of(state, layer, sequences(state, layer, &own)?, &own));
    let report = |done: usize| control.report(done, model.fill().layer_count());
    match try_layers(model, limit, options, |cost, _| cost, (report, &own))? {
        Err(plan) => Ok(plan),
        Ok(tried) => tried.plan(model, limit, &own).map(|(plan, _)| plan),
    }
}

/// The conventional order, and the sequences of the lines of each division of the layer.
fn sequences<M: ThermalModel>(
    state: &M,
    layer: u32,
    control: &Control<'_>,
) -> Result<Vec<ModelDraft<M>>, PlanError> {
    let linear = state.linear_layer(layer).ok_or(PlanError::NotLinear)?;
    let draft = |lines: &<M::Fill as Fill>::Lines| {
        let cells: Vec<&[Cell]> = (0..lines.count()).map(|line| lines.cells(line)).collect();
        let sequence = linear.greedy_sequence(&cells);
        Draft { path: lines.path(&sequence, state.position()), name: None }
    };
    let mut drafts = vec![state.fill().conventional(layer)];
    drafts.extend(control.threads.map(&state.fill().all_lines(layer), draft));
    Ok(drafts)
}
