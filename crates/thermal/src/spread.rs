//! How even temperatures are.

use std::ops::Range;

use crate::rows::is_active;
use crate::simulation::Simulation;

/// Mean, spread and extremes of some temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// How many temperatures, at least 1.
    pub count: usize,
    /// Their mean, °C.
    pub mean_c: f64,
    /// Their standard deviation, as of a whole population (by their number, not by one less), °C.
    pub std_c: f64,
    /// The lowest, °C.
    pub min_c: f64,
    /// The highest, °C.
    pub max_c: f64,
}

/// Sums that run side by side, as one sum would have to wait for each addition.
const LANES: usize = 8;

impl Spread {
    /// Of temperatures in °C; `None` if there are none.
    /// They are summed in their order, in two passes: the same temperatures give the same bits.
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
    /// Of all deposited voxels; `None` if there are none.
    /// Minus its standard deviation, at a layer's end, is the paper's reward for the layer (Kim et
    /// al. 2026).
    ///
    /// Two passes over the memory of all layers that are begun, in a fixed order: on every machine,
    /// the same temperatures give the same bits.
    pub fn spread(&self) -> Option<Spread> {
        self.spread_of(0..self.part().depth)
    }

    /// Of the deposited voxels of one layer; `None` if there are none.
    pub fn layer_spread(&self, layer: u32) -> Option<Spread> {
        let layer = layer as usize;
        self.spread_of(layer..layer.saturating_add(1))
    }

    fn spread_of(&self, layers: Range<usize>) -> Option<Spread> {
        let (mut counts, mut sums) = ([0; LANES], [0.0; LANES]);
        let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        self.lanes(layers.clone(), |lane, theta, active| {
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
        self.lanes(layers, |lane, theta, active| {
            let away = if active { f64::from(theta) - mean } else { 0.0 };
            squares[lane] += away * away;
        });
        let std_c = (squares.iter().sum::<f64>() / count as f64).sqrt();
        let ambient_c = self.process().ambient_c;
        let celsius = |theta: f32| f64::from(theta) + ambient_c;
        let min_c = celsius(low.into_iter().fold(f32::INFINITY, f32::min));
        let max_c = celsius(high.into_iter().fold(f32::NEG_INFINITY, f32::max));
        Some(Spread { count, mean_c: mean + ambient_c, std_c, min_c, max_c })
    }

    /// Shows every voxel of some layers, and the rim: its lane, its θ, and whether it is deposited.
    #[inline]
    fn lanes(&self, layers: Range<usize>, mut each: impl FnMut(usize, f32, bool)) {
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
    fn spread_of_a_few_numbers() {
        assert_eq!(Spread::of(Vec::new()), None);
        let one = Spread::of([7.0]).unwrap();
        assert_eq!(
            (one.count, one.mean_c, one.std_c, one.min_c, one.max_c),
            (1, 7.0, 0.0, 7.0, 7.0)
        );
        let few = Spread::of([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
        assert_eq!((few.mean_c, few.std_c, few.min_c, few.max_c), (5.0, 2.0, 2.0, 9.0));
    }

    fn assert_near(fast: Option<Spread>, slow: Option<Spread>) {
        let (Some(fast), Some(slow)) = (fast, slow) else { return assert_eq!(fast, slow) };
        assert_eq!((fast.count, fast.min_c, fast.max_c), (slow.count, slow.min_c, slow.max_c));
        assert!((fast.mean_c - slow.mean_c).abs() < 1e-9, "{fast:?} {slow:?}");
        assert!((fast.std_c - slow.std_c).abs() < 1e-9, "{fast:?} {slow:?}");
    }

    #[test]
    fn rows_tell_the_same_as_voxels() {
        let simulation = half_printed(&stairs(19, 7, 4));
        let layer = |z| simulation.layer_c(z).map(|(_, celsius)| celsius).collect::<Vec<_>>();
        for z in 0..4 {
            assert_near(simulation.layer_spread(z), Spread::of(layer(z)));
        }
        assert_eq!(simulation.layer_spread(3), None);
        assert_eq!(simulation.layer_spread(u32::MAX), None);
        assert_near(simulation.spread(), Spread::of((0..4).flat_map(layer)));
        assert_eq!(simulation.spread(), simulation.clone().spread());
    }

    #[test]
    fn nothing_deposited_has_no_spread() {
        let simulation = crate::testing::unprinted(stairs(5, 5, 2));
        assert_eq!(simulation.spread(), None);
    }
}
