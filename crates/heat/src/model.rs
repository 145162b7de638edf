//! What planners try orders on: the heat equation, or whatever predicts its result.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use beadwork_thermal::event::layer_events;
use beadwork_thermal::objective::{self, HeatMeasures, HeatMeter, Objective, Weighted};
use beadwork_thermal::simulation::{DepositError, Method, SetupError};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use thiserror::Error;

use crate::proxy::{LayerProxy, LinearLayer};

/// A print that advances by one layer at a time, and what each layer costs.
///
/// The cost of a plan is the sum of the costs of its layers.
/// Planners clone a model to try several orders of a layer from one state, so clones must be cheap
/// and independent.
/// [`Solver`] is the model that solves the heat equation; a network that predicts temperatures can
/// take its place.
pub trait ThermalModel: Clone + Send + Sync {
    /// What ranks many orders before the model decides between the best.
    type Screen: Screen;

    /// The part that is printed.
    fn part(&self) -> &Voxels;

    /// The parameters of the print, which say how long orders take.
    fn process(&self) -> &ProcessParameters;

    /// The last cell that was deposited, where the nozzle is; `None` before the first.
    fn last_cell(&self) -> Option<Cell>;

    /// Deposits all cells of a layer in the given order, and returns the cost of the layer: 0 or
    /// more.
    ///
    /// Progress counts deposition events.
    /// After an interruption, the state is unspecified.
    fn deposit(
        &mut self,
        layer: u32,
        order: &[Cell],
        control: &Control<'_>,
    ) -> Result<f64, DepositError>;

    /// A fast estimate of the cost of orders of a layer, from the present state; `None` if there is
    /// none for these costs.
    fn screen(&self, layer: u32) -> Option<Self::Screen>;

    /// A linear model of a layer, from the present state; `None` if there is none.
    fn linear_layer(&self, _layer: u32) -> Option<LinearLayer> {
        None
    }

    /// Time that depositing a layer in the given order would take now, travel included, s.
    ///
    /// Linear in the order's length.
    fn order_seconds(&self, layer: u32, order: &[Cell]) -> f64 {
        order_seconds(self.part(), self.process(), layer, self.last_cell(), order)
    }
}

/// A fast estimate of the costs of orders of one layer, to rank them by.
pub trait Screen: Send + Sync {
    /// Estimated cost of an order.
    fn cost(&self, order: &[Cell]) -> f64;
}

/// Time to deposit a layer in the given order, s, with travel from `from`, the last cell that was
/// deposited before.
///
/// Linear in the order's length.
pub fn order_seconds(
    part: &Voxels,
    process: &ProcessParameters,
    layer: u32,
    from: Option<Cell>,
    order: &[Cell],
) -> f64 {
    let events = layer_events(order, layer, from, &part.frame, process);
    events.iter().map(|event| event.seconds).sum()
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

    fn factor(&self, objective: Objective) -> f64 {
        let terms = self.terms.iter().filter(|&&(term, _)| term == objective);
        terms.fold(0.0, |sum, &(_, factor)| sum + factor)
    }

    fn has(&self, objectives: &[Objective]) -> bool {
        objectives.iter().any(|&objective| self.factor(objective) > 0.0)
    }
}

/// The heat equation as a model.
#[derive(Clone, Debug)]
pub struct Solver {
    /// The print; `None` if only the one without travel counts.
    print: Option<Simulation>,
    /// The print without travel, if it counts.
    no_travel: Option<Simulation>,
    /// Measures of the print over time, if they count.
    meter: Option<HeatMeter>,
    part: Arc<Voxels>,
    material: Arc<ThermalMaterial>,
    process: Arc<ProcessParameters>,
    last: Option<Cell>,
    cost: Arc<LayerCost>,
}

impl Solver {
    /// A print of which nothing is deposited yet.
    ///
    /// [`Objective::NoTravel`] beside any other takes a second simulation; measures over time take
    /// some 30 % more time, as they are sampled at the ends of the longest steps.
    pub fn new(
        part: Arc<Voxels>,
        material: &ThermalMaterial,
        process: &ProcessParameters,
        method: Method,
        cost: LayerCost,
    ) -> Result<Self, SetupError> {
        use Objective::{NoTravel, Peak, Reward, TimeAveraged};
        let simulation =
            |process: &ProcessParameters| Simulation::new(part.clone(), material, process, method);
        let print = cost.has(&[Reward, TimeAveraged, Peak]);
        let print = print.then(|| simulation(process)).transpose()?;
        let without_travel = ProcessParameters { travel_mm_s: None, ..process.clone() };
        let no_travel = cost.has(&[NoTravel]).then(|| simulation(&without_travel)).transpose()?;
        let meter =
            |print: &Simulation| HeatMeter::new(print, material, objective::Settings::default());
        let meter = print.as_ref().filter(|_| cost.has(&[TimeAveraged, Peak])).map(meter);
        Ok(Self {
            print,
            no_travel,
            meter,
            part,
            material: Arc::new(material.clone()),
            process: Arc::new(process.clone()),
            last: None,
            cost: Arc::new(cost),
        })
    }

