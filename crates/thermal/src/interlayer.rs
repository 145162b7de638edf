//! Temperatures of the substrate on which each layer was deposited.

use beadwork_part::slice::Voxels;

use crate::simulation::Simulation;
use crate::statistics::TemperatureStatistics;

/// The temperatures between a layer and the one below it, at the moment when the layer was
/// deposited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterlayerTemperatures {
    /// The upper of the two layers.
    pub layer: u32,
    /// Temperatures of the lower layer's voxels, each just before a voxel was deposited on it.
    pub substrate: TemperatureStatistics,
    /// Share of these voxels that were below the glass transition, 0 to 1.
    pub cold_share: f64,
}

impl Simulation {
    /// The interlayer temperatures of all layers that lie on others, from the bottom up.
    /// Linear in the part's voxels.
    ///
    /// Two beads weld as polymer chains diffuse through their interface, while that is above the
    /// glass transition (Sun, Rizvi, Bellehumeur and Gu 2008, *Rapid Prototyping Journal* 14;
    /// Seppala and Migler 2016, *Additive Manufacturing* 12).
    /// On a warm substrate the interface cools more slowly.
    /// The interface itself starts at about the mean of bead and substrate temperature, so a
    /// substrate below the glass transition is common and not a defect: use these numbers to rank
    /// plans.
    pub fn interlayer_temperatures(&self, glass_transition_c: f64) -> Vec<InterlayerTemperatures> {
        of_layers(self.part(), glass_transition_c, |voxel| self.substrate_temperature_c(voxel))
    }
}

/// The interlayer temperatures of a part, given [`Simulation::substrate_temperature_c`].
/// Layers without a voxel on another one are left out.
fn of_layers(
    part: &Voxels,
    glass_transition_c: f64,
    substrate_c: impl Fn([u32; 3]) -> Option<f64>,
) -> Vec<InterlayerTemperatures> {
    let width = part.frame.width;
    let of_layer = |layer: u32| {
        let cells = part.cells(layer as usize);
        let substrates: Vec<f64> =
            cells.filter_map(|cell| substrate_c([cell % width, cell / width, layer])).collect();
        let substrate = TemperatureStatistics::of(substrates.iter().copied())?;
        let cold = substrates.iter().filter(|&&celsius| celsius < glass_transition_c).count();
        let cold_share = cold as f64 / substrates.len() as f64;
        Some(InterlayerTemperatures { layer, substrate, cold_share })
    };
    (0..part.depth as u32).filter_map(of_layer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::stairs;

    #[test]
    fn each_layer_has_its_own_temperatures() {
        let part = stairs(8, 4, 4);
        let layers = of_layers(&part, 105.0, |[x, _, z]| {
            (z == 1 || z == 2).then_some(if x < 6 { 90.0 } else { 130.0 })
        });
        assert_eq!(layers.iter().map(|layer| layer.layer).collect::<Vec<_>>(), [1, 2]);
        // Layer 1 begins at x = 1, layer 2 at x = 2.
        assert_eq!((layers[0].substrate.count, layers[1].substrate.count), (28, 24));
        assert_eq!((layers[0].cold_share, layers[1].cold_share), (5.0 / 7.0, 4.0 / 6.0));
        assert_eq!((layers[0].substrate.min_c, layers[0].substrate.max_c), (90.0, 130.0));
    }

    #[test]
    fn layers_on_nothing_are_left_out() {
        assert_eq!(of_layers(&stairs(8, 4, 4), 105.0, |_| None), []);
    }
}
