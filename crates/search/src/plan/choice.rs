//! The choice of a way of printing for each layer: a shortest path through the layers.
//!
//! Each layer can be printed in several **ways**, which differ in the tools they begin and end
//! with, in the cost of the tool changes between, and in their lifts.
//! Choosing one way for each layer is a shortest-path problem in a layered graph.
//! Its nodes are the ways; an edge leads from each way of a layer to each way of the next one and
//! costs the tool change from the last tool of the former to the first tool of the latter:
//!
//! ```text
//!            layer 0       layer 1       layer 2
//! loaded --> 0..1 -------> 0..0 -------> 1..0        first..last tool of each way
//!       \    1..0 --..\    1..1 --..     0..1
//!        `-> ...       `-> ...           ...
//! ```
//!
//! What comes after a layer depends only on the tool with which it ends, so of all ways up to a
//! layer only the best one for each last tool matters.
//!
//! Tool cost and lifts are two objectives.
//! [`choose`] minimises their weighted sum, and [`frontier`] finds the choices that are optimal for
//! some cost of a lift.

use crate::CostMatrix;

/// A way to print a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Way {
    /// The tool it begins with.
    pub(super) first: u8,
    /// The tool it ends with.
    pub(super) last: u8,
    /// Scaled cost of the tool changes within the layer.
    pub(super) cost: u64,
    /// Lifts between the pieces of the layer.
    pub(super) lifts: u64,
}

/// Weights of a unit of scaled tool cost and of a lift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Weights {
    pub(super) tools: u64,
    pub(super) lifts: u64,
}

/// What may come before the first layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Begin {
    /// The tool in the nozzle, from which a change to the first tool is paid.
    pub(super) loaded: Option<u8>,
    /// The only tool that the first layer may begin with.
    pub(super) first: Option<u8>,
}

/// A choice of one way for each layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Chosen {
    /// For each layer the number of its way.
    pub(super) ways: Vec<usize>,
    /// Scaled cost of all tool changes, including those between layers.
    pub(super) cost: u64,
    /// Number of all lifts.
    pub(super) lifts: u64,
}

/// Weight of a choice that is not allowed; adding two such weights does not overflow.
const INFEASIBLE: u128 = u128::MAX / 4;

/// The choice with the minimum weight; `None` if there is none, for example because a layer has no
/// way.
///
/// O(l w t) steps for l layers of w ways that end with t different tools.
pub(super) fn choose(
    layers: &[Vec<Way>],
    costs: &CostMatrix,
    begin: Begin,
    weights: Weights,
) -> Option<Chosen> {
    if layers.iter().any(Vec::is_empty) {
        return None;
    }
    let weigh = |cost: u64, lifts: u64| {
        u128::from(weights.tools) * u128::from(cost) + u128::from(weights.lifts) * u128::from(lifts)
    };
    let change = |from: u8, to: u8| {
        if costs.is_forbidden(from, to) { INFEASIBLE } else { weigh(costs.step(from, to), 0) }
    };
    // For each way of each layer, the minimum weight up to its end and the way before it.
    let mut table: Vec<Vec<(u128, usize)>> = Vec::with_capacity(layers.len());
    for (number, ways) in layers.iter().enumerate() {
        // The best way of the layer below for each last tool; of equally good ones the first.
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
        let best = |way: &Way| {
            let own = weigh(way.cost, way.lifts);
            let (weight, before) = if number == 0 {
                let is_allowed = begin.first.is_none_or(|first| first == way.first);
                let change = begin.loaded.map_or(0, |loaded| change(loaded, way.first));
                (if is_allowed { change + own } else { INFEASIBLE }, 0)
            } else {
                let reached = ends
                    .iter()
                    .map(|&(tool, weight, at)| (weight + change(tool, way.first) + own, at));
                reached.min().expect("the layer below has ways")
            };
            (weight.min(INFEASIBLE), before)
        };
        table.push(ways.iter().map(best).collect());
    }
    // Backwards from the best way of the last layer.
    let mut ways = vec![0; layers.len()];
    for number in (0..layers.len()).rev() {
        ways[number] = if number + 1 == layers.len() {
            let weight = |&at: &usize| table[number][at].0;
            let best = (0..table[number].len()).min_by_key(weight).expect("each layer has a way");
            if weight(&best) == INFEASIBLE {
                return None;
            }
            best
        } else {
            table[number + 1][ways[number + 1]].1
        };
    }
    let way = |number: usize| &layers[number][ways[number]];
    let within: u64 = (0..layers.len()).map(|number| way(number).cost).sum();
    let between: u64 =
        (1..layers.len()).map(|number| costs.step(way(number - 1).last, way(number).first)).sum();
    let before = match begin.loaded {
        Some(loaded) if !layers.is_empty() => costs.step(loaded, way(0).first),
        _ => 0,
    };
    let lifts = (0..layers.len()).map(|number| way(number).lifts).sum();
    Some(Chosen { ways, cost: before + within + between, lifts })
}

/// Maximum number of points of a frontier.
const MAX_POINTS: usize = 256;

