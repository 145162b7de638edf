//! Which option each layer takes if all layers together have a time limit.

/// An option of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// What it costs.
    pub cost: f64,
    /// The time that it takes, s.
    pub seconds: f64,
}

/// Options of all layers, and the price of time at which they were taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Allotment {
    /// Index of each layer's option.
    pub taken: Vec<usize>,
    /// Cost that the last step of the allotment saved per second; 0 if every layer has its best
    /// option.
    pub price: f64,
}

/// Takes one option per layer, such that all together take at most `limit` seconds and cost little;
/// `None` if even the fastest options take longer, or a layer has none.
///
/// This is the multiple-choice knapsack problem.
/// Every layer begins with its fastest option and steps along the lower convex hull of its options;
/// steps are made in the order of what they save per second.
/// The result costs at most one step more than the minimum.
/// Options of infinite cost are never taken.
/// Takes O(n log n) for n options.
pub fn allot(layers: &[Vec<Choice>], limit: f64) -> Option<Allotment> {
    let hulls: Vec<Vec<usize>> = layers.iter().map(|options| hull(options)).collect();
    let mut taken: Vec<usize> =
        hulls.iter().map(|hull| hull.first().copied()).collect::<Option<_>>()?;
    let mut seconds: f64 =
        layers.iter().zip(&taken).map(|(options, &option)| options[option].seconds).sum();
    if seconds > limit {
        return None;
    }
    let mut steps = Vec::new();
    for (layer, hull) in hulls.iter().enumerate() {
        for pair in hull.windows(2) {
            let (from, to) = (layers[layer][pair[0]], layers[layer][pair[1]]);
            let longer = to.seconds - from.seconds;
            steps.push(((from.cost - to.cost) / longer, layer, pair[1], longer));
        }
    }
    // Stable: the steps of a layer, whose savings fall, stay in order.
    steps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut is_closed = vec![false; layers.len()];
    let mut price = 0.0;
    for (saving, layer, option, longer) in steps {
        if is_closed[layer] {
            continue;
        }
        if seconds + longer > limit {
            is_closed[layer] = true;
            price = f64::max(price, saving);
        } else {
            seconds += longer;
            taken[layer] = option;
        }
    }
    Some(Allotment { taken, price })
}

/// The options on the lower convex hull, from the fastest to the cheapest.
fn hull(options: &[Choice]) -> Vec<usize> {
    let is_known = |&option: &usize| options[option].cost.is_finite();
    let mut sorted: Vec<usize> = (0..options.len()).filter(is_known).collect();
    sorted.sort_by(|&a, &b| {
        let (a, b) = (options[a], options[b]);
        a.seconds.total_cmp(&b.seconds).then(a.cost.total_cmp(&b.cost))
    });
    let mut hull: Vec<usize> = Vec::new();
    for option in sorted {
        let next = options[option];
        if hull.last().is_some_and(|&last| options[last].cost <= next.cost) {
            continue;
        }
        while let [.., first, middle] = hull[..] {
            let (first, middle) = (options[first], options[middle]);
            let cross = (middle.seconds - first.seconds) * (next.cost - first.cost)
                - (middle.cost - first.cost) * (next.seconds - first.seconds);
            if cross > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(option);
    }
    hull
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::testing::unit;

    fn total(layers: &[Vec<Choice>], taken: &[usize]) -> (f64, f64) {
        let chosen = layers.iter().zip(taken).map(|(options, &option)| options[option]);
        chosen.fold((0.0, 0.0), |(cost, seconds), choice| {
            (cost + choice.cost, seconds + choice.seconds)
        })
    }

    /// The cheapest of all combinations within the limit.
    fn cheapest(layers: &[Vec<Choice>], limit: f64) -> Option<f64> {
        let Some((first, rest)) = layers.split_first() else {
            return (limit >= -1e-9).then_some(0.0);
        };
        let costs = first.iter().filter_map(|choice| {
            cheapest(rest, limit - choice.seconds).map(|cost| cost + choice.cost)
        });
        costs.min_by(f64::total_cmp)
    }

    #[test]
    fn allotments_are_within_one_step_of_the_cheapest() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
        for _ in 0..3000 {
            let count = 1 + rng.next_u64() as usize % 4;
            let layers: Vec<Vec<Choice>> = (0..count)
                .map(|_| {
                    let options = 1 + rng.next_u64() as usize % 5;
                    let mut choice = || Choice {
                        cost: (unit(&mut rng) * 8.0).round(),
                        seconds: (unit(&mut rng) * 8.0).round(),
                    };
                    (0..options).map(|_| choice()).collect()
                })
                .collect();
            let limit = (unit(&mut rng) * 8.0 * count as f64).round();
            let best = cheapest(&layers, limit);
            let Some(allotment) = allot(&layers, limit) else {
                assert_eq!(best, None);
                continue;
            };
            let (cost, seconds) = total(&layers, &allotment.taken);
            assert!(seconds <= limit);
            let best = best.expect("the allotment is within the limit");
            // No step of a hull saves more than the difference of the costs of its layer.
            let step = |options: &Vec<Choice>| {
                let costs = options.iter().map(|choice| choice.cost);
                costs.clone().fold(0.0, f64::max) - costs.fold(f64::INFINITY, f64::min)
            };
            let step = layers.iter().map(step).fold(0.0, f64::max);
            assert!(cost >= best && cost <= best + step, "{cost} {best} {step}");
        }
    }

    #[test]
    fn without_a_limit_every_layer_has_its_cheapest_option() {
        let layers = vec![
            vec![Choice { cost: 3.0, seconds: 1.0 }, Choice { cost: 1.0, seconds: 9.0 }],
            vec![Choice { cost: 2.0, seconds: 1.0 }, Choice { cost: 2.0, seconds: 5.0 }],
        ];
        let allotment = allot(&layers, f64::INFINITY);
        assert_eq!(allotment, Some(Allotment { taken: vec![1, 0], price: 0.0 }));
    }

    #[test]
    fn options_that_were_not_tried_are_never_taken() {
        let untried = Choice { cost: f64::INFINITY, seconds: 1.0 };
        let layers = vec![vec![untried, Choice { cost: 1.0, seconds: 2.0 }]];
        assert_eq!(allot(&layers, 3.0).map(|allotment| allotment.taken), Some(vec![1]));
        assert_eq!(allot(&layers, 1.5), None);
    }

    /// Seconds of the cheapest options at a price.
    fn seconds_at(layers: &[Vec<Choice>], price: f64) -> f64 {
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
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut unit = || unit(&mut rng);
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
            let price = allot(&layers, limit).expect("the fastest options fit").price;
            if price > 0.0 {
                priced += 1;
                assert!(seconds_at(&layers, price * (1.0 - 1e-3)) > limit);
            }
            assert!(seconds_at(&layers, price * (1.0 + 1e-3)) <= limit);
        }
        assert!(priced > 500, "{priced}");
    }
}
