//! Measures of a print, taken while it is simulated.

use beadwork_base::{Control, Interrupted};
use beadwork_grid::Cell;

use super::plan::HeatMeasures;
use crate::event::DepositionEvent;
use crate::material::ThermalMaterial;
use crate::simulation::{DepositError, Simulation};
use crate::warpage::WarpageEstimator;

/// Longest time between two samples of the warpage estimator, s.
const WARPAGE_SAMPLE_S: f64 = 0.5;

/// Longest time between two samples in methods with one step per event, s: about that of the fast
/// method's longest step for the paper's ABS.
const DEFAULT_SAMPLE_S: f64 = 3.0;

/// How a print is measured.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pause at the end of each layer, s, at least 0: part of the layer, its printing time and its
    /// measures.
    /// It lowers the paper's reward out of proportion to its time, so compare plans with the same
    /// pause.
    pub pause_s: f64,
    /// Longest time between two samples, s, more than 0; `None` for the longest step of the method,
    /// or at most 0.5 s with `warpage`.
    /// Pauses longer than it are cut, depositions never.
    pub sample_s: Option<f64>,
    /// Whether warpage is estimated, which takes more samples and so more time.
    pub warpage: bool,
}

impl Default for Settings {
    /// No pause, samples at the ends of the method's longest steps, no warpage.
    fn default() -> Self {
        Self { pause_s: 0.0, sample_s: None, warpage: false }
    }
}

/// Measures of one layer of a print.
///
/// Deviations are population standard deviations of the temperatures of all voxels of the part that
/// are deposited at the time, in K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerHeat {
    /// The layer.
    pub layer: u32,
    /// Time to print the layer, s, with travel and the pause.
    pub print_seconds: f64,
    /// Time of travel, s.
    pub travel_seconds: f64,
    /// The pause at the layer's end, s.
    pub pause_seconds: f64,
    /// Deviation at the layer's end, after the pause, K; minus it is the paper's reward.
    pub end_std_c: f64,
    /// Mean deviation over the time of the layer, K; 0 if the layer takes no time.
    pub mean_std_c: f64,
    /// Maximum deviation over the samples of the layer, K.
    pub max_std_c: f64,
}

/// Follows a simulation layer by layer and measures it.
///
/// A clone continues on its own, so that a search can keep a meter with each fork of a simulation.
///
/// ```
/// # use std::sync::Arc;
/// # use beadwork_part::slice::Voxels;
/// # use beadwork_part::Frame;
/// # use beadwork_thermal::simulation::Method;
/// # use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
/// use beadwork_base::Control;
/// use beadwork_part::Pattern;
/// use beadwork_thermal::objective::{HeatMeter, Objective, Settings};
/// use beadwork_thermal::simulation::DepositError;
///
/// # let (left_mm, back_mm) = (0.0, 0.0);
/// # let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 20, 10);
/// # let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width, height };
/// # let part = Arc::new(Voxels::new(frame, ndarray::Array3::zeros((2, 10, 20))));
/// # let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
/// # let mut simulation = Simulation::new(part.clone(), &abs, &process, Method::default())?;
/// let control = Control::default();
/// let mut meter = HeatMeter::new(&simulation, &abs, Settings::default());
/// for layer in 0..2 {
///     // The pattern of the lowest deviation over time, not only at the layer's end.
///     let orders = Pattern::ALL.map(|pattern| pattern.order(&part.region(0).unwrap()));
///     let trial = |order: &Vec<u32>| {
///         let (mut meter, mut fork) = (meter.clone(), simulation.clone());
///         let heat = meter.deposit(&mut fork, layer, order, &control)?;
///         Ok((heat.mean_std_c, meter, fork))
///     };
///     let trials = orders.iter().map(trial).collect::<Result<Vec<_>, DepositError>>()?;
///     let best = trials.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
///     (_, meter, simulation) = best.expect("all orders were tried");
/// }
/// let measures = meter.finish(&simulation, &control)?;
/// assert!(Objective::TimeAveraged.cost(&measures) > Some(0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct HeatMeter {
    settings: Settings,
    layers: Vec<LayerHeat>,
    warpage: Option<WarpageEstimator>,
}

/// The integral of a deviation over time, by the trapezoidal rule.
struct Integral {
    at_s: f64,
    std_c: f64,
    sum: f64,
    max: f64,
}

impl Integral {
    fn add(&mut self, simulation: &Simulation) {
        let std_c = deviation(simulation);
        self.sum += f64::midpoint(self.std_c, std_c) * (simulation.seconds() - self.at_s);
        self.max = self.max.max(std_c);
        (self.at_s, self.std_c) = (simulation.seconds(), std_c);
    }
}

/// Deviation of all deposited voxels, K; 0 if there are none.
fn deviation(simulation: &Simulation) -> f64 {
    simulation.statistics().map_or(0.0, |all| all.std_c)
}

