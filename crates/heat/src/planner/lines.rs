//! Orders of lines: a proxy picks candidates, the model decides, and the lines are annealed.

use beadwork_base::Control;
use beadwork_grid::Cell;

use super::Settings;
use super::refine::Refinement;
use super::setup::{Options, check_time, chosen, complete_interrupted, finish};
use crate::model::{Screen, ThermalModel};
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
    let steps = regions.len() * (1 + usize::from(settings.annealing.is_some()));
    let mut state = model.clone();
    let mut layers: Vec<Option<Options>> = Vec::new();
    let mut deposited_layers = 0;
    let mut interrupted = None;
    for (layer, region) in (0..).zip(&regions) {
        control.report(layers.len(), steps);
        let Some(region) = region else {
            layers.push(None);
            continue;
        };
        let mut options = Options::new(&state, layer, region, &settings.orders, &own);
        let picked = screened(&state, layer, &options, settings, &own)?;
        let cells: Vec<&[Cell]> =
            picked.iter().map(|&index| &options.candidates[index].cells[..]).collect();
        let trials = try_orders(&state, layer, &cells, 1, |_, cost| cost, &own)?;
        interrupted = trials.interrupted.or_else(|| control.interrupted());
        if interrupted.is_some() {
            break;
        }
        deposited_layers += cells.len();
        for (&index, cost) in picked.iter().zip(&trials.costs) {
            options.choices[index].cost = cost.unwrap_or(f64::INFINITY);
        }
        // Options that were not tried are left out.
        let mut tried = picked;
        tried.sort_unstable();
        options = Options {
            candidates: tried.iter().map(|&index| options.candidates[index].clone()).collect(),
            choices: tried.iter().map(|&index| options.choices[index]).collect(),
        };
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
            refinement.run(&drafts, |done| control.report(regions.len() + done, steps), &own)?
        }
    };
    plan.deposited_layers += deposited_layers;
    check_time(plan, settings.max_seconds)
}

/// Indices of the candidates that the model tries: the conventional one, those that no other beats
/// in both estimated cost and time, and the cheapest of the rest.
fn screened<M: ThermalModel>(
    model: &M,
    layer: u32,
    options: &Options,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Vec<usize>, PlanError> {
    let screen = model.screen(layer).ok_or(PlanError::NoScreen)?;
    let costs = control.threads.map(&options.candidates, |candidate| screen.cost(&candidate.cells));
    let seconds = |index: usize| options.choices[index].seconds;
    let mut by_cost: Vec<usize> = (0..costs.len()).collect();
    by_cost.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
    let mut fastest = f64::INFINITY;
    let (mut efficient, mut rest) = (Vec::new(), Vec::new());
    for index in by_cost {
        if seconds(index) < fastest {
            fastest = seconds(index);
            efficient.push(index);
        } else {
            rest.push(index);
        }
    }
    let mut picked = vec![0];
    let others = efficient.into_iter().chain(rest).filter(|&index| index != 0);
    picked.extend(others.take(settings.screened));
    Ok(picked)
}
