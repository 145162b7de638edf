//! Differences between a simulation and a more accurate one.

use beadwork_grid::Cell;
use beadwork_thermal::{Simulation, TemperatureStatistics};
use serde::Serialize;

/// Number of voxels at the end of each layer that [`Errors::settled_max_k`] leaves out, since
/// errors are largest near the nozzle.
const RECENT: usize = 120;

/// Temperatures of all deposited voxels at the end of each layer, °C, in the order of their
/// deposition.
#[derive(Default)]
pub(super) struct Temperatures(Vec<Vec<f32>>);

impl Temperatures {
    /// Records the temperatures at the end of a layer; `orders` holds the order of each layer.
    pub(super) fn record(&mut self, layer: usize, simulation: &Simulation, orders: &[Vec<Cell>]) {
        let width = simulation.part().frame.width;
        let voxels = orders[..=layer]
            .iter()
            .zip(0..)
            .flat_map(|(order, z)| order.iter().map(move |&cell| (cell, z)));
        let celsius = voxels.map(|(cell, z)| {
            let voxel = [cell % width, cell / width, z];
            simulation.temperature_c(voxel).expect("all cells of the orders are deposited") as f32
        });
        self.0.push(celsius.collect());
    }
}

/// Errors of the temperatures at the ends of layers, K.
#[derive(Clone, Copy, Default, Serialize)]
#[expect(clippy::struct_field_names, reason = "the unit")]
pub(super) struct Errors {
    /// Root mean square over all voxels and layers.
    pub(super) rms_k: f64,
    /// Maximum over all voxels and layers.
    pub(super) max_k: f64,
    /// Maximum over all voxels except the last [`RECENT`] of each layer.
    pub(super) settled_max_k: f64,
    /// Maximum error over the layers of the standard deviation of all deposited voxels.
    pub(super) std_k: f64,
}

impl Errors {
    /// Errors of temperatures relative to a reference for the same orders.
    pub(super) fn between(temperatures: &Temperatures, reference: &Temperatures) -> Self {
        let mut errors = Self::default();
        let (mut squares, mut count) = (0.0, 0_usize);
        for (layer, reference) in temperatures.0.iter().zip(&reference.0) {
            let settled = layer.len().saturating_sub(RECENT);
            for (i, (own, exact)) in layer.iter().zip(reference).enumerate() {
                let difference = f64::from(own - exact).abs();
                squares += difference * difference;
                errors.max_k = errors.max_k.max(difference);
                if i < settled {
                    errors.settled_max_k = errors.settled_max_k.max(difference);
                }
            }
            count += layer.len();
            let std_error = standard_deviation(layer) - standard_deviation(reference);
            errors.std_k = errors.std_k.max(std_error.abs());
        }
        errors.rms_k = (squares / count as f64).sqrt();
        errors
    }
}

fn standard_deviation(celsius: &[f32]) -> f64 {
    let celsius = celsius.iter().map(|&celsius| f64::from(celsius));
    TemperatureStatistics::of(celsius).map_or(0.0, |all| all.std_c)
}
