//! What planners have in common.

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Cell, Region};
use beadwork_part::Order;
use beadwork_search::Stop;

use crate::allotment::{Allotment, Choice, allot};
use crate::candidates::candidates;
use crate::model::ThermalModel;
use crate::plan::{Draft, HeatPlan, PlanError, drafts_seconds, follow, same_order_drafts};
use crate::trials::try_orders;

/// Steps of the bisection that brings the printing time below its limit.
const BISECTIONS: usize = 16;

/// Options of a layer, with what the model or the proxy says about them.
pub(super) struct Options {
    pub(super) candidates: Vec<Draft>,
    /// In the order of the candidates; the cost is infinite for those that were not tried.
    pub(super) choices: Vec<Choice>,
}

impl Options {
    /// The distinct named orders of a layer, with their times.
    pub(super) fn new<M: ThermalModel>(
        model: &M,
        layer: u32,
        region: &Region,
        orders: &[Order],
        control: &Control<'_>,
    ) -> Self {
        Self::of(model, layer, candidates(orders, region), control)
    }

    /// The given candidates, with their times.
    pub(super) fn of<M: ThermalModel>(
        model: &M,
        layer: u32,
        candidates: Vec<Draft>,
        control: &Control<'_>,
    ) -> Self {
        let seconds = |candidate: &Draft| model.order_seconds(layer, &candidate.cells);
        let seconds = control.threads.map(&candidates, seconds);
        let choices =
            seconds.into_iter().map(|seconds| Choice { cost: f64::INFINITY, seconds }).collect();
        Self { candidates, choices }
    }

    /// The cells of each candidate.
    pub(super) fn cells(&self) -> Vec<&[Cell]> {
        self.candidates.iter().map(|candidate| &candidate.cells[..]).collect()
    }

    /// The draft of a candidate.
    pub(super) fn draft(&self, index: usize) -> Draft {
        self.candidates[index].clone()
    }
}

/// The options of all layers, each tried from the state that the best ones before leave.
pub(super) struct Tried {
    pub(super) layers: Vec<Option<Options>>,
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
    regions: &[Option<Region>],
    limit: f64,
    options: impl Fn(&M, u32, &Region) -> Result<Options, PlanError>,
    score: impl Fn(f64, f64) -> f64 + Sync,
    (report, control): (impl Fn(usize), &Control<'_>),
) -> Result<Result<Tried, HeatPlan>, PlanError> {
    let mut state = model.clone();
    let mut layers: Vec<Option<Options>> = Vec::with_capacity(regions.len());
    let mut deposited_layers = 0;
    for (layer, region) in (0..).zip(regions) {
        report(layers.len());
        let Some(region) = region else {
            layers.push(None);
            continue;
        };
        let mut options = options(&state, layer, region)?;
        let score = |index: usize, cost: f64| score(cost, options.choices[index].seconds);
        let trials = try_orders(&state, layer, &options.cells(), 1, score, control)?;
        if let Some(reason) = trials.interrupted.or_else(|| control.interrupted()) {
            return complete_interrupted(model, &layers, regions, limit, reason).map(Err);
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
    Ok(Ok(Tried { layers, deposited_layers }))
}

impl Tried {
    /// The plan of the options that are printed within `limit`, with the price of time.
    ///
    /// Layers hardly influence one another, so the costs found on the way decide which layers get
    /// faster options if the cheapest ones together take longer.
    pub(super) fn plan<M: ThermalModel>(
        &self,
        model: &M,
        regions: &[Option<Region>],
        limit: f64,
        control: &Control<'_>,
    ) -> Result<(HeatPlan, f64), PlanError> {
        let (drafts, price) = chosen(model, &self.layers, regions, limit);
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
fn choose<M: ThermalModel>(model: &M, layers: &[Option<Options>], limit: f64) -> Option<Allotment> {
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
    layers: &[Option<Options>],
    regions: &[Option<Region>],
    limit: f64,
) -> (Vec<Draft>, f64) {
    match choose(model, layers, limit) {
        Some(allotment) => (drafts(layers, &allotment.taken), allotment.price),
        None => (conventional(regions), 0.0),
    }
}

/// The drafts of the options taken.
pub(super) fn drafts(layers: &[Option<Options>], taken: &[usize]) -> Vec<Draft> {
    let mut taken = taken.iter();
    let draft = |options: &Option<Options>| match options {
        Some(options) => options.draft(*taken.next().expect("one option per layer with cells")),
        None => Draft::default(),
    };
    layers.iter().map(draft).collect()
}

/// The conventional order of every layer.
pub(super) fn conventional(regions: &[Option<Region>]) -> Vec<Draft> {
    same_order_drafts(Order::CONVENTIONAL, regions)
}

/// The plan of an interrupted search: the cheapest options of the layers that were searched, and
/// the conventional order in those above; or everywhere, if that takes too long.
pub(super) fn complete_interrupted<M: ThermalModel>(
    model: &M,
    layers: &[Option<Options>],
    regions: &[Option<Region>],
    limit: f64,
    reason: Interrupted,
) -> Result<HeatPlan, PlanError> {
    let taken = choose(model, layers, f64::INFINITY).map_or_else(Vec::new, |found| found.taken);
    let mut all = drafts(layers, &taken);
    all.extend(conventional(&regions[layers.len()..]));
    if drafts_seconds(model, &all) > limit {
        all = conventional(regions);
    }
    let plan = follow(model, all, &Control::default())?;
    check_time(HeatPlan { stop: reason.into(), ..plan }, limit)
}

/// Deposits drafts whether or not the call is interrupted; the plan says if it was.
pub(super) fn finish<M: ThermalModel>(
    model: &M,
    drafts: Vec<Draft>,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    let plan = follow(model, drafts, &control.uninterrupted())?;
    Ok(HeatPlan { stop: control.interrupted().map_or(Stop::Done, Stop::from), ..plan })
}

/// The plan, if it is printed within the limit.
pub(super) fn check_time(plan: HeatPlan, limit: f64) -> Result<HeatPlan, PlanError> {
    let fastest = plan.seconds();
    if fastest <= limit { Ok(plan) } else { Err(PlanError::TooSlow { limit, fastest }) }
}
