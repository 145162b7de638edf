//! What a second of printing time is worth under a limit.

/// An option of a layer: what it costs, K, and the time that it takes, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    pub(super) cost: f64,
    pub(super) seconds: f64,
}

/// Relative width at which the bisection of the price ends.
const PRECISION: f64 = 1e-6;

/// The price of time, K/s, below which the options that are cheapest, price included, take more
/// than `limit_s` seconds in all layers together; 0 if the cheapest options are within the limit.
///
/// It is the Lagrange multiplier of the limit.
/// The fastest options must be within the limit.
/// Takes O(n) for n options.
pub(super) fn time_price(layers: &[Vec<Choice>], limit_s: f64) -> f64 {
    let exceeds = |price: f64| {
        let score = |choice: &&Choice| choice.cost + price * choice.seconds;
        let cheapest = |choices: &Vec<Choice>| {
            let by_score = |a: &&Choice, b: &&Choice| {
                score(a).total_cmp(&score(b)).then(a.seconds.total_cmp(&b.seconds))
            };
            choices.iter().min_by(by_score).map_or(0.0, |choice| choice.seconds)
        };
        layers.iter().map(cheapest).sum::<f64>() > limit_s
    };
    if !exceeds(0.0) {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1e-6);
    while exceeds(high) {
        // No difference of costs is worth so much: only rounding is beyond the limit.
        if high > 1e12 {
            return high;
        }
        low = high;
        high *= 2.0;
    }
    while high - low > PRECISION * high {
        let middle = f64::midpoint(low, high);
        if exceeds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Seconds of the cheapest options at a price.
    fn seconds(layers: &[Vec<Choice>], price: f64) -> f64 {
        let score = |choice: &Choice| (choice.cost + price * choice.seconds, choice.seconds);
        let cheapest = |choices: &Vec<Choice>| {
            let mut scores: Vec<(f64, f64)> = choices.iter().map(score).collect();
            scores.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            scores[0].1
        };
        layers.iter().map(cheapest).sum()
    }

    #[test]
    fn the_price_is_where_the_cheapest_options_meet_the_limit() {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut unit = || (rng.next_u64() >> 12) as f64 / (1_u64 << 52) as f64;
        let mut priced = 0;
        for _ in 0..2000 {
            let count = 1 + (unit() * 4.0) as usize;
            let layers: Vec<Vec<Choice>> = (0..count)
                .map(|_| {
                    let options = 1 + (unit() * 5.0) as usize;
                    let mut choice = || Choice { cost: unit() * 8.0, seconds: 1.0 + unit() * 8.0 };
                    (0..options).map(|_| choice()).collect()
                })
                .collect();
            let fastest = |choices: &Vec<Choice>| {
                choices.iter().map(|choice| choice.seconds).fold(f64::INFINITY, f64::min)
            };
            let fastest: f64 = layers.iter().map(fastest).sum();
            let limit = fastest + 1e-9 + unit() * 4.0;
            let price = time_price(&layers, limit);
            if price > 0.0 {
                priced += 1;
                assert!(seconds(&layers, price * (1.0 - 1e-3)) > limit);
            }
            assert!(seconds(&layers, price * (1.0 + 1e-3)) <= limit);
        }
        assert!(priced > 500, "{priced}");
    }
}
