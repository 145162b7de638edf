//! Simulated prints of whole parts, as all thermal benchmarks run them.

use std::sync::Arc;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};

/// The solver with its default accuracy.
pub(super) const FAST: Method = Method::Fast(Accuracy::Standard);

/// The paper's process (Kim et al. 2026) without travel: depositions follow each other without a
/// pause.
pub(super) fn process() -> ProcessParameters {
    ProcessParameters { travel_mm_s: None, ..ProcessParameters::default() }
}

/// Simulates the print of a whole part in ABS on one thread, and returns the wall-clock time that
/// the solver took, in seconds.
///
/// `at_layer_end` is called with the number of each layer and the simulation at its end; its own
/// time does not count.
pub(super) fn print(
    part: &Arc<Voxels>,
    orders: &[Vec<Cell>],
    method: Method,
    mut at_layer_end: impl FnMut(usize, &Simulation),
) -> anyhow::Result<f64> {
    let control = control::cancellable(Threads::One)?;
    let mut simulation =
        Simulation::new(part.clone(), &ThermalMaterial::abs(), &process(), method)?;
    let mut seconds = 0.0;
    for (layer, order) in orders.iter().enumerate() {
        let begin = Instant::now();
        simulation.deposit(layer as u32, order, &control)?;
        seconds += begin.elapsed().as_secs_f64();
        at_layer_end(layer, &simulation);
    }
    Ok(seconds)
}