impl HeatMeter {
    /// A meter of a print of which nothing is deposited yet.
    ///
    /// With warpage, it holds 8 bytes per voxel of the part's bounding box.
    ///
    /// # Panics
    /// If [`Settings::sample_s`] is not more than 0.
    pub fn new(simulation: &Simulation, material: &ThermalMaterial, settings: Settings) -> Self {
        let is_valid = settings.sample_s.is_none_or(|seconds| seconds > 0.0);
        assert!(is_valid, "the time between samples must be more than 0");
        let warpage = settings.warpage.then(|| WarpageEstimator::new(simulation.part(), material));
        Self { settings, layers: Vec::new(), warpage }
    }

    /// Deposits a layer like [`Simulation::deposit`], followed by the pause of the settings, and
    /// measures it.
    ///
    /// A layer without cells takes no time and has no pause, and is not among the
    /// [`HeatMeter::layers`].
    /// Progress counts deposition events, the pause included.
    /// An invalid order or pause leaves simulation and meter unchanged.
    /// After an interruption, the simulation is in the state that [`Simulation::run`] describes,
    /// and the layer is not measured: continue from clones that were made before the call.
    ///
    /// # Panics
    /// If the simulation is not the one that the meter has followed so far, or a clone of it.
    pub fn deposit(
        &mut self,
        simulation: &mut Simulation,
        layer: u32,
        order: &[Cell],
        control: &Control<'_>,
    ) -> Result<LayerHeat, DepositError> {
        let events = simulation.layer_events(layer, order);
        self.measure(simulation, layer, events, true, control)
    }

    /// Runs through the events of a layer like [`Simulation::run`], followed by the pause of the
    /// settings, and measures it; everything else is as in [`HeatMeter::deposit`].
    ///
    /// Events without a voxel count as travel.
    /// A layer without events has no pause, and is not among the [`HeatMeter::layers`].
    ///
    /// # Panics
    /// As [`HeatMeter::deposit`].
    pub fn run(
        &mut self,
        simulation: &mut Simulation,
        layer: u32,
        events: Vec<DepositionEvent>,
        control: &Control<'_>,
    ) -> Result<LayerHeat, DepositError> {
        self.measure(simulation, layer, events, false, control)
    }

    /// Runs through the events of a layer, which may have to deposit all of its voxels.
    fn measure(
        &mut self,
        simulation: &mut Simulation,
        layer: u32,
        mut events: Vec<DepositionEvent>,
        is_whole: bool,
        control: &Control<'_>,
    ) -> Result<LayerHeat, DepositError> {
        control.check()?;
        let is_printed = !events.is_empty();
        let is_travel = |event: &&DepositionEvent| event.voxel.is_none();
        let travel_s = events.iter().filter(is_travel).map(|event| event.seconds);
        // Not `sum`, which is -0 without travel.
        let travel_seconds = travel_s.fold(0.0, |sum, seconds| sum + seconds);
        let pause_seconds = if is_printed { self.settings.pause_s } else { 0.0 };
        if pause_seconds != 0.0 {
            events.push(DepositionEvent::pause(pause_seconds));
        }
        let intervals = simulation.validate(&events)?;
        if is_whole {
            simulation.check_complete(layer, &events)?;
        }
        let max_s = self.settings.sample_s.unwrap_or_else(|| {
            let step_s = simulation.longest_step_s().unwrap_or(DEFAULT_SAMPLE_S);
            if self.warpage.is_some() { step_s.min(WARPAGE_SAMPLE_S) } else { step_s }
        });
        let (start_s, start_std_c) = (simulation.seconds(), deviation(simulation));
        let mut integral =
            Integral { at_s: start_s, std_c: start_std_c, sum: 0.0, max: start_std_c };
        let warpage = &mut self.warpage;
        let sample = |simulation: &Simulation| {
            integral.add(simulation);
            if let Some(warpage) = warpage {
                warpage.sample(simulation);
            }
        };
        simulation.run_in_steps(&events, &intervals, max_s, sample, control)?;
        let print_seconds = simulation.seconds() - start_s;
        let heat = LayerHeat {
            layer,
            print_seconds,
            travel_seconds,
            pause_seconds,
            end_std_c: integral.std_c,
            mean_std_c: if print_seconds > 0.0 { integral.sum / print_seconds } else { 0.0 },
            max_std_c: integral.max,
        };
        if is_printed {
            self.layers.push(heat);
        }
        Ok(heat)
    }

    /// The layers measured so far, in the order of the calls.
    pub fn layers(&self) -> &[LayerHeat] {
        &self.layers
    }

    /// Completes the measures of the print; [`HeatMeasures::no_travel_reward`] is `None`.
    ///
    /// With warpage, costs and progress are those of [`WarpageEstimator::finish`]; without, it
    /// costs next to nothing.
    ///
    /// # Panics
    /// As [`HeatMeter::deposit`].
    pub fn finish(
        self,
        simulation: &Simulation,
        control: &Control<'_>,
    ) -> Result<HeatMeasures, Interrupted> {
        let warpage =
            self.warpage.map(|warpage| warpage.finish(simulation, control)).transpose()?;
        Ok(HeatMeasures {
            layers: self.layers,
            no_travel_reward: None,
            warpage_mm: warpage.map(|warpage| warpage.corner_lift_mm),
        })
    }
}
