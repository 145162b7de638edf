//! Temperatures that are as even as their lower limits permit.

/// The smallest possible sum of squared differences from `mean`, of temperatures with that mean
/// that are nowhere below `floors`, K².
///
/// Temperatures at their floors are as low as they can be; all others are equal, as evenly spread
/// heat makes them.
/// If the floors' own mean is higher, no temperatures have the mean, and the floors themselves are
/// taken.
/// Sorts the floors; O(n log n).
pub(super) fn min_squares(floors: &mut [f64], mean: f64) -> f64 {
    floors.sort_by(|a, b| b.total_cmp(a));
    let count = floors.len() as f64;
    let total = mean * count;
    // The highest floors stay, and the others are raised to the level that what is left gives them.
    let (mut kept, mut kept_sum) = (0, 0.0);
    let mut level = mean;
    for (index, &floor) in floors.iter().enumerate() {
        if floor <= level {
            break;
        }
        (kept, kept_sum) = (index + 1, kept_sum + floor);
        let left = floors.len() - kept;
        level = if left == 0 { f64::NEG_INFINITY } else { (total - kept_sum) / left as f64 };
    }
    let square = |theta: f64| (theta - mean) * (theta - mean);
    let lowest = floors.last().copied().unwrap_or(mean);
    if level < lowest {
        return floors.iter().map(|&floor| square(floor)).sum();
    }
    let raised = (floors.len() - kept) as f64 * square(level);
    floors[..kept].iter().map(|&floor| square(floor)).fold(raised, |sum, square| sum + square)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::testing::unit;

    /// Temperatures by bisection of the level that everything is raised to.
    fn slow(floors: &[f64], mean: f64) -> f64 {
        let raised = |level: f64| floors.iter().map(move |&floor| floor.max(level));
        let (mut low, mut high) = (-1e3, 1e3);
        for _ in 0..200 {
            let level = f64::midpoint(low, high);
            if raised(level).sum::<f64>() > mean * floors.len() as f64 {
                high = level;
            } else {
                low = level;
            }
        }
        raised(low).map(|theta| (theta - mean).powi(2)).sum()
    }

    #[test]
    fn the_level_is_that_of_a_bisection() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for _ in 0..3000 {
            let count = 1 + (unit(&mut rng) * 12.0) as usize;
            let mut floors: Vec<f64> = (0..count).map(|_| (unit(&mut rng) * 9.0).round()).collect();
            let mean = unit(&mut rng) * 10.0;
            let expected = slow(&floors, mean);
            let squares = min_squares(&mut floors, mean);
            assert!((squares - expected).abs() < 1e-6, "{floors:?} {mean}: {squares} {expected}");
        }
        assert!(min_squares(&mut [], 3.0).abs() < f64::EPSILON);
    }

    #[test]
    fn no_temperatures_above_the_floors_are_more_even() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        for _ in 0..1000 {
            let floors: Vec<f64> = (0..5).map(|_| unit(&mut rng) * 9.0).collect();
            let theta: Vec<f64> =
                floors.iter().map(|floor| floor + 6.0 * unit(&mut rng).powi(3)).collect();
            let mean = theta.iter().sum::<f64>() / 5.0;
            let squares: f64 = theta.iter().map(|theta| (theta - mean).powi(2)).sum();
            assert!(min_squares(&mut floors.clone(), mean) <= squares + 1e-9);
        }
    }
}
