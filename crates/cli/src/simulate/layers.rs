//! How warm all that is printed is when a layer is complete.

use beadwork_thermal::{InterlayerTemperatures, LayerReport, TemperatureStatistics};
use serde::Serialize;

/// Temperatures of all voxels deposited so far, at the end of a layer, and what the layer is like
/// in itself.
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
    /// Groups of the layer's voxels that are above the glass transition.
    pub(super) hot_spots: usize,
    /// Mean of the temperatures of the voxels below, each just before a bead of the layer landed on
    /// it; `None` where all lie on the plate.
    pub(super) ground_mean_c: Option<f64>,
    /// The coldest of them.
    pub(super) ground_min_c: Option<f64>,
}

impl Measure {
    /// Of a layer at its end, and the bonds of all layers, from the bottom up.
    pub(super) fn new(report: &LayerReport, bonds: &[InterlayerTemperatures]) -> Self {
        let TemperatureStatistics { count, mean_c, std_c, min_c, max_c } = report.part_temperatures;
        let bond = bonds.iter().find(|bond| bond.layer == report.layer);
        Self {
            layer: report.layer as usize + 1,
            voxels: count,
            mean_c,
            std_c,
            min_c,
            max_c,
            print_seconds: report.print_seconds,
            hot_spots: report.hot_spots.count,
            ground_mean_c: bond.map(|bond| bond.substrate.mean_c),
            ground_min_c: bond.map(|bond| bond.substrate.min_c),
        }
    }
}
