//! Measures of a print at the end of each layer.

use beadwork_thermal::{InterlayerTemperatures, LayerReport, TemperatureStatistics};
use serde::Serialize;

/// Temperatures of all voxels deposited so far, at the end of a layer, and measures of the layer
/// alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct LayerMeasures {
    /// Number of the layer, from 1.
    pub(super) layer: usize,
    /// Voxels deposited so far.
    pub(super) voxels: usize,
    /// Mean temperature in °C.
    pub(super) mean_c: f64,
    /// Standard deviation of the population, in K.
    pub(super) std_c: f64,
    /// Minimum in °C.
    pub(super) min_c: f64,
    /// Maximum in °C.
    pub(super) max_c: f64,
    /// Time to print the layer, including the travel to it.
    pub(super) print_seconds: f64,
    /// Connected groups of the layer's voxels that are above the glass transition.
    pub(super) hot_spots: usize,
    /// Mean temperature of the substrate in °C: of each voxel below the layer, just before a bead
    /// was deposited on it; `None` if the layer lies on the plate.
    /// (The key keeps its name for readers of earlier versions.)
    #[serde(rename = "ground_mean_c")]
    pub(super) substrate_mean_c: Option<f64>,
    /// Minimum temperature of the substrate in °C.
    #[serde(rename = "ground_min_c")]
    pub(super) substrate_min_c: Option<f64>,
}

impl LayerMeasures {
    /// Measures of a layer at its end; `interlayer` holds the layers of the whole print.
    pub(super) fn new(report: &LayerReport, interlayer: &[InterlayerTemperatures]) -> Self {
        let TemperatureStatistics { count, mean_c, std_c, min_c, max_c } = report.part_temperatures;
        let below = interlayer.iter().find(|below| below.layer == report.layer);
        Self {
            layer: report.layer as usize + 1,
            voxels: count,
            mean_c,
            std_c,
            min_c,
            max_c,
            print_seconds: report.print_seconds,
            hot_spots: report.hot_spots.count,
            substrate_mean_c: below.map(|below| below.substrate.mean_c),
            substrate_min_c: below.map(|below| below.substrate.min_c),
        }
    }
}
