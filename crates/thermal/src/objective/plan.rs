//! Measures of a whole plan.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{Control, Interrupted};
use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use thiserror::Error;

use super::meter::{HeatMeter, LayerHeat, Settings};
use crate::event::DepositionEvent;
use crate::material::ThermalMaterial;
use crate::process::ProcessParameters;
use crate::simulation::{DepositError, Method, SetupError, Simulation};

/// Measures of a whole print.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMeasures {
    /// The measures of each layer.
    pub layers: Vec<LayerHeat>,
    /// The reward if travel and pauses took no time, K, at most 0; `None` if it is not simulated.
    pub no_travel_reward: Option<f64>,
    /// Estimated lift of the outline, mm, at least 0; `None` if it is not estimated.
    pub warpage_mm: Option<f64>,
}

impl HeatMeasures {
    /// The paper's reward (Kim et al. 2026), K, at most 0: minus the sum of the deviations at the
    /// layers' ends.
    pub fn reward(&self) -> f64 {
        -self.sum(|layer| layer.end_std_c)
    }

    /// Mean deviation over the time of the print, K; 0 if it takes no time.
    pub fn time_averaged_std_c(&self) -> f64 {
        let seconds = self.print_seconds();
        if seconds > 0.0 {
            self.sum(|layer| layer.mean_std_c * layer.print_seconds) / seconds
        } else {
            0.0
        }
    }

    /// Sum of the maximum deviation while each layer is printed, K, over all layers but the first;
    /// 0 if there is only one.
    pub fn peak_std_sum_c(&self) -> f64 {
        self.layers.iter().skip(1).map(|layer| layer.max_std_c).fold(0.0, |sum, max| sum + max)
    }

    /// Maximum deviation over the time of the print, K; 0 without layers.
    ///
    /// It occurs while the first voxels of the part are deposited, whatever the order, so it hardly
    /// distinguishes plans; [`HeatMeasures::peak_std_sum_c`] leaves the first layer out.
    pub fn max_std_c(&self) -> f64 {
        self.layers.iter().map(|layer| layer.max_std_c).fold(0.0, f64::max)
    }

    /// Printing time, s, with travel and pauses.
    pub fn print_seconds(&self) -> f64 {
        self.sum(|layer| layer.print_seconds)
    }

    /// Time of travel, s.
    pub fn travel_seconds(&self) -> f64 {
        self.sum(|layer| layer.travel_seconds)
    }

    /// Time of pauses at layers' ends, s.
    pub fn pause_seconds(&self) -> f64 {
        self.sum(|layer| layer.pause_seconds)
    }

    fn sum(&self, of: impl Fn(&LayerHeat) -> f64) -> f64 {
        self.layers.iter().map(of).fold(0.0, |sum, of_layer| sum + of_layer)
    }
}

/// Why a plan cannot be measured.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeasureError {
    /// The simulation cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// An order cannot be deposited, or the call was interrupted.
    #[error(transparent)]
    Deposit(#[from] DepositError),
    /// The number of orders is not that of the part's layers.
    #[error("plan has {orders} layers, part has {layers}: give one order per layer")]
    Layers {
        /// Layers of the plan.
        orders: usize,
        /// Layers of the part.
        layers: usize,
    },
}

impl From<Interrupted> for MeasureError {
    fn from(interrupted: Interrupted) -> Self {
        Self::Deposit(interrupted.into())
    }
}

/// Simulates a plan, one order per layer, and takes all its measures; warpage only if the settings
/// say so.
///
/// If the process has travel that takes time, or the settings have a pause, the plan is simulated a
/// second time without both, for [`HeatMeasures::no_travel_reward`]; on several threads, the two
/// run at the same time.
/// Progress counts layers of all runs.
///
/// # Panics
/// If [`Settings::sample_s`] is not more than 0.
pub fn measure_plan(
    part: &Arc<Voxels>,
    material: &ThermalMaterial,
    process: &ProcessParameters,
    method: Method,
    orders: &[Vec<Cell>],
    settings: &Settings,
    control: &Control<'_>,
) -> Result<HeatMeasures, MeasureError> {
    if orders.len() != part.depth {
        return Err(MeasureError::Layers { orders: orders.len(), layers: part.depth });
    }
    let without_travel = ProcessParameters { travel_mm_s: None, ..process.clone() };
    let has_travel = process.travel_mm_s.is_some();
    measure(part, material, [process, &without_travel], method, settings, has_travel, control, {
        |meter, simulation, layer, _, own| {
            meter.deposit(simulation, layer as u32, &orders[layer], own)
        }
    })
}

/// As [`measure_plan`], for the deposition events of each layer, such as those of a G-code program.
///
/// For [`HeatMeasures::no_travel_reward`], the print is simulated a second time without the events
/// that deposit nothing, if there are any.
///
/// # Errors
/// If the events cannot be simulated.
/// They may leave out voxels, which are missing from the print then.
pub fn measure_events(
    part: &Arc<Voxels>,
    material: &ThermalMaterial,
    process: &ProcessParameters,
    method: Method,
    layers: &[Vec<DepositionEvent>],
    settings: &Settings,
    control: &Control<'_>,
) -> Result<HeatMeasures, MeasureError> {
    if layers.len() != part.depth {
        return Err(MeasureError::Layers { orders: layers.len(), layers: part.depth });
    }
    let has_travel = layers.iter().flatten().any(|event| event.voxel.is_none());
    measure(part, material, [process; 2], method, settings, has_travel, control, {
        |meter, simulation, layer, with_travel, own| {
            let events = layers[layer].iter().copied();
            let events = events.filter(|event| with_travel || event.voxel.is_some());
            meter.run(simulation, layer as u32, events.collect(), own)
        }
    })
}

/// Measures a print and, if it has travel or pauses, the same print without them.
///
/// `processes` are those of the two; `deposit` gets the meter, the simulation, the layer, and
/// whether travel takes time.
#[expect(clippy::too_many_arguments, reason = "all that makes up a measured print")]
fn measure(
    part: &Arc<Voxels>,
    material: &ThermalMaterial,
    processes: [&ProcessParameters; 2],
    method: Method,
    settings: &Settings,
    has_travel: bool,
    control: &Control<'_>,
    deposit: impl Fn(
        &mut HeatMeter,
        &mut Simulation,
        usize,
        bool,
        &Control<'_>,
    ) -> Result<LayerHeat, DepositError>
    + Sync,
) -> Result<HeatMeasures, MeasureError> {
    let without_pause =
        Settings { pause_s: 0.0, sample_s: Some(f64::INFINITY), warpage: false, ..*settings };
    let mut runs = vec![(processes[0], settings, true)];
    if has_travel || settings.pause_s != 0.0 {
        runs.push((processes[1], &without_pause, false));
    }
    let (done, total) = (AtomicUsize::new(0), runs.len() * part.depth);
    let own = control.on_one_thread().without_progress();
    let measure = |&(process, settings, with_travel): &(&ProcessParameters, &Settings, bool)| {
        let mut simulation = Simulation::new(part.clone(), material, process, method)?;
        let mut meter = HeatMeter::new(&simulation, material, settings.clone());
        for layer in 0..part.depth {
            deposit(&mut meter, &mut simulation, layer, with_travel, &own)?;
            control.report(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        }
        meter.finish(&simulation, &own).map_err(MeasureError::from)
    };
    let mut results = control.threads.map(&runs, measure).into_iter();
    let mut measures = results.next().expect("the first run is the plan itself")?;
    measures.no_travel_reward = Some(match results.next() {
        Some(without_travel) => without_travel?.reward(),
        None => measures.reward(),
    });
    Ok(measures)
}
