//! Which way of printing each layer takes: a shortest way through the layers.

use super::ToolCosts;

/// A way to print a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Way {
    /// The tool it begins with.
    pub(super) first: u8,
    /// The tool it ends with.
    pub(super) last: u8,
    /// Cost of the tool changes within.
    pub(super) cost: u64,
    /// Breaks between its pieces.
    pub(super) lifts: u64,
}

/// What a unit of tool cost and a lift weigh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Weights {
    pub(super) tools: u64,
    pub(super) lifts: u64,
}

/// A choice of ways.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Chosen {
    /// For each layer the number of its way.
    pub(super) ways: Vec<usize>,
    /// Cost of all tool changes, those between layers included.
    pub(super) cost: u64,
    /// All lifts.
    pub(super) lifts: u64,
}

/// The choice of least weight; `None` if some layer has no way, or the first none that begins with
/// `first`.
///
/// What follows a layer depends on its last tool alone.
/// O(l w t) steps for l layers of w ways with t tools at their ends.
pub(super) fn choose(
    layers: &[Vec<Way>],
    costs: &ToolCosts,
    first: Option<u8>,
    weights: Weights,
) -> Option<Chosen> {
    if layers.iter().any(Vec::is_empty) {
        return None;
    }
    // Forwards: for each layer and each of its ways the least weight up to its end, and the way
    // before.
    let mut table: Vec<Vec<(u128, usize)>> = Vec::with_capacity(layers.len());
    for (number, ways) in layers.iter().enumerate() {
        // Of the ways before only the best for each last tool counts.
        let mut ends: Vec<(u8, u128, usize)> = Vec::new();
        if let Some(before) = table.last() {
            for (at, (way, &(weight, _))) in layers[number - 1].iter().zip(before).enumerate() {
                match ends.iter_mut().find(|(tool, ..)| *tool == way.last) {
                    Some(end) if weight < end.1 => *end = (way.last, weight, at),
                    Some(_) => {}
                    None => ends.push((way.last, weight, at)),
                }
            }
        }
        let weigh = |way: &Way| {
            let own = u128::from(weights.tools) * u128::from(way.cost)
                + u128::from(weights.lifts) * u128::from(way.lifts);
            if number == 0 {
                let is_allowed = first.is_none_or(|first| first == way.first);
                return is_allowed.then_some((own, 0));
            }
            let step =
                |tool: u8| u128::from(weights.tools) * u128::from(costs.cost(tool, way.first));
            ends.iter().map(|&(tool, weight, at)| (weight + step(tool) + own, at)).min()
        };
        // A way that is not allowed weighs more than any other could.
        table.push(ways.iter().map(|way| weigh(way).unwrap_or((u128::MAX / 2, 0))).collect());
    }
    let mut ways = vec![0; layers.len()];
    for number in (0..layers.len()).rev() {
        ways[number] = if number + 1 == layers.len() {
            (0..table[number].len())
                .min_by_key(|&at| table[number][at].0)
                .expect("every layer has a way")
        } else {
            table[number + 1][ways[number + 1]].1
        };
    }
    let way = |number: usize| &layers[number][ways[number]];
    if !layers.is_empty() && first.is_some_and(|first| first != way(0).first) {
        return None;
    }
    let within: u64 = (0..layers.len()).map(|number| way(number).cost).sum();
    let between: u64 = (1..layers.len())
        .map(|number| u64::from(costs.cost(way(number - 1).last, way(number).first)))
        .sum();
    let lifts = (0..layers.len()).map(|number| way(number).lifts).sum();
    Some(Chosen { ways, cost: within + between, lifts })
}

/// Points of a frontier beyond which no more are sought.
const MOST_POINTS: usize = 256;