/// The choices that are optimal for some cost of a lift, from few lifts to low tool costs.
///
/// In a diagram of lifts against tool cost these are the corners of the lower left part of the
/// convex hull of all choices.
/// Between two neighbouring corners the hull is a straight edge.
/// [`choose`] with the weights for which both corners weigh the same either finds a choice below
/// that edge, which is another corner, or proves that there is none.
///
/// At most 256 points: beyond that, the last ones found may not be neighbours on the hull.
pub(super) fn frontier(layers: &[Vec<Way>], costs: &CostMatrix, begin: Begin) -> Vec<Chosen> {
    // One objective outweighs the other by so much that the latter only breaks ties.
    let much_more = 1 << 40;
    let at = |tools: u64, lifts: u64| choose(layers, costs, begin, Weights { tools, lifts });
    let (Some(few_lifts), Some(cheap_tools)) = (at(1, much_more), at(much_more, 1)) else {
        return Vec::new();
    };
    // The last of `points` and the last of `rest` are the ends of the edge to be examined.
    let mut points = vec![few_lifts];
    let mut rest = vec![cheap_tools];
    while let Some(next) = rest.last() {
        let here = points.last().expect("there is a first point");
        if (here.cost, here.lifts) == (next.cost, next.lifts) {
            rest.pop();
            continue;
        }
        let weights = Weights {
            tools: next.lifts.saturating_sub(here.lifts),
            lifts: here.cost.saturating_sub(next.cost),
        };
        let weight = |point: &Chosen| {
            u128::from(weights.tools) * u128::from(point.cost)
                + u128::from(weights.lifts) * u128::from(point.lifts)
        };
        let below =
            choose(layers, costs, begin, weights).filter(|below| weight(below) < weight(here));
        match below {
            Some(below) if points.len() + rest.len() < MAX_POINTS => rest.push(below),
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

    fn draw(rng: &mut Xoshiro256PlusPlus) -> (Vec<Vec<Way>>, CostMatrix) {
        let tools = rng.random_range(1..=3_u8);
        let rows: Vec<f64> =
            (0..9)
                .map(|_| {
                    if rng.random_bool(0.1) { f64::INFINITY } else { rng.random_range(0..9).into() }
                })
                .collect();
        let costs = CostMatrix::from_fn(tools.into(), |from, to| rows[3 * from + to]).unwrap();
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

    fn draw_begin(rng: &mut Xoshiro256PlusPlus, costs: &CostMatrix) -> Begin {
        let first = rng.random_bool(0.3).then_some(0);
        let loaded = rng.random_bool(0.5).then_some(rng.random_range(0..costs.size() as u8));
        Begin { loaded, first }
    }

    /// Cost and lifts of every choice.
    fn all(layers: &[Vec<Way>], costs: &CostMatrix, begin: Begin) -> Vec<(u64, u64)> {
        let mut sums: Vec<(Option<u8>, u64, u64)> = vec![(begin.loaded, 0, 0)];
        for (number, ways) in layers.iter().enumerate() {
            let on = |&(tool, cost, lifts): &(Option<u8>, u64, u64)| {
                let allowed = ways.iter().filter(move |way| {
                    (number > 0 || begin.first.is_none_or(|first| first == way.first))
                        && tool.is_none_or(|tool| !costs.is_forbidden(tool, way.first))
                });
                let step = move |way: &Way| tool.map_or(0, |tool| costs.step(tool, way.first));
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
            let begin = draw_begin(&mut rng, &costs);
            let weights = Weights { tools: rng.random_range(0..4), lifts: rng.random_range(0..4) };
            let weight = |cost: u64, lifts: u64| weights.tools * cost + weights.lifts * lifts;
            let best = all(&layers, &costs, begin)
                .into_iter()
                .map(|(cost, lifts)| weight(cost, lifts))
                .min();
            let chosen = choose(&layers, &costs, begin, weights);
            assert_eq!(chosen.map(|chosen| weight(chosen.cost, chosen.lifts)), best);
        }
    }

    #[test]
    fn a_layer_without_ways_has_no_choice() {
        let way = Way { first: 0, last: 0, cost: 0, lifts: 0 };
        let weights = Weights { tools: 1, lifts: 1 };
        let costs = CostMatrix::uniform(1);
        let choose = |layers: &[Vec<Way>]| choose(layers, &costs, Begin::default(), weights);
        assert_eq!(choose(&[vec![way], vec![], vec![way]]), None);
        assert_eq!(choose(&[vec![way], vec![way]]).map(|chosen| chosen.cost), Some(0));
    }

    #[test]
    fn the_frontier_is_the_hull_of_all_choices() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        for _ in 0..1000 {
            let (layers, costs) = draw(&mut rng);
            let begin = draw_begin(&mut rng, &costs);
            let points = frontier(&layers, &costs, begin);
            let all = all(&layers, &costs, begin);
            assert_eq!(points.is_empty(), all.is_empty());
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
                let found = points
                    .iter()
                    .map(|point| weight(point.cost, point.lifts))
                    .fold(f64::MAX, f64::min);
                assert!((best - found).abs() < 1e-9, "{best} {found} {points:?}");
            }
        }
    }
}
