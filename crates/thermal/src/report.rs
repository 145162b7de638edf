//! Measures of a part at the end of a layer.

use crate::hot_spots::HotSpots;
use crate::material::ThermalMaterial;
use crate::simulation::Simulation;
use crate::statistics::TemperatureStatistics;

/// Measures of a part at the end of one of its layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerReport {
    /// The layer.
    pub layer: u32,
    /// Time to print the layer, with travel, s.
    pub print_seconds: f64,
    /// Temperatures of all deposited voxels of the part.
    pub part_temperatures: TemperatureStatistics,
    /// Temperatures of the layer's voxels.
    pub layer_temperatures: TemperatureStatistics,
    /// Groups of the layer's voxels above the glass transition.
    pub hot_spots: HotSpots,
}

impl LayerReport {
    /// Measures a simulation at the end of a layer that took `print_seconds`; `None` if no voxel of
    /// the layer is deposited.
    ///
    /// Costs some passes over all deposited voxels, far less than simulating the layer.
    pub fn of(
        simulation: &Simulation,
        layer: u32,
        print_seconds: f64,
        material: &ThermalMaterial,
    ) -> Option<Self> {
        Some(Self {
            layer,
            print_seconds,
            part_temperatures: simulation.statistics()?,
            layer_temperatures: simulation.layer_statistics(layer)?,
            hot_spots: simulation.layer_hot_spots(layer, material.glass_transition_c),
        })
    }
}

/// The paper's reward of a whole part (Kim et al. 2026), °C: minus the sum, over its layers, of the
/// standard deviation of all temperatures at the layer's end.
/// The best possible reward is 0.
pub fn reward(reports: &[LayerReport]) -> f64 {
    -reports.iter().map(|report| report.part_temperatures.std_c).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;
    use beadwork_part::Pattern;

    use super::*;
    use crate::testing::{stairs, unprinted};

    #[test]
    fn layers_are_reported_as_they_end() {
        let part = stairs(13, 7, 3);
        let mut simulation = unprinted(part.clone());
        let material = ThermalMaterial::abs();
        assert_eq!(LayerReport::of(&simulation, 0, 0.0, &material), None);
        let mut reports = Vec::new();
        let mut expected = 0.0;
        for layer in 0..3 {
            let order = Pattern::CONVENTIONAL.order(&part.region(layer as usize).unwrap());
            let seconds = simulation.deposit(layer, &order, &Control::default()).unwrap();
            let report = LayerReport::of(&simulation, layer, seconds, &material).unwrap();
            assert_eq!(report.layer_temperatures.count, order.len());
            assert!(report.part_temperatures.count >= report.layer_temperatures.count);
            assert!(report.print_seconds >= order.len() as f64 / 60.0);
            assert!((1..=order.len()).contains(&report.hot_spots.voxels));
            let all: Vec<f64> = (0..=layer)
                .flat_map(|layer| simulation.cell_temperatures_c(layer))
                .map(|(_, celsius)| celsius)
                .collect();
            expected -= TemperatureStatistics::of(all).unwrap().std_c;
            reports.push(report);
        }
        assert!((reward(&reports) - expected).abs() < 1e-9);
    }
}
