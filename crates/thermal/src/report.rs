//! What there is to tell of a finished layer.

use crate::hot_spots::HotSpots;
use crate::material::Material;
use crate::simulation::Simulation;
use crate::spread::Spread;

/// The measures of a part at the end of one of its layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerReport {
    /// The layer.
    pub layer: u32,
    /// How long it took to print, with travel, s.
    pub print_seconds: f64,
    /// Temperatures of all that is deposited.
    pub all: Spread,
    /// Temperatures of the layer.
    pub own: Spread,
    /// Where the layer is above the glass transition.
    pub hot: HotSpots,
}

impl LayerReport {
    /// Of a simulation at the end of a layer that took so many seconds; `None` if nothing of the
    /// layer is deposited.
    ///
    /// Costs some passes over all that is deposited, far less than the layer's simulation.
    pub fn of(
        simulation: &Simulation,
        layer: u32,
        print_seconds: f64,
        material: &Material,
    ) -> Option<Self> {
        let (all, own) = (simulation.spread()?, simulation.layer_spread(layer)?);
        let hot = simulation.layer_hot_spots(layer, material.glass_transition_c);
        Some(Self { layer, print_seconds, all, own, hot })
    }
}

/// The paper's reward of a whole part (Kim et al. 2026), °C: minus the sum, over its layers, of the
/// standard deviation of all temperatures at the layer's end.
/// 0 at best.
pub fn reward(reports: &[LayerReport]) -> f64 {
    -reports.iter().map(|report| report.all.std_c).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use beadwork_part::Pattern;

    use super::*;
    use crate::testing::{stairs, unprinted};

    #[test]
    fn layers_are_reported_as_they_end() {
        let part = stairs(13, 7, 3);
        let mut simulation = unprinted(part.clone());
        let material = Material::abs();
        assert_eq!(LayerReport::of(&simulation, 0, 0.0, &material), None);
        let mut reports = Vec::new();
        let mut expected = 0.0;
        for layer in 0..3 {
            let order = Pattern::CONVENTIONAL.order(&part.region(layer as usize).unwrap());
            let seconds = simulation.deposit(layer, &order).unwrap();
            let report = LayerReport::of(&simulation, layer, seconds, &material).unwrap();
            assert_eq!(report.own.count, order.len());
            assert!(
                report.all.count >= report.own.count
                    && report.print_seconds >= order.len() as f64 / 60.0
            );
            assert!((1..=order.len()).contains(&report.hot.voxels));
            let all: Vec<f64> = (0..=layer)
                .flat_map(|layer| simulation.layer_c(layer))
                .map(|(_, celsius)| celsius)
                .collect();
            expected -= Spread::of(all).unwrap().std_c;
            reports.push(report);
        }
        assert!((reward(&reports) - expected).abs() < 1e-9);
    }
}
