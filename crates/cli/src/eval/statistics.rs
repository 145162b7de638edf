//! Means, and how sure they are.

/// The mean; not a number if there are no values.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// A mean with its confidence interval of 95 %: it lies within `half_width` of `mean`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) mean: f64,
    /// Infinite for a single value.
    pub(super) half_width: f64,
}

impl Interval {
    /// By Student's t distribution.
    pub(super) fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = mean(values.iter().copied());
        if values.len() < 2 {
            return Self { mean, half_width: f64::INFINITY };
        }
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let deviation = (squares / (count - 1.0)).sqrt();
        Self { mean, half_width: quantile(count - 1.0) * deviation / count.sqrt() }
    }

    /// Whether 0 lies outside.
    pub(super) fn tells(&self) -> bool {
        self.mean.abs() > self.half_width
    }
}

/// The quantile 0.975 of Student's t distribution, by its expansion around the normal one (Abramowitz and Stegun, 26.7.5): to 0.3 % from 5 degrees of freedom on.
fn quantile(freedom: f64) -> f64 {
    let z = 1.959_964_f64;
    let powers = [z, z.powi(3), z.powi(5), z.powi(7)];
    let first = (powers[1] + powers[0]) / 4.0;
    let second = (5.0 * powers[2] + 16.0 * powers[1] + 3.0 * powers[0]) / 96.0;
    let third = (3.0 * powers[3] + 19.0 * powers[2] + 17.0 * powers[1] - 15.0 * powers[0]) / 384.0;
    z + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, expected) in [(5.0, 2.5706), (9.0, 2.2622), (29.0, 2.0452), (99.0, 1.9842)] {
            assert!((quantile(freedom) / expected - 1.0).abs() < 0.003, "{freedom}: {}", quantile(freedom));
        }
    }

    #[test]
    fn intervals_hold_the_mean() {
        let interval = Interval::of(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        // t(4) = 2.776, standard error 0.7071.
        assert!((interval.half_width / (2.776 / 2_f64.sqrt()) - 1.0).abs() < 0.01 && interval.tells());
        assert!((interval.mean - 3.0).abs() < 1e-9);
        assert!(!Interval::of(&[4.0]).tells() && !Interval::of(&[-1.0, 1.0]).tells());
        assert_eq!(Interval::of(&[2.0, 2.0]), Interval { mean: 2.0, half_width: 0.0 });
    }
}
