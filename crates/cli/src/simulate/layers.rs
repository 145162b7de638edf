//! How warm all that is printed is when a layer is complete.

use beadwork_thermal::{Simulation, Spread};
use serde::Serialize;

/// Temperatures of all voxels deposited so far, at the end of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Measure {
    /// The layer, from 1.
    pub(super) layer: usize,
    /// Voxels deposited so far.
    pub(super) voxels: usize,
    pub(super) mean_c: f64,
    /// Standard deviation, as of the whole of them, not of a sample.
    pub(super) std_c: f64,
    pub(super) min_c: f64,
    pub(super) max_c: f64,
    /// How long the layer took, with the way to it.
    pub(super) print_seconds: f64,
}

impl Measure {
    /// Of the layer with this number, from 0, which took so long.
    pub(super) fn at_end_of(layer: usize, print_seconds: f64, simulation: &Simulation) -> Self {
        let spread = simulation.spread().expect("a layer that is complete has voxels");
        let Spread { count, mean_c, std_c, min_c, max_c } = spread;
        Self { layer: layer + 1, voxels: count, mean_c, std_c, min_c, max_c, print_seconds }
    }
}
