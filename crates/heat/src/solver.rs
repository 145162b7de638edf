//! The heat equation as a model.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_thermal::objective::{self, HeatMeter, Objective};
use beadwork_thermal::simulation::{DepositError, Method, SetupError};
use beadwork_thermal::{DepositionEvent, ProcessParameters, Simulation, ThermalMaterial};
use thiserror::Error;

use crate::fill::{Cells, CellsError, Fill};
use crate::model::{LayerCost, Screen, ThermalModel};
use crate::proxy::{LayerProxy, LinearLayer};

/// The heat equation as a model.
#[derive(Clone, Debug)]
pub struct Solver<F: Fill = Cells> {
    /// The print; `None` if only the one without travel counts.
    print: Option<Simulation>,
    /// The print without travel, if it counts.
    no_travel: Option<Simulation>,
    /// Measures of the print over time, if they count.
    meter: Option<HeatMeter>,
    fill: Arc<F>,
    part: Arc<Voxels>,
    /// Number of the part's voxels.
    part_voxels: usize,
    material: Arc<ThermalMaterial>,
    process: Arc<ProcessParameters>,
    position: Option<F::Position>,
    cost: Arc<LayerCost>,
}

/// Error of [`Solver::new`].
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// The simulation cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A layer cannot be planned.
    #[error(transparent)]
    Cells(#[from] CellsError),
}

impl Solver {
    /// A print of cells of which nothing is deposited yet.
    ///
    /// [`Objective::NoTravel`] beside any other takes a second simulation; measures over time take
    /// some 30 % more time, as they are sampled at the ends of the longest steps.
    pub fn new(
        part: Arc<Voxels>,
        material: &ThermalMaterial,
        process: &ProcessParameters,
        method: Method,
        cost: LayerCost,
    ) -> Result<Self, ModelError> {
        let cells = Cells::new(&part, process)?;
        Ok(Self::of_fill(cells, part, material, process, method, cost)?)
    }

    /// The last cell that was deposited, where the nozzle is; `None` before the first.
    pub fn last_cell(&self) -> Option<Cell> {
        self.position
    }
}

impl<F: Fill> Solver<F> {
    /// As [`Solver::new`], for layers of any kind; `part` has the voxels that they deposit.
    pub fn of_fill(
        fill: F,
        part: Arc<Voxels>,
        material: &ThermalMaterial,
        process: &ProcessParameters,
        method: Method,
        cost: LayerCost,
    ) -> Result<Self, SetupError> {
        use Objective::{NoTravel, Peak, Reward, TimeAveraged};
        let simulation = || Simulation::new(part.clone(), material, process, method);
        let print = cost.has(&[Reward, TimeAveraged, Peak]).then(simulation).transpose()?;
        let no_travel = cost.has(&[NoTravel]).then(simulation).transpose()?;
        let meter =
            |print: &Simulation| HeatMeter::new(print, material, objective::Settings::default());
        let meter = print.as_ref().filter(|_| cost.has(&[TimeAveraged, Peak])).map(meter);
        Ok(Self {
            print,
            no_travel,
            meter,
            fill: Arc::new(fill),
            part_voxels: part.count(),
            part,
            material: Arc::new(material.clone()),
            process: Arc::new(process.clone()),
            position: None,
            cost: Arc::new(cost),
        })
    }

    /// The simulation of the print; that without travel if the costs need no other.
    pub fn simulation(&self) -> &Simulation {
        self.print.as_ref().or(self.no_travel.as_ref()).expect("one of the two is simulated")
    }

    /// Runs through the events of a path, and returns what they cost.
    fn run(
        &mut self,
        layer: u32,
        path: &F::Path,
        events: Vec<DepositionEvent>,
        control: &Control<'_>,
    ) -> Result<f64, DepositError> {
        let voxels = events.iter().filter(|event| event.voxel.is_some()).count();
        let share = voxels as f64 / self.part_voxels as f64;
        let Self { print, no_travel, meter, cost, .. } = self;
        let still = no_travel.as_ref().map(|_| {
            let mut events = events.clone();
            remove_pauses(&mut events);
            events
        });
        let of_print = || -> Result<f64, DepositError> {
            match print {
                None => Ok(0.0),
                Some(print) => {
                    print_cost(print, meter.as_mut(), cost, share, layer, events, control)
                }
            }
        };
        let of_no_travel = || -> Result<f64, DepositError> {
            match no_travel.as_mut().zip(still) {
                None => Ok(0.0),
                Some((no_travel, events)) => {
                    no_travel.run(&events, &control.without_progress())?;
                    Ok(cost.factor(Objective::NoTravel) * deviation(no_travel))
                }
            }
        };
        let (of_print, of_no_travel) = control.threads.join(of_print, of_no_travel);
        let cost = of_print? + of_no_travel?;
        self.position = self.fill.ends(layer, path).map(|[_, end]| end).or(self.position);
        Ok(cost)
    }