/// The choices that are the cheapest at some price of a lift, from few lifts to cheap tools: the
/// corners of the convex hull, up to 256 of them.
pub(super) fn frontier(layers: &[Vec<Way>], costs: &ToolCosts, first: Option<u8>) -> Vec<Chosen> {
    // So much more than the other that only ties are left to it.
    let more = 1 << 40;
    let at = |tools: u64, lifts: u64| choose(layers, costs, first, Weights { tools, lifts });
    let (Some(few_lifts), Some(cheap_tools)) = (at(1, more), at(more, 1)) else {
        return Vec::new();
    };
    let mut points = vec![few_lifts];
    let mut rest = vec![cheap_tools];
    while let Some(next) = rest.last() {
        let here = points.last().expect("it begins with one");
        if (here.cost, here.lifts) == (next.cost, next.lifts) {
            rest.pop();
            continue;
        }
        // The price at which both are as good; what is better lies between.
        let weights = Weights {
            tools: next.lifts.saturating_sub(here.lifts),
            lifts: here.cost.saturating_sub(next.cost),
        };
        let weight = |point: &Chosen| {
            u128::from(weights.tools) * u128::from(point.cost)
                + u128::from(weights.lifts) * u128::from(point.lifts)
        };
        let between =
            choose(layers, costs, first, weights).filter(|between| weight(between) < weight(here));
        match between {
            Some(between) if points.len() + rest.len() < MOST_POINTS => rest.push(between),
            _ => points.extend(rest.pop()),
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn draw(rng: &mut Xoshiro256PlusPlus) -> (Vec<Vec<Way>>, ToolCosts) {
        let tools = rng.random_range(1..=3_u8);
        let row = |from: u8, rng: &mut Xoshiro256PlusPlus| {
            (0..tools)
                .map(|to| if to == from { 0 } else { rng.random_range(0..9) })
                .collect::<Vec<u32>>()
        };
        let costs =
            ToolCosts::new(&(0..tools).map(|from| row(from, rng)).collect::<Vec<_>>()).unwrap();
        let way = |rng: &mut Xoshiro256PlusPlus| Way {
            first: rng.random_range(0..tools),
            last: rng.random_range(0..tools),
            cost: rng.random_range(0..10),
            lifts: rng.random_range(0..6),
        };
        let layers = (0..rng.random_range(1..5))
            .map(|_| (0..rng.random_range(1..4)).map(|_| way(rng)).collect());
        (layers.collect(), costs)
    }

    /// Cost and lifts of every choice.
    fn all(layers: &[Vec<Way>], costs: &ToolCosts, first: Option<u8>) -> Vec<(u64, u64)> {
        let mut sums: Vec<(Option<u8>, u64, u64)> = vec![(None, 0, 0)];
        for ways in layers {
            let on = |&(tool, cost, lifts): &(Option<u8>, u64, u64)| {
                let allowed = ways.iter().filter(move |way| {
                    tool.is_some() || first.is_none_or(|first| first == way.first)
                });
                let step =
                    move |way: &Way| tool.map_or(0, |tool| u64::from(costs.cost(tool, way.first)));
                allowed
                    .map(move |way| {
                        (Some(way.last), cost + way.cost + step(way), lifts + way.lifts)
                    })
                    .collect::<Vec<_>>()
            };
            sums = sums.iter().flat_map(on).collect();
        }
        sums.into_iter().map(|(_, cost, lifts)| (cost, lifts)).collect()
    }

    #[test]
    fn the_choice_is_the_best_of_all() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        for _ in 0..3000 {
            let (layers, costs) = draw(&mut rng);
            let first = rng.random_bool(0.3).then_some(0);
            let weights = Weights { tools: rng.random_range(0..4), lifts: rng.random_range(0..4) };
            let weight = |cost: u64, lifts: u64| weights.tools * cost + weights.lifts * lifts;
            let best = all(&layers, &costs, first)
                .into_iter()
                .map(|(cost, lifts)| weight(cost, lifts))
                .min();
            let chosen = choose(&layers, &costs, first, weights);
            assert_eq!(chosen.map(|chosen| weight(chosen.cost, chosen.lifts)), best);
        }
    }

    #[test]
    fn a_layer_without_ways_has_no_choice() {
        let way = Way { first: 0, last: 0, cost: 0, lifts: 0 };
        let weights = Weights { tools: 1, lifts: 1 };
        let costs = ToolCosts::uniform(1);
        assert_eq!(choose(&[vec![way], vec![], vec![way]], &costs, None, weights), None);
        assert_eq!(
            choose(&[vec![way], vec![way]], &costs, None, weights).map(|chosen| chosen.cost),
            Some(0)
        );
    }

    #[test]
    fn the_frontier_is_the_hull_of_all_choices() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        for _ in 0..1000 {
            let (layers, costs) = draw(&mut rng);
            let points = frontier(&layers, &costs, None);
            let all = all(&layers, &costs, None);
            assert!(
                points
                    .windows(2)
                    .all(|pair| pair[0].lifts < pair[1].lifts && pair[0].cost > pair[1].cost)
            );
            assert!(points.iter().all(|point| all.contains(&(point.cost, point.lifts))));
            for price in [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 100.0] {
                let weight = |cost: u64, lifts: u64| cost as f64 + price * lifts as f64;
                let best =
                    all.iter().map(|&(cost, lifts)| weight(cost, lifts)).fold(f64::MAX, f64::min);
                let ours = points
                    .iter()
                    .map(|point| weight(point.cost, point.lifts))
                    .fold(f64::MAX, f64::min);
                assert!((best - ours).abs() < 1e-9, "{best} {ours} {points:?}");
            }
        }
    }
}
