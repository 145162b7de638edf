//! The same order in every layer.

use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::Control;
use beadwork_search::Stop;
use beadwork_thermal::simulation::DepositError;

use super::Settings;
use super::setup::check_time;
use crate::fill::Fill;
use crate::model::{NameOf, ThermalModel};
use crate::plan::{
    HeatPlan, PlanError, PlanOf, conventional, conventional_drafts, drafts_seconds, follow,
    same_order_drafts,
};

/// Deposits the whole part once in each named order that is within the limit, and returns the
/// cheapest plan.
pub(super) fn solve<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    let fill = model.fill();
    let mut seen = HashSet::new();
    let mut plans = Vec::new();
    let named = settings.orders.iter().map(|&order| same_order_drafts(fill, order));
    for drafts in [conventional_drafts(fill)].into_iter().chain(named) {
        let paths: Vec<_> = drafts.iter().map(|draft| draft.path.clone()).collect();
        let seconds = drafts_seconds(model, &drafts);
        if seconds <= settings.max_seconds && seen.insert(paths) {
            plans.push(drafts);
        }
    }
    let layers = fill.layer_count();
    let (done, total) = (AtomicUsize::new(0), plans.len() * layers);
    let own = control.on_one_thread().without_progress();
    let followed = control.threads.map(&plans, |drafts| {
        let plan = follow(model, drafts.clone(), &own);
        control.report(done.fetch_add(layers, Ordering::Relaxed) + layers, total);
        plan
    });
    let mut best: Option<PlanOf<M>> = None;
    let (mut stop, mut deposited_layers) = (Stop::Done, 0);
    for plan in followed {
        match plan {
            Ok(plan) => {
                deposited_layers += plan.deposited_layers;
                if best.as_ref().is_none_or(|best| plan.cost() < best.cost()) {
                    best = Some(plan);
                }
            }
            Err(PlanError::Deposit(DepositError::Interrupted(reason))) => stop = reason.into(),
            Err(error) => return Err(error),
        }
    }
    let best = match best {
        Some(best) => HeatPlan { deposited_layers, ..best },
        None => conventional(model, &Control::default())?,
    };
    check_time(HeatPlan { stop, ..best }, settings.max_seconds)
}
