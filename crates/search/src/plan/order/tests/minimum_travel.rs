//! Minimum travel of the cheapest plans, compared with all plans.

use super::brute_force::permutations;
use super::*;

/// Travel from a tool of one layer to one of the same or the next layer: whole numbers, so that
/// sums do not depend on their order.
fn travel(seed: u64, layers: [usize; 2], tools: [u8; 2]) -> f64 {
    let [a, b] = layers.map(|layer| layer as u64);
    let [from, to] = tools.map(u64::from);
    let mixed =
        (seed ^ (a * 7 + b * 31 + from * 101 + to * 1009)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed >> 60) as f64
}

fn travel_of(orders: &[Vec<u8>], seed: u64) -> f64 {
    let visits: Vec<(usize, u8)> = orders
        .iter()
        .enumerate()
        .flat_map(|(layer, order)| order.iter().map(move |&tool| (layer, tool)))
        .collect();
    let steps = visits.windows(2).filter(|pair| pair[0].1 != pair[1].1);
    steps.map(|pair| travel(seed, [pair[0].0, pair[1].0], [pair[0].1, pair[1].1])).sum()
}

/// Minimum travel of the plans that cost as little as `plan`, by trying all.
fn slow_travel(case: &Case, plan: &ToolOrder, seed: u64) -> f64 {
    let mut plans: Vec<Vec<Vec<u8>>> = vec![Vec::new()];
    for layer in &case.layers {
        let orders = permutations(&set(layer));
        let with = |plan: Vec<Vec<u8>>| {
            orders.iter().map(move |order| [&plan[..], std::slice::from_ref(order)].concat())
        };
        plans = plans.into_iter().flat_map(with).collect();
    }
    let is_cheapest = |orders: &Vec<Vec<u8>>| {
        is_allowed(orders, &case.costs, &case.constraints)
            && cost_of(orders, &case.costs, &case.constraints) as f64 <= plan.cost
    };
    let ways = plans.iter().filter(|plan| is_cheapest(plan)).map(|plan| travel_of(plan, seed));
    ways.fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn no_plan_of_this_cost_travels_less(case in any_case(4, 4, 3), seed in any::<u64>()) {
        let Ok(plan) = solve(&case) else { return Ok(()) };
        let with = |layers, tools| travel(seed, layers, tools);
        let found = plan.clone().with_minimum_travel(&case.costs, &case.constraints, with);
        check_plan(&case, &found);
        prop_assert_eq!(found.cost.to_bits(), plan.cost.to_bits());
        let slow = slow_travel(&case, &plan, seed);
        prop_assert!((travel_of(&found.orders, seed) - slow).abs() < 1e-9);
    }
}

#[test]
fn many_tools_or_one_permutation_keep_their_order() {
    let costs = CostMatrix::uniform(14);
    let layers = vec![(0..14).collect::<Vec<u8>>(); 2];
    let plan = order(&layers, &costs, &Constraints::default(), &Control::default()).unwrap();
    let same = plan.clone().with_minimum_travel(&costs, &Constraints::default(), |_, _| 1.0);
    assert_eq!(same, plan);

    let layers = vec![vec![0, 1, 2], vec![1, 2, 3]];
    let constraints = Constraints { same_order: true, ..Constraints::default() };
    let plan = order(&layers, &costs, &constraints, &Control::default()).unwrap();
    let same = plan.clone().with_minimum_travel(&costs, &constraints, |_, _| 1.0);
    assert_eq!(same, plan);
}
