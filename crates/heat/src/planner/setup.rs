//! What planners have in common.

use std::collections::HashSet;

use beadwork_base::{Control, Interrupted};
use beadwork_search::Stop;

use crate::allotment::{Allotment, Choice, allot};
use crate::fill::{Draft, Fill};
use crate::model::{ModelDraft, NameOf, PathOf, ThermalModel};
use crate::plan::{
    HeatPlan, PlanError, PlanOf, conventional_drafts, drafts_seconds, follow, layers,
};
use crate::trials::try_orders;

/// Steps of the bisection that brings the printing time below its limit.
const BISECTIONS: usize = 16;

/// Options of a layer, with what the model or the proxy says about them.
pub(super) struct Options<M: ThermalModel> {
    pub(super) candidates: Vec<ModelDraft<M>>,
    /// In the order of the candidates; the cost is infinite for those that were not tried.
    pub(super) choices: Vec<Choice>,
}

impl<M: ThermalModel> Options<M> {
    /// The distinct named orders of a layer, with their times.
    pub(super) fn new(model: &M, layer: u32, orders: &[NameOf<M>], control: &Control<'_>) -> Self {
        Self::of(model, layer, candidates(model, layer, orders), control)
    }

    /// The given candidates, with their times.
    pub(super) fn of(
        model: &M,
        layer: u32,
        candidates: Vec<ModelDraft<M>>,
        control: &Control<'_>,
    ) -> Self {
        let seconds = |candidate: &ModelDraft<M>| model.path_seconds(layer, &candidate.path);
        let seconds = control.threads.map(&candidates, seconds);
        let choices =
            seconds.into_iter().map(|seconds| Choice { cost: f64::INFINITY, seconds }).collect();
        Self { candidates, choices }
    }

    /// The path of each candidate.
    pub(super) fn paths(&self) -> Vec<&PathOf<M>> {
        self.candidates.iter().map(|candidate| &candidate.path).collect()
    }
}

/// The distinct orders of a layer, each under the first name that it has; the conventional one
/// comes first.
fn candidates<M: ThermalModel>(model: &M, layer: u32, orders: &[NameOf<M>]) -> Vec<ModelDraft<M>> {
    let fill = model.fill();
    let mut seen = HashSet::new();
    let named = orders.iter().map(|&order| fill.named(layer, order));
    std::iter::once(fill.conventional(layer))
        .chain(named)
        .filter(|candidate| seen.insert(candidate.path.clone()))
        .collect()
}

/// The options of all layers, each tried from the state that the best ones before leave.
pub(super) struct Tried<M: ThermalModel> {
    pub(super) layers: Vec<Option<Options<M>>>,
    /// Layers that the model deposited.
    pub(super) deposited_layers: usize,
}

