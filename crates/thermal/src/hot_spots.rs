//! Groups of connected hot voxels.

use std::ops::Range;

use crate::simulation::Simulation;

/// The groups of deposited voxels above a temperature.
/// Voxels that share a face belong to the same group.
#[derive(Clone, Debug, PartialEq)]
pub struct HotSpots {
    /// The temperature, °C.
    pub above_c: f64,
    /// Number of voxels above it.
    pub voxels: usize,
    /// Number of groups.
    pub count: usize,
    /// The group with the most voxels, and of several such groups the one with the higher peak;
    /// `None` if there is no group.
    pub largest: Option<HotSpot>,
}

/// A group of connected hot voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotSpot {
    /// Number of voxels.
    pub voxels: usize,
    /// Mean of their x, y and z, in voxels: the centre of a single voxel is its position.
    /// May lie outside a group that is not convex.
    pub centre: [f64; 3],
    /// x, y and z of the hottest of them.
    pub peak: [u32; 3],
    /// Temperature of the hottest of them, °C.
    pub peak_c: f64,
}

impl Simulation {
    /// The groups of voxels above a temperature, for example
    /// [`glass_transition_c`](crate::ThermalMaterial::glass_transition_c), in the whole part.
    /// Linear in the voxels of the part's bounding box.
    pub fn hot_spots(&self, above_c: f64) -> HotSpots {
        self.hot_spots_of(0..self.part().depth, above_c)
    }

    /// The groups of voxels above a temperature in one layer.
    /// Voxels that are connected only through other layers belong to different groups.
    /// Linear in the layer's width times its height.
    pub fn layer_hot_spots(&self, layer: u32, above_c: f64) -> HotSpots {
        let layer = layer as usize;
        self.hot_spots_of(layer..layer.saturating_add(1), above_c)
    }

    fn hot_spots_of(&self, layers: Range<usize>, above_c: f64) -> HotSpots {
        let frame = &self.part().frame;
        let layers = layers.start..layers.end.min(self.part().depth);
        let grid = LayerRange {
            size: [frame.width, frame.height, layers.len() as u32],
            first: layers.start as u32,
        };
        let hot: Vec<([u32; 3], f64)> =
            self.deposited(layers).filter(|&(_, celsius)| celsius > above_c).collect();
        if hot.is_empty() {
            return HotSpots { above_c, voxels: 0, count: 0, largest: None };
        }
        // Temperatures of hot voxels that are in no group yet; NaN for all others.
        let mut ungrouped = vec![f64::NAN; grid.size.iter().map(|&size| size as usize).product()];
        hot.iter().for_each(|&(voxel, celsius)| ungrouped[grid.index(voxel)] = celsius);
        let mut spots = HotSpots { above_c, voxels: hot.len(), count: 0, largest: None };
        for &(voxel, _) in &hot {
            if ungrouped[grid.index(voxel)].is_nan() {
                continue;
            }
            let spot = grid.take_group(voxel, &mut ungrouped);
            spots.count += 1;
            let rank = |spot: &HotSpot| (spot.voxels, spot.peak_c);
            if spots.largest.as_ref().is_none_or(|largest| rank(largest) < rank(&spot)) {
                spots.largest = Some(spot);
            }
        }
        spots
    }
}

/// Consecutive layers of a part.
#[derive(Clone, Copy)]
struct LayerRange {
    /// Width, height and number of layers.
    size: [u32; 3],
    /// The lowest layer.
    first: u32,
}

impl LayerRange {
    /// Index of a voxel in an array `[z, y, x]` of these layers.
    fn index(self, [x, y, z]: [u32; 3]) -> usize {
        let [width, height, _] = self.size.map(|size| size as usize);
        ((z - self.first) as usize * height + y as usize) * width + x as usize
    }

    /// The up to six neighbours of a voxel in these layers.
    fn neighbours(self, voxel: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
        let origin = [0, 0, self.first];
        (0..3).flat_map(move |axis: usize| {
            let (i, end) = (voxel[axis], origin[axis] + self.size[axis]);
            let at = move |i| {
                let mut voxel = voxel;
                voxel[axis] = i;
                voxel
            };
            let before = (i > origin[axis]).then(|| at(i - 1));
            before.into_iter().chain((i + 1 < end).then(|| at(i + 1)))
        })
    }

