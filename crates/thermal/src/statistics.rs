//! How uniform temperatures are.

use std::ops::Range;

use crate::rows::is_active;
use crate::simulation::Simulation;

/// Mean, standard deviation and extremes of a set of temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureStatistics {
    /// Number of temperatures, at least 1.
    pub count: usize,
    /// Mean, °C.
    pub mean_c: f64,
    /// Population standard deviation (the sum of squares is divided by the count), °C.
    pub std_c: f64,
    /// Minimum, °C.
    pub min_c: f64,
    /// Maximum, °C.
    pub max_c: f64,
}

/// Number of partial sums.
/// A single sum would have to wait for each addition to finish before the next.
const LANES: usize = 8;

impl TemperatureStatistics {
    /// Statistics of temperatures in °C; `None` if there are none.
    ///
    /// Two passes, summed in the order of the iterator: the same temperatures give the same bits.
    pub fn of<I>(celsius: I) -> Option<Self>
    where
        I: IntoIterator<Item = f64>,
        I::IntoIter: Clone,
    {
        let celsius = celsius.into_iter();
        let (mut count, mut sum, mut min_c, mut max_c) = (0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        celsius.clone().for_each(|celsius| {
            count += 1;
            sum += celsius;
            min_c = min_c.min(celsius);
            max_c = max_c.max(celsius);
        });
        if count == 0 {
            return None;
        }
        let mean_c = sum / count as f64;
        let mut squares = 0.0;
        celsius.for_each(|celsius| squares += (celsius - mean_c) * (celsius - mean_c));
        Some(Self { count, mean_c, std_c: (squares / count as f64).sqrt(), min_c, max_c })
    }
}

impl Simulation {
    /// Statistics of all deposited voxels; `None` if there are none.
    ///
    /// Minus the standard deviation at a layer's end is the paper's reward for that layer (Kim et
    /// al. 2026).
    /// Two passes over all layers up to the highest deposited voxel, summed in a fixed order: the
    /// same temperatures give the same bits on every machine.
    pub fn statistics(&self) -> Option<TemperatureStatistics> {
        self.statistics_of(0..self.part().depth)
    }

    /// Statistics of the deposited voxels of one layer; `None` if there are none.
    pub fn layer_statistics(&self, layer: u32) -> Option<TemperatureStatistics> {
        let layer = layer as usize;
        self.statistics_of(layer..layer.saturating_add(1))
    }

    fn statistics_of(&self, layers: Range<usize>) -> Option<TemperatureStatistics> {
        let (mut counts, mut sums) = ([0; LANES], [0.0; LANES]);
        let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        self.for_each_lane(layers.clone(), |lane, theta, active| {
            counts[lane] += usize::from(active);
            sums[lane] += f64::from(if active { theta } else { 0.0 });
            low[lane] = low[lane].min(if active { theta } else { f32::INFINITY });
            high[lane] = high[lane].max(if active { theta } else { f32::NEG_INFINITY });
        });
        let count: usize = counts.iter().sum();
        if count == 0 {
            return None;
        }
        let mean = sums.iter().sum::<f64>() / count as f64;
        let mut squares = [0.0; LANES];
        self.for_each_lane(layers, |lane, theta, active| {
            let deviation = if active { f64::from(theta) - mean } else { 0.0 };
            squares[lane] += deviation * deviation;
        });
        let std_c = (squares.iter().sum::<f64>() / count as f64).sqrt();
        let ambient_c = self.process().ambient_c;
        let celsius = |theta: f32| f64::from(theta) + ambient_c;
        let min_c = celsius(low.into_iter().fold(f32::INFINITY, f32::min));
        let max_c = celsius(high.into_iter().fold(f32::NEG_INFINITY, f32::max));
        Some(TemperatureStatistics { count, mean_c: mean + ambient_c, std_c, min_c, max_c })
    }

    /// Calls `each` for every voxel of some layers, halo included, with the partial sum it belongs
    /// to, its temperature above the ambient temperature, and whether it is deposited.
    #[inline]
    fn for_each_lane(&self, layers: Range<usize>, mut each: impl FnMut(usize, f32, bool)) {
        for row in self.rows(layers) {
            for (theta, faces) in row.theta.chunks_exact(LANES).zip(row.faces.chunks_exact(LANES)) {
                for lane in 0..LANES {
                    each(lane, theta[lane], is_active(faces[lane]));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{half_printed, stairs};

    #[test]
    fn statistics_of_a_few_numbers() {
        assert_eq!(TemperatureStatistics::of(Vec::new()), None);
        let one = TemperatureStatistics::of([7.0]).unwrap();
        assert_eq!(
            (one.count, one.mean_c, one.std_c, one.min_c, one.max_c),
            (1, 7.0, 0.0, 7.0, 7.0)
        );
        let few = TemperatureStatistics::of([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
        assert_eq!((few.mean_c, few.std_c, few.min_c, few.max_c), (5.0, 2.0, 2.0, 9.0));
    }

    fn assert_near(fast: Option<TemperatureStatistics>, slow: Option<TemperatureStatistics>) {
        let (Some(fast), Some(slow)) = (fast, slow) else { return assert_eq!(fast, slow) };
        assert_eq!((fast.count, fast.min_c, fast.max_c), (slow.count, slow.min_c, slow.max_c));
        assert!((fast.mean_c - slow.mean_c).abs() < 1e-9, "{fast:?} {slow:?}");
        assert!((fast.std_c - slow.std_c).abs() < 1e-9, "{fast:?} {slow:?}");
    }

    #[test]
    fn rows_give_the_same_statistics_as_voxels() {
        let simulation = half_printed(&stairs(19, 7, 4));
        let layer =
            |z| simulation.cell_temperatures_c(z).map(|(_, celsius)| celsius).collect::<Vec<_>>();
        for z in 0..4 {
            assert_near(simulation.layer_statistics(z), TemperatureStatistics::of(layer(z)));
        }
        assert_eq!(simulation.layer_statistics(3), None);
        assert_eq!(simulation.layer_statistics(u32::MAX), None);
        assert_near(simulation.statistics(), TemperatureStatistics::of((0..4).flat_map(layer)));
        assert_eq!(simulation.statistics(), simulation.clone().statistics());
    }

    #[test]
    fn no_deposited_voxel_has_no_statistics() {
        let simulation = crate::testing::unprinted(stairs(5, 5, 2));
        assert_eq!(simulation.statistics(), None);
    }
}