/// Lists the options of each layer, tries them on the model, and goes on from the one with the
/// lowest score.
///
/// `options` gets the state before a layer; `score` gets the cost and the time of an option.
/// Progress counts layers.
///
/// An interrupted call returns the whole plan that [`complete_interrupted`] makes of what was tried
/// by then.
pub(super) fn try_layers<M: ThermalModel>(
    model: &M,
    limit: f64,
    options: impl Fn(&M, u32) -> Result<Options<M>, PlanError>,
    score: impl Fn(f64, f64) -> f64 + Sync,
    (report, control): (impl Fn(usize), &Control<'_>),
) -> Result<Result<Tried<M>, PlanOf<M>>, PlanError> {
    let mut state = model.clone();
    let mut tried: Vec<Option<Options<M>>> = Vec::with_capacity(model.fill().layer_count());
    let mut deposited_layers = 0;
    for (layer, is_printed) in layers(model.fill()) {
        report(tried.len());
        if !is_printed {
            tried.push(None);
            continue;
        }
        let mut options = options(&state, layer)?;
        let score = |index: usize, cost: f64| score(cost, options.choices[index].seconds);
        let trials = try_orders(&state, layer, &options.paths(), 1, score, control)?;
        if let Some(reason) = trials.interrupted.or_else(|| control.interrupted()) {
            return complete_interrupted(model, &tried, limit, reason).map(Err);
        }
        deposited_layers += trials.costs.len();
        for (choice, cost) in options.choices.iter_mut().zip(&trials.costs) {
            choice.cost = cost.unwrap_or(f64::INFINITY);
        }
        if let Some(best) = trials.best.into_iter().next() {
            state = best.model;
        }
        tried.push(Some(options));
    }
    Ok(Ok(Tried { layers: tried, deposited_layers }))
}

impl<M: ThermalModel> Tried<M> {
    /// The plan of the options that are printed within `limit`, with the price of time.
    ///
    /// Layers hardly influence one another, so the costs found on the way decide which layers get
    /// faster options if the cheapest ones together take longer.
    pub(super) fn plan(
        &self,
        model: &M,
        limit: f64,
        control: &Control<'_>,
    ) -> Result<(PlanOf<M>, f64), PlanError> {
        let (drafts, price) = chosen(model, &self.layers, limit);
        let mut plan = check_time(finish(model, drafts, control)?, limit)?;
        plan.deposited_layers += self.deposited_layers;
        Ok((plan, price))
    }
}

/// One option of each layer with cells, such that the part is printed within `limit`; with the
/// price of time.
///
/// Times of options include travel from where the nozzle was when they were computed, so the whole
/// sequence may take longer than its options; the time that is distributed is then lowered by
/// bisection.
/// `None` if that finds nothing.
fn choose<M: ThermalModel>(
    model: &M,
    layers: &[Option<Options<M>>],
    limit: f64,
) -> Option<Allotment> {
    let tables: Vec<Vec<Choice>> =
        layers.iter().flatten().map(|options| options.choices.clone()).collect();
    let within = |allowed: f64| {
        allot(&tables, allowed)
            .filter(|allotment| drafts_seconds(model, &drafts(layers, &allotment.taken)) <= limit)
    };
    if let Some(allotment) = within(limit) {
        return Some(allotment);
    }
    let fastest = |options: &Vec<Choice>| {
        let known = options.iter().filter(|choice| choice.cost.is_finite());
        known.map(|choice| choice.seconds).fold(f64::INFINITY, f64::min)
    };
    let (mut low, mut high) = (tables.iter().map(fastest).sum::<f64>(), limit);
    let mut best = None;
    for _ in 0..BISECTIONS {
        let allowed = f64::midpoint(low, high);
        match within(allowed) {
            Some(allotment) => {
                best = Some(allotment);
                low = allowed;
            }
            None => high = allowed,
        }
    }
    best
}

/// The drafts of the options that are printed within `limit`, with the price of time; the
/// conventional ones, and no price, if none are found.
pub(super) fn chosen<M: ThermalModel>(
    model: &M,
    layers: &[Option<Options<M>>],
    limit: f64,
) -> (Vec<ModelDraft<M>>, f64) {
    match choose(model, layers, limit) {
        Some(allotment) => (drafts(layers, &allotment.taken), allotment.price),
        None => (conventional_drafts(model.fill()), 0.0),
    }
}

/// The drafts of the options taken.
pub(super) fn drafts<M: ThermalModel>(
    layers: &[Option<Options<M>>],
    taken: &[usize],
) -> Vec<ModelDraft<M>> {
    let mut taken = taken.iter();
    let draft = |options: &Option<Options<M>>| match options {
        Some(options) => {
            options.candidates[*taken.next().expect("one option per printed layer")].clone()
        }
        None => Draft::default(),
    };
    layers.iter().map(draft).collect()
}

/// The plan of an interrupted search: the cheapest options of the layers that were searched, and
/// the conventional order in those above; or everywhere, if that takes too long.
pub(super) fn complete_interrupted<M: ThermalModel>(
    model: &M,
    layers: &[Option<Options<M>>],
    limit: f64,
    reason: Interrupted,
) -> Result<PlanOf<M>, PlanError> {
    let taken = choose(model, layers, f64::INFINITY).map_or_else(Vec::new, |found| found.taken);
    let conventional = conventional_drafts(model.fill());
    let mut all = drafts(layers, &taken);
    all.extend_from_slice(&conventional[layers.len()..]);
    if drafts_seconds(model, &all) > limit {
        all = conventional;
    }
    let plan = follow(model, all, &Control::default())?;
    check_time(HeatPlan { stop: reason.into(), ..plan }, limit)
}

/// Deposits drafts whether or not the call is interrupted; the plan says if it was.
pub(super) fn finish<M: ThermalModel>(
    model: &M,
    drafts: Vec<ModelDraft<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    let plan = follow(model, drafts, &control.uninterrupted())?;
    Ok(HeatPlan { stop: control.interrupted().map_or(Stop::Done, Stop::from), ..plan })
}

/// The plan, if it is printed within the limit.
pub(super) fn check_time<P: Clone, N>(
    plan: HeatPlan<P, N>,
    limit: f64,
) -> Result<HeatPlan<P, N>, PlanError> {
    let fastest = plan.seconds();
    if fastest <= limit { Ok(plan) } else { Err(PlanError::TooSlow { limit, fastest }) }
}
