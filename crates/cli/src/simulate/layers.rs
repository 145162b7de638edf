//! How warm all that is printed is when a layer is complete.

use beadwork_thermal::Simulation;
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
        let depth = simulation.part().depth as u32;
        let all = || (0..depth).flat_map(|layer| simulation.layer_c(layer)).map(|(_, celsius)| celsius);
        let (mut voxels, mut sum) = (0, 0.0);
        let (mut min_c, mut max_c) = (f64::INFINITY, f64::NEG_INFINITY);
        for celsius in all() {
            voxels += 1;
            sum += celsius;
            (min_c, max_c) = (min_c.min(celsius), max_c.max(celsius));
        }
        let mean_c = sum / voxels as f64;
        let squares: f64 = all().map(|celsius| (celsius - mean_c).powi(2)).sum();
        let std_c = (squares / voxels as f64).sqrt();
        Self { layer: layer + 1, voxels, mean_c, std_c, min_c, max_c, print_seconds }
    }
}