    /// The simulation of the print; that without travel if the costs need no other.
    pub fn simulation(&self) -> &Simulation {
        self.print.as_ref().or(self.no_travel.as_ref()).expect("one of the two is simulated")
    }
}

/// The proxy of a layer as a screen.
///
/// It estimates the deviation at the layer's end.
/// Where both the reward and the reward without travel count, travel takes a part of its time.
#[derive(Clone, Debug)]
pub struct ProxyScreen {
    proxy: LayerProxy,
    layer: u32,
    from: Option<Cell>,
    frame: Frame,
    process: ProcessParameters,
    factor: f64,
}

impl Screen for ProxyScreen {
    fn cost(&self, order: &[Cell]) -> f64 {
        let events = layer_events(order, self.layer, self.from, &self.frame, &self.process);
        self.factor * self.proxy.end_std_c(&events)
    }
}

/// Deviation of all temperatures, K.
fn deviation(simulation: &Simulation) -> f64 {
    simulation.statistics().map_or(0.0, |all| all.std_c)
}

/// Deposits a layer with the given share of the part's voxels, and returns what it costs.
fn print_cost(
    print: &mut Simulation,
    meter: Option<&mut HeatMeter>,
    cost: &LayerCost,
    share: f64,
    layer: u32,
    order: &[Cell],
    control: &Control<'_>,
) -> Result<f64, DepositError> {
    let mut over_time = 0.0;
    match meter {
        None => {
            print.deposit(layer, order, control)?;
        }
        Some(meter) => {
            let heat = meter.deposit(print, layer, order, control)?;
            over_time += cost.factor(Objective::TimeAveraged) * heat.mean_std_c * share;
            if layer > 0 {
                over_time += cost.factor(Objective::Peak) * heat.max_std_c;
            }
        }
    }
    Ok(over_time + cost.factor(Objective::Reward) * deviation(print))
}

impl ThermalModel for Solver {
    type Screen = ProxyScreen;

    fn part(&self) -> &Voxels {
        &self.part
    }

    fn process(&self) -> &ProcessParameters {
        &self.process
    }

    fn last_cell(&self) -> Option<Cell> {
        self.last
    }

    fn deposit(
        &mut self,
        layer: u32,
        order: &[Cell],
        control: &Control<'_>,
    ) -> Result<f64, DepositError> {
        let share = order.len() as f64 / self.part.count() as f64;
        let Self { print, no_travel, meter, cost, .. } = self;
        let of_print = || -> Result<f64, DepositError> {
            match print {
                None => Ok(0.0),
                Some(print) => {
                    print_cost(print, meter.as_mut(), cost, share, layer, order, control)
                }
            }
        };
        let of_no_travel = || -> Result<f64, DepositError> {
            match no_travel {
                None => Ok(0.0),
                Some(no_travel) => {
                    no_travel.deposit(layer, order, &control.without_progress())?;
                    Ok(cost.factor(Objective::NoTravel) * deviation(no_travel))
                }
            }
        };
        let (of_print, of_no_travel) = control.threads.join(of_print, of_no_travel);
        let cost = of_print? + of_no_travel?;
        self.last = order.last().copied().or(self.last);
        Ok(cost)
    }

    fn linear_layer(&self, layer: u32) -> Option<LinearLayer> {
        Some(LinearLayer::new(self.simulation(), layer, &self.material))
    }

    fn screen(&self, layer: u32) -> Option<ProxyScreen> {
        let (reward, no_travel) =
            (self.cost.factor(Objective::Reward), self.cost.factor(Objective::NoTravel));
        let factor = reward + no_travel;
        let speed = |speed: f64| (reward > 0.0).then(|| speed * factor / reward);
        (factor > 0.0).then(|| ProxyScreen {
            proxy: LayerProxy::new(self.simulation(), layer, &self.material),
            layer,
            from: self.last,
            frame: self.part.frame,
            process: ProcessParameters {
                travel_mm_s: self.process.travel_mm_s.and_then(speed),
                ..(*self.process).clone()
            },
            factor,
        })
    }
}
