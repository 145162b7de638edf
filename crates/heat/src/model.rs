//! What planners try orders on: the heat equation, or whatever predicts its result.

use beadwork_base::Control;
use beadwork_thermal::objective::{HeatMeasures, Objective, Weighted};
use beadwork_thermal::simulation::DepositError;
use thiserror::Error;

use crate::fill::{DraftOf, Fill};
use crate::proxy::LinearLayer;

pub use crate::solver::{ModelError, ProxyScreen, Solver};

/// A print that advances by one layer at a time, and what each layer costs.
///
/// The cost of a plan is the sum of the costs of its layers.
/// Planners clone a model to try several orders of a layer from one state, so clones must be cheap
/// and independent.
/// [`Solver`] is the model that solves the heat equation; a network that predicts temperatures can
/// take its place.
pub trait ThermalModel: Clone + Send + Sync {
    /// What the layers are printed from.
    type Fill: Fill;

    /// What ranks many orders before the model decides between the best.
    type Screen: Screen<PathOf<Self>>;

    /// What the layers are printed from, and how long that takes.
    fn fill(&self) -> &Self::Fill;

    /// Where the nozzle is; `None` before the first layer.
    fn position(&self) -> Option<PositionOf<Self>>;

    /// Prints a layer, and returns what it costs: 0 or more.
    ///
    /// Progress counts deposition events.
    /// After an interruption, the state is unspecified.
    fn deposit(
        &mut self,
        layer: u32,
        path: &PathOf<Self>,
        control: &Control<'_>,
    ) -> Result<f64, DepositError>;

    /// Prints some lines of a layer: the first ones, or those after them.
    ///
    /// For the last lines, it returns a cost by which orders of them can be compared: that of the
    /// layer but for a constant.
    ///
    /// Otherwise as [`ThermalModel::deposit`].
    fn deposit_lines(
        &mut self,
        layer: u32,
        path: &PathOf<Self>,
        control: &Control<'_>,
    ) -> Result<f64, DepositError>;

    /// A fast estimate of the cost of orders of a layer, from the present state; `None` if there is
    /// none for these costs.
    fn screen(&self, layer: u32) -> Option<Self::Screen>;

    /// A linear model of a layer, from the present state; `None` if there is none.
    fn linear_layer(&self, _layer: u32) -> Option<LinearLayer> {
        None
    }

    /// Time that printing a layer would take now, travel included, s.
    ///
    /// Linear in the path's length.
    fn path_seconds(&self, layer: u32, path: &PathOf<Self>) -> f64 {
        self.fill().seconds(layer, self.position(), path)
    }
}

/// The path of a layer of a model's fill.
pub type PathOf<M> = <<M as ThermalModel>::Fill as Fill>::Path;

/// The name of an order of a model's fill.
pub type NameOf<M> = <<M as ThermalModel>::Fill as Fill>::Name;

/// A position of the nozzle in a model's fill.
pub type PositionOf<M> = <<M as ThermalModel>::Fill as Fill>::Position;

/// A draft of a layer of a model's fill.
pub(crate) type ModelDraft<M> = DraftOf<<M as ThermalModel>::Fill>;

/// A fast estimate of the costs of orders of one layer, to rank them by.
pub trait Screen<P>: Send + Sync {
    /// Estimated cost of a path.
    fn cost(&self, path: &P) -> f64;
}

/// What a layer costs: a weighted sum of objectives that are sums over layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerCost {
    /// Each objective with the factor that its measure is multiplied by.
    terms: Vec<(Objective, f64)>,
}

/// Why a layer has no such cost.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LayerCostError {
    /// The objective is not a sum over layers.
    #[error(
        "objective {0} is known only for a whole print: plan for reward, no_travel, time_averaged \
         or peak"
    )]
    Whole(Objective),
    /// The baseline does not have the objective, or it is 0.
    #[error("objective {0} is unknown or 0 for the conventional plan, so nothing compares to it")]
    Baseline(Objective),
}

impl LayerCost {
    /// The cost of a layer is, in K:
    /// - [`Objective::Reward`]: the deviation at its end;
    /// - [`Objective::NoTravel`]: the same, if travel took no time;
    /// - [`Objective::TimeAveraged`]: the mean deviation while it is printed, times its share of
    ///   the part's voxels, so that slow orders do not gain or lose by the time they take;
    /// - [`Objective::Peak`]: the maximum deviation while it is printed; 0 for the first layer.
    ///
    /// # Errors
    /// For [`Objective::Warpage`], which is not a sum over layers.
    pub fn of(objective: Objective) -> Result<Self, LayerCostError> {
        Self::new(vec![(objective, 1.0)])
    }

    /// The weighted sum of these costs, each divided by that of a baseline: the plan whose measures
    /// are `baseline` costs about the sum of the weights.
    pub fn relative(
        objectives: &Weighted,
        baseline: &HeatMeasures,
    ) -> Result<Self, LayerCostError> {
        let term = |&(objective, weight): &(Objective, f64)| {
            let cost = objective.cost(baseline).filter(|&cost| cost > 0.0);
            Ok((objective, weight / cost.ok_or(LayerCostError::Baseline(objective))?))
        };
        let used = objectives.terms().iter().filter(|&&(_, weight)| weight > 0.0);
        Self::new(used.map(term).collect::<Result<_, _>>()?)
    }

    fn new(terms: Vec<(Objective, f64)>) -> Result<Self, LayerCostError> {
        match terms.iter().find(|&&(objective, _)| objective == Objective::Warpage) {
            Some(&(objective, _)) => Err(LayerCostError::Whole(objective)),
            None => Ok(Self { terms }),
        }
    }

    /// What the measure of an objective is multiplied by.
    pub(crate) fn factor(&self, objective: Objective) -> f64 {
        let terms = self.terms.iter().filter(|&&(term, _)| term == objective);
        terms.fold(0.0, |sum, &(_, factor)| sum + factor)
    }

    /// Whether one of the objectives counts.
    pub(crate) fn has(&self, objectives: &[Objective]) -> bool {
        objectives.iter().any(|&objective| self.factor(objective) > 0.0)
    }
}