    /// The part that is printed.
    pub fn part(&self) -> &Voxels {
        &self.part
    }

    /// The parameters of the print.
    pub fn process(&self) -> &ProcessParameters {
        &self.process
    }
}

/// The proxy of a layer as a screen.
///
/// It estimates the deviation at the layer's end.
/// Where both the reward and the reward without travel count, travel takes a part of its time.
#[derive(Clone, Debug)]
pub struct ProxyScreen<F: Fill = Cells> {
    proxy: LayerProxy,
    layer: u32,
    from: Option<F::Position>,
    fill: Arc<F>,
    /// The part of its time that travel takes.
    travel: f64,
    factor: f64,
}

impl<F: Fill> Screen<F::Path> for ProxyScreen<F> {
    fn cost(&self, path: &F::Path) -> f64 {
        let mut events = self.fill.events(self.layer, self.from, path);
        if self.travel > 0.0 {
            for pause in events.iter_mut().filter(|event| event.voxel.is_none()) {
                pause.seconds *= self.travel;
            }
        } else {
            remove_pauses(&mut events);
        }
        self.factor * self.proxy.end_std_c(&events)
    }
}

fn remove_pauses(events: &mut Vec<DepositionEvent>) {
    events.retain(|event| event.voxel.is_some());
}

/// Deviation of all temperatures, K.
fn deviation(simulation: &Simulation) -> f64 {
    simulation.statistics().map_or(0.0, |all| all.std_c)
}

/// Runs through the events of a layer with the given share of the part's voxels, and returns what
/// it costs.
fn print_cost(
    print: &mut Simulation,
    meter: Option<&mut HeatMeter>,
    cost: &LayerCost,
    share: f64,
    layer: u32,
    events: Vec<DepositionEvent>,
    control: &Control<'_>,
) -> Result<f64, DepositError> {
    let mut over_time = 0.0;
    match meter {
        None => print.run(&events, control)?,
        Some(meter) => {
            let heat = meter.run(print, layer, events, control)?;
            over_time += cost.factor(Objective::TimeAveraged) * heat.mean_std_c * share;
            if layer > 0 {
                over_time += cost.factor(Objective::Peak) * heat.max_std_c;
            }
        }
    }
    Ok(over_time + cost.factor(Objective::Reward) * deviation(print))
}

impl<F: Fill> ThermalModel for Solver<F> {
    type Fill = F;
    type Screen = ProxyScreen<F>;

    fn fill(&self) -> &F {
        &self.fill
    }

    fn position(&self) -> Option<F::Position> {
        self.position
    }

    fn deposit(
        &mut self,
        layer: u32,
        path: &F::Path,
        control: &Control<'_>,
    ) -> Result<f64, DepositError> {
        let events = self.fill.events(layer, self.position, path);
        self.simulation().check_complete(layer, &events)?;
        self.run(layer, path, events, control)
    }

    fn deposit_lines(
        &mut self,
        layer: u32,
        path: &F::Path,
        control: &Control<'_>,
    ) -> Result<f64, DepositError> {
        let events = self.fill.events(layer, self.position, path);
        self.run(layer, path, events, control)
    }

    fn linear_layer(&self, layer: u32) -> Option<LinearLayer> {
        Some(LinearLayer::new(self.simulation(), layer, &self.material))
    }

    fn screen(&self, layer: u32) -> Option<ProxyScreen<F>> {
        let (reward, no_travel) =
            (self.cost.factor(Objective::Reward), self.cost.factor(Objective::NoTravel));
        let factor = reward + no_travel;
        (factor > 0.0).then(|| ProxyScreen {
            proxy: LayerProxy::new(self.simulation(), layer, &self.material),
            layer,
            from: self.position,
            fill: self.fill.clone(),
            travel: reward / factor,
            factor,
        })
    }
}
