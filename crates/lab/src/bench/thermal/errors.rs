//! How far a simulation is from a more exact one.

use beadwork_grid::Cell;
use beadwork_thermal::{Simulation, TemperatureStatistics};
use serde::Serialize;

/// Births before a layer's end in which a difference of temperatures is told apart: those near the
/// nozzle are the largest.
const RECENT: usize = 120;

/// Temperatures of all deposited voxels at each layer's end, °C, in the order of their births.
#[derive(Default)]
pub(super) struct Fields(Vec<Vec<f32>>);

impl Fields {
    /// Takes down the temperatures at the end of a layer.
    pub(super) fn look(&mut self, layer: usize, simulation: &Simulation, orders: &[Vec<Cell>]) {
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

/// Differences at the layers' ends, K.
#[derive(Clone, Copy, Default, Serialize)]
#[expect(clippy::struct_field_names, reason = "the unit")]
pub(super) struct Errors {
    /// Root of the mean square over all voxels and layers.
    pub(super) rms_k: f64,
    /// The largest.
    pub(super) max_k: f64,
    /// The largest, without the last 120 births of each layer.
    pub(super) settled_max_k: f64,
    /// The largest of a layer's standard deviation over all deposited voxels.
    pub(super) std_k: f64,
}

impl Errors {
    pub(super) fn between(fields: &Fields, reference: &Fields) -> Self {
        let mut errors = Self::default();
        let (mut squares, mut count) = (0.0, 0_usize);
        for (field, reference) in fields.0.iter().zip(&reference.0) {
            let settled = field.len().saturating_sub(RECENT);
            for (i, (own, other)) in field.iter().zip(reference).enumerate() {
                let difference = f64::from(own - other).abs();
                squares += difference * difference;
                errors.max_k = errors.max_k.max(difference);
                if i < settled {
                    errors.settled_max_k = errors.settled_max_k.max(difference);
                }
            }
            count += field.len();
            errors.std_k = errors.std_k.max((deviation(field) - deviation(reference)).abs());
        }
        errors.rms_k = (squares / count as f64).sqrt();
        errors
    }
}

fn deviation(field: &[f32]) -> f64 {
    let celsius = field.iter().map(|&celsius| f64::from(celsius));
    TemperatureStatistics::of(celsius).map_or(0.0, |all| all.std_c)
}
