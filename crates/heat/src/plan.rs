//! Plans: one order per layer.

use beadwork_base::Control;
use beadwork_grid::{Cell, Region, RegionError};
use beadwork_part::Order;
use beadwork_part::slice::Voxels;
use beadwork_search::Stop;
use beadwork_thermal::simulation::DepositError;
use thiserror::Error;

use crate::model::ThermalModel;

/// One order per layer, and what the model says about them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatPlan {
    /// The layers of the part, from the bottom.
    pub layers: Vec<PlannedLayer>,
    /// Why the search ended.
    pub stop: Stop,
    /// Number of layers that the model deposited on the way.
    pub deposited_layers: usize,
}

/// The order of one layer.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedLayer {
    /// Cells in the order in which they are deposited; none if the layer is empty.
    pub cells: Vec<Cell>,
    /// Name of the order; `None` if a search made it, or the layer is empty.
    pub order: Option<Order>,
    /// Time to print the layer, s, with travel.
    pub seconds: f64,
    /// Cost of the layer.
    pub cost: f64,
}

/// Why a part cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// An order cannot be deposited.
    #[error(transparent)]
    Deposit(#[from] DepositError),
    /// The region of a layer is invalid.
    #[error("layer {layer}: {source}")]
    Region {
        /// The layer.
        layer: usize,
        /// The error.
        source: RegionError,
    },
    /// The planner needs a fast estimate of costs, which the model does not have.
    #[error("planner lines estimates the reward only: plan for reward or no_travel, or use greedy")]
    NoScreen,
    /// The planner needs a linear model of a layer, which the model does not have.
    #[error("planner smart-scan needs a linear model of each layer: use lines or greedy")]
    NotLinear,
    /// No orders meet the limit on the printing time.
    #[error(
        "printing time limit of {limit:.1} s is too short: the fastest plan that was found takes \
         {fastest:.1} s"
    )]
    TooSlow {
        /// The limit, s.
        limit: f64,
        /// Printing time of the fastest plan that was found, s.
        fastest: f64,
    },
}

impl PlannedLayer {
    /// A layer without cells.
    pub(crate) const EMPTY: Self = Self { cells: Vec::new(), order: None, seconds: 0.0, cost: 0.0 };
}

impl HeatPlan {
    /// The sum of the costs of the layers.
    pub fn cost(&self) -> f64 {
        self.layers.iter().map(|layer| layer.cost).fold(0.0, |sum, cost| sum + cost)
    }

    /// Printing time, s.
    pub fn seconds(&self) -> f64 {
        self.layers.iter().map(|layer| layer.seconds).fold(0.0, |sum, seconds| sum + seconds)
    }

    /// The cells of each layer in order.
    pub fn orders(&self) -> Vec<Vec<Cell>> {
        self.layers.iter().map(|layer| layer.cells.clone()).collect()
    }
}

/// The region of each layer; `None` for layers without cells.
pub(crate) fn regions(part: &Voxels) -> Result<Vec<Option<Region>>, PlanError> {
    let region = |layer: usize| {
        if part.cells(layer).next().is_none() {
            return Ok(None);
        }
        part.region(layer).map(Some).map_err(|source| PlanError::Region { layer, source })
    };
    (0..part.depth).map(region).collect()
}

/// A layer before it is deposited.
#[derive(Clone, Debug, Default)]
pub(crate) struct Draft {
    pub(crate) cells: Vec<Cell>,
    pub(crate) order: Option<Order>,
}

/// Printing time of the given layers, s.
pub(crate) fn drafts_seconds<M: ThermalModel>(model: &M, drafts: &[Draft]) -> f64 {
    let mut from = model.last_cell();
    let mut seconds = 0.0;
    for (layer, Draft { cells, .. }) in (0..).zip(drafts) {
        seconds += crate::model::order_seconds(model.part(), model.process(), layer, from, cells);
        from = cells.last().copied().or(from);
    }
    seconds
}

/// Deposits the given layers.
pub(crate) fn follow<M: ThermalModel>(
    model: &M,
    drafts: Vec<Draft>,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    let mut model = model.clone();
    let mut layers = Vec::with_capacity(drafts.len());
    let own = control.without_progress();
    let total = drafts.len();
    for (layer, Draft { cells, order }) in (0..).zip(drafts) {
        let seconds = model.order_seconds(layer, &cells);
        let cost = if cells.is_empty() { 0.0 } else { model.deposit(layer, &cells, &own)? };
        layers.push(PlannedLayer { cells, order, seconds, cost });
        control.report(layers.len(), total);
    }
    Ok(HeatPlan { layers, stop: Stop::Done, deposited_layers: total })
}

/// The plan that prints every layer in the same named order.
///
/// Progress counts layers.
pub fn same_order<M: ThermalModel>(
    model: &M,
    order: Order,
    control: &Control<'_>,
) -> Result<HeatPlan, PlanError> {
    follow(model, same_order_drafts(order, &regions(model.part())?), control)
}

/// The same named order in every layer that has cells.
pub(crate) fn same_order_drafts(order: Order, regions: &[Option<Region>]) -> Vec<Draft> {
    let draft = |region: &Option<Region>| match region {
        Some(region) => Draft { cells: order.order(region), order: Some(order) },
        None => Draft::default(),
    };
    regions.iter().map(draft).collect()
}
