//! Where heat gathers.

use std::ops::Range;

use crate::simulation::Simulation;

/// The groups of deposited voxels that are hotter than some temperature.
/// Voxels of a group hang together by faces.
#[derive(Clone, Debug, PartialEq)]
pub struct HotSpots {
    /// They are hotter than this, °C.
    pub above_c: f64,
    /// How many voxels are that hot.
    pub voxels: usize,
    /// How many groups they form.
    pub count: usize,
    /// The group of most voxels, among equals that with the higher peak; `None` if there is no
    /// group.
    pub largest: Option<HotSpot>,
}

/// A group of hot voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotSpot {
    /// How many.
    pub voxels: usize,
    /// Their mean x, y and z, in voxels: a single voxel is its own centre.
    /// May lie outside a bent group.
    pub centre: [f64; 3],
    /// x, y and z of the hottest of them.
    pub peak: [u32; 3],
    /// How hot that one is, °C.
    pub peak_c: f64,
}

impl Simulation {
    /// The groups of voxels hotter than so many °C, for example
    /// [`crate::Material::glass_transition_c`], in the whole part.
    /// Linear in the box around the part.
    pub fn hot_spots(&self, above_c: f64) -> HotSpots {
        self.hot_spots_of(0..self.part().depth, above_c)
    }

    /// The same in one layer: voxels that hang together through other layers alone are apart.
    /// Linear in the layer's plane.
    pub fn layer_hot_spots(&self, layer: u32, above_c: f64) -> HotSpots {
        let layer = layer as usize;
        self.hot_spots_of(layer..layer.saturating_add(1), above_c)
    }

    fn hot_spots_of(&self, layers: Range<usize>, above_c: f64) -> HotSpots {
        let frame = &self.part().frame;
        let layers = layers.start..layers.end.min(self.part().depth);
        let grid = Grid {
            sizes: [frame.width, frame.height, layers.len() as u32],
            lowest: layers.start as u32,
        };
        let hot: Vec<([u32; 3], f64)> =
            self.deposited(layers).filter(|&(_, celsius)| celsius > above_c).collect();
        if hot.is_empty() {
            return HotSpots { above_c, voxels: 0, count: 0, largest: None };
        }
        // NaN stands for voxels that are not hot, or are in a group already.
        let mut free = vec![f64::NAN; grid.sizes.iter().map(|&size| size as usize).product()];
        hot.iter().for_each(|&(voxel, celsius)| free[grid.index(voxel)] = celsius);
        let mut spots = HotSpots { above_c, voxels: hot.len(), count: 0, largest: None };
        for &(voxel, _) in &hot {
            if free[grid.index(voxel)].is_nan() {
                continue;
            }
            let spot = grid.take(voxel, &mut free);
            spots.count += 1;
            let rank = |spot: &HotSpot| (spot.voxels, spot.peak_c);
            if spots.largest.as_ref().is_none_or(|largest| rank(largest) < rank(&spot)) {
                spots.largest = Some(spot);
            }
        }
        spots
    }
}

/// Some layers of a part.
#[derive(Clone, Copy)]
struct Grid {
    /// Width, height and layers.
    sizes: [u32; 3],
    /// Number of the lowest layer.
    lowest: u32,
}

impl Grid {
    fn index(self, [x, y, z]: [u32; 3]) -> usize {
        let [width, height, _] = self.sizes.map(|size| size as usize);
        ((z - self.lowest) as usize * height + y as usize) * width + x as usize
    }

    /// Those of the six neighbours that are inside.
    fn neighbours(self, voxel: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
        let least = [0, 0, self.lowest];
        (0..3).flat_map(move |axis: usize| {
            let (i, end) = (voxel[axis], least[axis] + self.sizes[axis]);
            let at = move |i| {
                let mut voxel = voxel;
                voxel[axis] = i;
                voxel
            };
            let before = (i > least[axis]).then(|| at(i - 1));
            before.into_iter().chain((i + 1 < end).then(|| at(i + 1)))
        })
    }

    /// Takes the group of a voxel out of those that are free.
    fn take(self, first: [u32; 3], free: &mut [f64]) -> HotSpot {
        let (mut voxels, mut sums, mut peak, mut peak_c) = (0, [0; 3], first, f64::NEG_INFINITY);
        let mut open = vec![(first, std::mem::replace(&mut free[self.index(first)], f64::NAN))];
        while let Some((voxel, celsius)) = open.pop() {
            voxels += 1;
            (0..3).for_each(|axis| sums[axis] += u64::from(voxel[axis]));
            if celsius > peak_c {
                (peak, peak_c) = (voxel, celsius);
            }
            for next in self.neighbours(voxel) {
                let celsius = std::mem::replace(&mut free[self.index(next)], f64::NAN);
                if !celsius.is_nan() {
                    open.push((next, celsius));
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

    /// Lets each voxel take the least label of its neighbours until none changes; sizes of groups,
    /// rising.
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
    fn groups_are_those_of_the_slow_way() {
        let simulation = half_printed(&stairs(13, 7, 5));
        let spread = simulation.spread().unwrap();
        for part in 0..=10 {
            let above_c =
                spread.min_c + (spread.max_c - spread.min_c) * f64::from(part) / 10.0 - 1e-3;
            check(&simulation.hot_spots(above_c), &slow_sizes(&simulation, 0..5, above_c));
            for layer in 0..5 {
                let spots = simulation.layer_hot_spots(layer, above_c);
                check(&spots, &slow_sizes(&simulation, layer..layer + 1, above_c));
                assert!(spots.largest.is_none_or(|spot| spot.peak[2] == layer));
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the last voxel is held, one reading gives one number")]
    fn the_peak_is_where_the_nozzle_is() {
        let simulation = half_printed(&stairs(13, 7, 3));
        let spread = simulation.spread().unwrap();
        let spot = simulation.hot_spots(spread.max_c - 1e-3).largest.unwrap();
        assert_eq!((spot.voxels, spot.peak_c), (1, spread.max_c));
        assert_eq!(simulation.temperature_c(spot.peak), Some(spot.peak_c));
        assert_eq!(spot.centre, spot.peak.map(f64::from));
        assert_eq!(simulation.hot_spots(spread.max_c).count, 0);
        assert_eq!(simulation.layer_hot_spots(99, 0.0).count, 0);
    }
}
