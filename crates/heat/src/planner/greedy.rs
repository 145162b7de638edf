//! Layer by layer, the best order now.

use beadwork_base::Control;

use super::Settings;
use super::setup::{Options, try_layers};
use crate::fill::Fill;
use crate::model::{NameOf, ThermalModel};
use crate::plan::{PlanError, PlanOf};

/// A greedy plan, and what it found out.
pub(super) struct Greedy<M: ThermalModel> {
    pub(super) plan: PlanOf<M>,
    /// Price of time under the limit, in costs per second.
    pub(super) price: f64,
}

/// Tries all named orders of each layer in turn and goes on from the cheapest.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    search(model, settings, control).map(|greedy| greedy.plan)
}

/// As [`solve`].
pub(super) fn search<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<Greedy<M>, PlanError> {
    let limit = settings.max_seconds;
    let own = control.without_progress();
    let options = |state: &M, layer: u32| Ok(Options::new(state, layer, &settings.orders, &own));
    let report = |done: usize| control.report(done, model.fill().layer_count());
    match try_layers(model, limit, options, |cost, _| cost, (report, &own))? {
        Err(plan) => Ok(Greedy { plan, price: 0.0 }),
        Ok(tried) => {
            let (plan, price) = tried.plan(model, limit, &own)?;
            Ok(Greedy { plan, price })
        }
    }
}
