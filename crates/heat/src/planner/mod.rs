//! Planners: how the order of each layer is chosen.

mod anneal;
mod beam;
mod constant;
mod greedy;
mod lines;
mod refine;
mod setup;
mod shortlist;
mod smart_scan;

use beadwork_base::{Control, named_enum};
use beadwork_part::Order;

use crate::fill::{Draft, Fill, OrderName};
use crate::model::{ModelDraft, NameOf, PathOf, ThermalModel};
use crate::plan::{HeatPlan, PlanError, PlanOf, PlannedLayer, conventional_drafts};

pub use self::anneal::Annealing;
use self::refine::Refinement;

/// How the orders of the layers are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Planner {
    /// The conventional order in every layer.
    Conventional,
    /// The same order in every layer: the best one for the whole part.
    Constant,
    /// Layer by layer, the best order now.
    Greedy,
    /// The best of several sequences of orders, which are extended layer by layer.
    Beam,
    /// Whole lines, of which each next one is that after which a reduced linear model of the layer
    /// is most even: SmartScan (Ramani et al. 2022), for comparison.
    ///
    /// Both axes are tried, and the conventional order takes the layers for which the limit on the
    /// printing time leaves no more.
    SmartScan,
    /// Orders of lines: a proxy picks candidates, the model decides, and the order of the lines is
    /// annealed.
    Lines,
}

named_enum! {
    Planner, "planner":
    Conventional = "conventional",
    Constant = "constant",
    Greedy = "greedy",
    Beam = "beam",
    SmartScan = "smart-scan",
    Lines = "lines",
}

/// How a part is planned.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings<N = Order> {
    /// How orders are chosen.
    pub planner: Planner,
    /// The named orders to choose from; the conventional one is always added.
    pub orders: Vec<N>,
    /// Maximum printing time of the whole part, s, with travel; infinite for none.
    pub max_seconds: f64,
    /// Sequences that [`Planner::Beam`] keeps, at least 1.
    pub beam_width: usize,
    /// Orders of a layer that [`Planner::Lines`] tries on the model beside the conventional one:
    /// the most promising by its screen.
    /// At least 1.
    pub screened: usize,
    /// How [`Planner::Lines`] improves the order of the lines of each layer; `None` leaves it as it
    /// is.
    pub annealing: Option<Annealing>,
    /// Seed of all random choices.
    pub seed: u64,
}

impl<N: OrderName> Default for Settings<N> {
    /// `lines` with all named orders, annealing, and no limit on the printing time.
    fn default() -> Self {
        Self {
            planner: Planner::Lines,
            orders: N::all(),
            max_seconds: f64::INFINITY,
            beam_width: 8,
            screened: 4,
            annealing: Some(Annealing::default()),
            seed: 0,
        }
    }
}

/// Plans a part: chooses the order of each layer.
///
/// `model` is a print of which nothing is deposited yet.
/// The result is the same on any number of threads.
/// Progress counts layers.
///
/// # Interruption
/// Layers that were not planned by then are printed in the conventional order, and
/// [`HeatPlan::stop`] says why; the call still deposits each of them once.
///
/// # Errors
/// [`PlanError::TooSlow`] if no plan within the limit on the printing time is found.
/// The conventional plan is always found.
///
/// # Panics
/// If a setting that must be at least 1 is 0.
pub fn plan<M: ThermalModel>(
    model: &M,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    match settings.planner {
        Planner::Conventional => {
            let drafts = conventional_drafts(model.fill());
            setup::check_time(setup::finish(model, drafts, control)?, settings.max_seconds)
        }
        Planner::Constant => constant::solve(model, settings, control),
        Planner::Greedy => greedy::solve(model, settings, control),
        Planner::Beam => beam::solve(model, settings, control),
        Planner::SmartScan => smart_scan::solve(model, settings, control),
        Planner::Lines => lines::solve(model, settings, control),
    }
}

/// Anneals the lines of each layer of a plan of the same part, as [`Planner::Lines`] does last.
///
/// Layers with a named order of lines begin from it, others from a golden order; a layer keeps its
/// order if nothing cheaper is found, and so does the plan, whose costs must be the model's.
/// Lower layers may use all the time that the plan leaves of the limit.
/// Of the settings it uses the limit, the annealing and the seed; without annealing, it returns the
/// plan.
///
/// # Errors
/// [`PlanError::TooSlow`] if the plan exceeds the limit, and [`PlanError::NoScreen`] if the model
/// has no fast estimate of costs.
pub fn refine<M: ThermalModel>(
    model: &M,
    plan: &PlanOf<M>,
    settings: &Settings<NameOf<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    let Settings { max_seconds, seed, .. } = *settings;
    setup::check_time(plan.clone(), max_seconds)?;
    let Some(annealing) = &settings.annealing else { return Ok(plan.clone()) };
    let draft = |layer: &PlannedLayer<PathOf<M>, NameOf<M>>| Draft {
        path: layer.path.clone(),
        name: layer.order,
    };
    let drafts: Vec<ModelDraft<M>> = plan.layers.iter().map(draft).collect();
    let refinement = Refinement { model, annealing, price: 0.0, max_seconds, seed };
    let report = |done: usize| control.report(done, model.fill().layer_count());
    let refined = refinement.run(&drafts, report, &control.without_progress())?;
    // What is cheaper in a layer may cost more above it, and times that are summed in another order
    // are rounded differently.
    let is_better = refined.cost() <= plan.cost() && refined.seconds() <= max_seconds;
    Ok(if is_better { refined } else { HeatPlan { stop: refined.stop, ..plan.clone() } })
}

#[cfg(test)]
mod tests;