    /// Collects the group of a voxel by depth-first search, and removes its voxels from those
    /// without a group.
    fn take_group(self, first: [u32; 3], ungrouped: &mut [f64]) -> HotSpot {
        let (mut voxels, mut sums, mut peak, mut peak_c) = (0, [0; 3], first, f64::NEG_INFINITY);
        let first_c = std::mem::replace(&mut ungrouped[self.index(first)], f64::NAN);
        let mut stack = vec![(first, first_c)];
        while let Some((voxel, celsius)) = stack.pop() {
            voxels += 1;
            (0..3).for_each(|axis| sums[axis] += u64::from(voxel[axis]));
            if celsius > peak_c {
                (peak, peak_c) = (voxel, celsius);
            }
            for next in self.neighbours(voxel) {
                let celsius = std::mem::replace(&mut ungrouped[self.index(next)], f64::NAN);
                if !celsius.is_nan() {
                    stack.push((next, celsius));
                }
            }
        }
        HotSpot { voxels, centre: sums.map(|sum| sum as f64 / voxels as f64), peak, peak_c }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{half_printed, stairs};

    /// Sizes of groups, ascending, by a slow method: each voxel takes the smallest label of its
    /// neighbours until no label changes.
    fn slow_sizes(simulation: &Simulation, layers: Range<u32>, above_c: f64) -> Vec<usize> {
        let frame = simulation.part().frame;
        let mut labels: Vec<([u32; 3], usize)> = layers
            .flat_map(|z| {
                (0..frame.height).flat_map(move |y| (0..frame.width).map(move |x| [x, y, z]))
            })
            .filter(|&voxel| {
                simulation.temperature_c(voxel).is_some_and(|celsius| celsius > above_c)
            })
            .zip(0..)
            .collect();
        loop {
            let before = labels.clone();
            for (voxel, label) in &mut labels {
                let near = |other: &[u32; 3]| {
                    (0..3).map(|axis| voxel[axis].abs_diff(other[axis])).sum::<u32>() <= 1
                };
                *label = before
                    .iter()
                    .filter(|(other, _)| near(other))
                    .map(|&(_, label)| label)
                    .min()
                    .unwrap();
            }
            if labels == before {
                break;
            }
        }
        let mut sizes: Vec<usize> = (0..labels.len())
            .map(|group| labels.iter().filter(|&&(_, label)| label == group).count())
            .collect();
        sizes.retain(|&size| size > 0);
        sizes.sort_unstable();
        sizes
    }

    fn check(spots: &HotSpots, sizes: &[usize]) {
        assert_eq!((spots.count, spots.voxels), (sizes.len(), sizes.iter().sum()));
        assert_eq!(spots.largest.map(|spot| spot.voxels), sizes.last().copied());
    }

    #[test]
    fn groups_are_those_of_the_slow_method() {
        let simulation = half_printed(&stairs(13, 7, 5));
        let all = simulation.statistics().unwrap();
        for tenth in 0..=10 {
            let above_c = all.min_c + (all.max_c - all.min_c) * f64::from(tenth) / 10.0 - 1e-3;
            check(&simulation.hot_spots(above_c), &slow_sizes(&simulation, 0..5, above_c));
            for layer in 0..5 {
                let spots = simulation.layer_hot_spots(layer, above_c);
                check(&spots, &slow_sizes(&simulation, layer..layer + 1, above_c));
                assert!(spots.largest.is_none_or(|spot| spot.peak[2] == layer));
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the same voxel is read twice")]
    fn the_peak_is_where_the_nozzle_is() {
        let simulation = half_printed(&stairs(13, 7, 3));
        let all = simulation.statistics().unwrap();
        let spot = simulation.hot_spots(all.max_c - 1e-3).largest.unwrap();
        assert_eq!((spot.voxels, spot.peak_c), (1, all.max_c));
        assert_eq!(simulation.temperature_c(spot.peak), Some(spot.peak_c));
        assert_eq!(spot.centre, spot.peak.map(f64::from));
        assert_eq!(simulation.hot_spots(all.max_c).count, 0);
        assert_eq!(simulation.layer_hot_spots(99, 0.0).count, 0);
    }
}
