//! The colour scale of temperatures.

/// The colour map `plasma` of matplotlib (CC0) at equal steps.
/// It is perceptually uniform with any colour vision, and its lightness rises, so that it also
/// works in greyscale.
const STOPS: [[u8; 3]; 9] = [
    [13, 8, 135],
    [76, 2, 161],
    [126, 3, 168],
    [170, 35, 149],
    [204, 71, 120],
    [230, 108, 92],
    [248, 149, 64],
    [253, 197, 39],
    [240, 249, 33],
];

/// Maximum share of voxels, the hottest ones, that may exceed the scale.
/// Voxels that were just deposited are so hot that, on a scale that includes them, all others would
/// look alike.
const BEYOND: f64 = 0.005;

/// The hottest voxels exceed the scale only if including them would lengthen it by more than this
/// factor.
const STRETCH: f64 = 1.3;

/// The range of temperatures of a colour scale, in °C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Temperature of the first colour.
    pub low_c: f64,
    /// Temperature of the last colour.
    pub high_c: f64,
    /// Whether some voxels are hotter; they have the last colour.
    pub is_exceeded: bool,
}

impl Scale {
    /// A scale for all of these temperatures in °C.
    pub fn of(celsius: impl Iterator<Item = f32>) -> Self {
        let mut all: Vec<f32> = celsius.collect();
        all.sort_unstable_by(f32::total_cmp);
        let (Some(&low), Some(&last)) = (all.first(), all.last()) else {
            return Self { low_c: 0.0, high_c: 1.0, is_exceeded: false };
        };
        let [low_c, most_c] = [low, last].map(f64::from);
        let nearly_c = f64::from(all[((all.len() - 1) as f64 * (1.0 - BEYOND)) as usize]);
        let is_exceeded = nearly_c > low_c && most_c - low_c > STRETCH * (nearly_c - low_c);
        let high_c = if is_exceeded { nearly_c } else { most_c };
        // A single temperature still needs a range.
        Self { low_c, high_c: high_c.max(low_c + 0.1), is_exceeded }
    }

    /// The colour of a temperature.
    pub fn colour(&self, celsius: f64) -> [u8; 3] {
        colour((celsius - self.low_c) / (self.high_c - self.low_c))
    }

    /// Round temperatures that divide the scale into a few parts, and their number of decimals.
    pub(super) fn ticks(&self) -> (Vec<f64>, usize) {
        ticks(self.low_c, self.high_c, 5.0)
    }
}

/// The colour of a share of the scale, from 0 to 1.
pub(super) fn colour(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let stop = (at as usize).min(STOPS.len() - 2);
    let between = |i: usize| {
        let [a, b] = [STOPS[stop][i], STOPS[stop + 1][i]].map(f64::from);
        (a + (b - a) * (at - stop as f64)).round() as u8
    };
    [between(0), between(1), between(2)]
}

/// About `about` round numbers from `low` to `high`, and their number of decimals.
pub(super) fn ticks(low: f64, high: f64, about: f64) -> (Vec<f64>, usize) {
    let rough = (high - low) / about;
    let power = 10_f64.powf(rough.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|&step| step >= rough);
    let step = step.unwrap_or(10.0 * power);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    ((first..=last).map(|tick| tick as f64 * step).collect(), decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hotter_is_lighter() {
        let light = |share: f64| {
            let [red, green, blue] = colour(share).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        assert!(
            (0..100).all(|i| light(f64::from(i) / 100.0) <= light(f64::from(i + 1) / 100.0) + 0.5)
        );
        assert_eq!((colour(-1.0), colour(2.0)), (STOPS[0], STOPS[8]));
    }

    #[test]
    fn ticks_are_round() {
        let near = |(found, decimals): (Vec<f64>, usize), expected: &[f64], places: usize| {
            assert_eq!(decimals, places);
            assert_eq!(found.len(), expected.len(), "{found:?}");
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        };
        near(ticks(78.3, 121.0, 5.0), &[80.0, 90.0, 100.0, 110.0, 120.0], 0);
        near(ticks(0.0, 60.0, 5.0), &[0.0, 20.0, 40.0, 60.0], 0);
        near(ticks(80.0, 80.1, 5.0), &[80.0, 80.02, 80.04, 80.06, 80.08, 80.1], 2);
    }

    #[test]
    fn a_few_hot_voxels_do_not_stretch_the_scale() {
        let temperatures =
            |hot: f32| (0..1000).map(move |x| if x == 0 { hot } else { 80.0 + x as f32 / 100.0 });
        let hot = Scale::of(temperatures(230.0));
        assert!(hot.is_exceeded && hot.high_c < 90.0);
        let even = Scale::of(temperatures(90.0));
        assert!(!even.is_exceeded && even.high_c >= 89.9);
        assert_eq!(hot.colour(230.0), STOPS[8]);
    }
}
