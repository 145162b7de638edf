//! Means, their confidence intervals, medians, and rank correlations.

use std::fmt;

/// Mean; not a number if there are no values.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Median; the upper one of the two central values if their number is even.
///
/// # Panics
/// If there are no values.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Spearman's rank correlation: the correlation of ranks, where equal values share their mean rank.
///
/// Not a number if all values of one side are equal, or there are none.
pub(crate) fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let (mean_a, mean_b) = (mean(a.iter().copied()), mean(b.iter().copied()));
    let (mut product, mut square_a, mut square_b) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(&b) {
        let (a, b) = (a - mean_a, b - mean_b);
        product += a * b;
        square_a += a * a;
        square_b += b * b;
    }
    product / (square_a * square_b).sqrt()
}

/// For each value, half of the number of smaller values and of those that are not larger.
fn ranks(values: &[f64]) -> Vec<f64> {
    let rank = |value: &f64| {
        let smaller = values.iter().filter(|&other| other < value).count();
        let not_larger = values.iter().filter(|&other| other <= value).count();
        (smaller + not_larger) as f64 / 2.0
    };
    values.iter().map(rank).collect()
}

/// A mean with its 95 % confidence interval, from `mean - half_width` to `mean + half_width`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) mean: f64,
    /// Infinite if there are too few values to estimate the variance.
    pub(crate) half_width: f64,
}

impl Interval {
    /// Confidence interval of the mean of the groups' means, by Student's t distribution.
    ///
    /// The groups are strata: each is a sample of its own, so only the variance within the groups
    /// counts, not the differences between their means.
    /// The variance is the sum of the squared standard errors of the groups' means, divided by the
    /// square of the number of groups; each group contributes its size minus 1 degrees of freedom.
    pub(crate) fn of(groups: &[Vec<f64>]) -> Self {
        let means: Vec<f64> = groups.iter().map(|group| mean(group.iter().copied())).collect();
        let count = groups.len() as f64;
        let (mut variance, mut freedom) = (0.0, 0.0);
        for (group, mean) in groups.iter().zip(&means) {
            let size = group.len() as f64;
            let squares: f64 = group.iter().map(|value| (value - mean) * (value - mean)).sum();
            variance += squares / (size - 1.0).max(0.0) / size / (count * count);
            freedom += size - 1.0;
        }
        let half_width = if freedom >= 1.0 && variance.is_finite() {
            quantile(freedom) * variance.sqrt()
        } else {
            f64::INFINITY
        };
        Self { mean: mean(means.into_iter()), half_width }
    }

    /// Whether 0 lies outside the interval.
    pub(crate) fn excludes_zero(&self) -> bool {
        self.mean.abs() > self.half_width
    }
}

/// Prints, for example, `0.41 +- 0.12`.
impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.half_width.is_finite() {
            write!(f, "{:.2} +- {:.2}", self.mean, self.half_width)
        } else {
            write!(f, "{:.2}", self.mean)
        }
    }
}

/// The quantile 0.975 of Student's t distribution.
///
/// A table gives it for up to 4 degrees of freedom.
/// From 5 on it is expanded around the quantile of the normal distribution (Abramowitz and Stegun,
/// 26.7.5), with an error below 0.3 %.
fn quantile(freedom: f64) -> f64 {
    const TABLE: [f64; 4] = [12.706, 4.303, 3.182, 2.776];

    if let Some(&quantile) = TABLE.get(freedom as usize - 1) {
        return quantile;
    }
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
    fn median_of_an_even_number_of_values_is_the_upper_one() {
        let median_is =
            |values: &[f64], expected: f64| median(values.to_vec()).total_cmp(&expected).is_eq();
        assert!(median_is(&[3.0, 1.0, 2.0], 2.0));
        assert!(median_is(&[4.0, 1.0, 3.0, 2.0], 3.0));
    }

    #[test]
    fn rank_correlations_ignore_scale_and_share_ranks() {
        let is = |a: &[f64], b: &[f64], expected: f64| {
            let rho = rank_correlation(a, b);
            assert!((rho - expected).abs() < 1e-12, "{rho}");
        };
        is(&[1.0, 2.0, 3.0], &[1.0, 10.0, 1e6], 1.0);
        is(&[1.0, 2.0, 3.0], &[3.0, 2.0, -1.0], -1.0);
        // Without ties, 1 - 6 Σ d² / (n (n² - 1)).
        is(&[1.0, 2.0, 3.0, 4.0, 5.0], &[2.0, 1.0, 4.0, 3.0, 5.0], 1.0 - 6.0 * 4.0 / 120.0);
        // The ranks of 1, 1, 2 are 1.5, 1.5 and 3.
        is(&[1.0, 1.0, 2.0], &[1.0, 2.0, 3.0], 0.75_f64.sqrt());
        assert!(rank_correlation(&[1.0, 1.0], &[1.0, 2.0]).is_nan());
        assert!(rank_correlation(&[], &[]).is_nan());
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        let table = [
            (1.0, 12.706),
            (3.0, 3.182),
            (5.0, 2.5706),
            (9.0, 2.2622),
            (29.0, 2.0452),
            (99.0, 1.9842),
        ];
        for (freedom, expected) in table {
            assert!(
                (quantile(freedom) / expected - 1.0).abs() < 0.003,
                "{freedom}: {}",
                quantile(freedom)
            );
        }
    }

    #[test]
    fn interval_of_one_group_is_that_of_its_mean() {
        let interval = Interval::of(&[vec![1.0, 2.0, 3.0, 4.0, 5.0]]);
        // t(4) = 2.776, standard error 1 / sqrt(2).
        assert!((interval.half_width / (2.776 / 2_f64.sqrt()) - 1.0).abs() < 1e-9);
        assert!((interval.mean - 3.0).abs() < 1e-9);
        assert!(interval.excludes_zero());
        assert!(!Interval::of(&[vec![4.0]]).excludes_zero());
        assert!(!Interval::of(&[vec![-1.0, 1.0]]).excludes_zero());
        assert_eq!(Interval::of(&[vec![2.0, 2.0]]), Interval { mean: 2.0, half_width: 0.0 });
        assert_eq!(
            (Interval::of(&[vec![4.0]]).to_string(), Interval::of(&[vec![1.0; 3]]).to_string()),
            ("4.00".into(), "1.00 +- 0.00".into())
        );
    }

    #[test]
    fn distance_between_groups_does_not_widen_the_interval() {
        let near = Interval::of(&[vec![1.0, 3.0], vec![1.0, 3.0]]);
        let apart = Interval::of(&[vec![1.0, 3.0], vec![101.0, 103.0]]);
        assert!((near.half_width - apart.half_width).abs() < 1e-9);
        // The standard error is 1 for each of the two groups, so 1 / sqrt(2) for their mean, with 2
        // degrees of freedom.
        assert!(
            (apart.mean - 52.0).abs() < 1e-9
                && (near.half_width - 4.303 / 2_f64.sqrt()).abs() < 1e-9
        );
    }
}
