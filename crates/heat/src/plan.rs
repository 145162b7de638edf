//! Plans: one order per layer.

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::Order;
use beadwork_search::Stop;
use beadwork_thermal::simulation::DepositError;
use thiserror::Error;

use crate::fill::{Draft, DraftOf, Fill};
use crate::model::{ModelDraft, NameOf, PathOf, ThermalModel};

/// One order per layer, and what the model says about them.
///
/// By default, it is a plan of cells; `P` and `N` are [`Fill::Path`] and [`Fill::Name`].
#[derive(Clone, Debug, PartialEq)]
pub struct HeatPlan<P = Vec<Cell>, N = Order> {
    /// The layers of the part, from the bottom.
    pub layers: Vec<PlannedLayer<P, N>>,
    /// Why the search ended.
    pub stop: Stop,
    /// Number of layers that the model deposited on the way.
    pub deposited_layers: usize,
}

/// The order of one layer.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedLayer<P = Vec<Cell>, N = Order> {
    /// All of the layer, such as its cells, in the order in which it is deposited; nothing if the
    /// layer is empty.
    pub path: P,
    /// Name of the order; `None` if a search made it, or the layer is empty.
    pub order: Option<N>,
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

/// The plan of a model's fill.
pub type PlanOf<M> = HeatPlan<PathOf<M>, NameOf<M>>;

impl<P: Default, N> PlannedLayer<P, N> {
    /// A layer without voxels.
    pub fn empty() -> Self {
        Self { path: P::default(), order: None, seconds: 0.0, cost: 0.0 }
    }
}

impl<P: Clone, N> HeatPlan<P, N> {
    /// The sum of the costs of the layers.
    pub fn cost(&self) -> f64 {
        self.layers.iter().map(|layer| layer.cost).fold(0.0, |sum, cost| sum + cost)
    }

    /// Printing time, s.
    pub fn seconds(&self) -> f64 {
        self.layers.iter().map(|layer| layer.seconds).fold(0.0, |sum, seconds| sum + seconds)
    }

    /// The path of each layer.
    pub fn paths(&self) -> Vec<P> {
        self.layers.iter().map(|layer| layer.path.clone()).collect()
    }
}

/// The numbers of the layers, each with whether it has voxels.
pub(crate) fn layers<F: Fill>(fill: &F) -> impl ExactSizeIterator<Item = (u32, bool)> {
    (0..fill.layer_count() as u32).map(|layer| (layer, fill.voxel_count(layer) > 0))
}

/// Number of layers that have voxels.
pub(crate) fn printed_layers<F: Fill>(fill: &F) -> usize {
    layers(fill).filter(|&(_, is_printed)| is_printed).count()
}

/// Printing time of the given layers, s.
pub(crate) fn drafts_seconds<M: ThermalModel>(model: &M, drafts: &[ModelDraft<M>]) -> f64 {
    let fill = model.fill();
    let mut from = model.position();
    let mut seconds = 0.0;
    for (layer, Draft { path, .. }) in (0..).zip(drafts) {
        seconds += fill.seconds(layer, from, path);
        from = fill.ends(layer, path).map(|[_, end]| end).or(from);
    }
    seconds
}

/// Deposits the given layers.
pub(crate) fn follow<M: ThermalModel>(
    model: &M,
    drafts: Vec<ModelDraft<M>>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    let mut model = model.clone();
    let mut layers = Vec::with_capacity(drafts.len());
    let own = control.without_progress();
    let total = drafts.len();
    for (layer, Draft { path, name }) in (0..).zip(drafts) {
        let (mut seconds, mut cost) = (0.0, 0.0);
        if model.fill().voxel_count(layer) > 0 {
            seconds = model.path_seconds(layer, &path);
            cost = model.deposit(layer, &path, &own)?;
        }
        layers.push(PlannedLayer { path, order: name, seconds, cost });
        control.report(layers.len(), total);
    }
    Ok(HeatPlan { layers, stop: Stop::Done, deposited_layers: total })
}

/// The plan that prints every layer in the same named order.
///
/// Progress counts layers.
pub fn same_order<M: ThermalModel>(
    model: &M,
    order: NameOf<M>,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    follow(model, same_order_drafts(model.fill(), order), control)
}

/// The same named order in every layer that has voxels.
pub(crate) fn same_order_drafts<F: Fill>(fill: &F, order: F::Name) -> Vec<DraftOf<F>> {
    drafts_of(fill, |layer| fill.named(layer, order))
}

/// The conventional order of every layer.
pub fn conventional<M: ThermalModel>(
    model: &M,
    control: &Control<'_>,
) -> Result<PlanOf<M>, PlanError> {
    follow(model, conventional_drafts(model.fill()), control)
}

/// The conventional order of every layer that has voxels.
pub(crate) fn conventional_drafts<F: Fill>(fill: &F) -> Vec<DraftOf<F>> {
    drafts_of(fill, |layer| fill.conventional(layer))
}

fn drafts_of<F: Fill>(fill: &F, draft: impl Fn(u32) -> DraftOf<F>) -> Vec<DraftOf<F>> {
    layers(fill)
        .map(|(layer, is_printed)| if is_printed { draft(layer) } else { Draft::default() })
        .collect()
}
