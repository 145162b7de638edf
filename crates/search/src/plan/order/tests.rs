//! The fast programme against all plans there are.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::shared::{MOST_LABELS, Shared, TooManyLabels};
use super::*;

/// All orders of some tools, rising.
fn permutations(tools: &[u8]) -> Vec<Vec<u8>> {
    if tools.is_empty() {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (at, &tool) in tools.iter().enumerate() {
        let mut others = tools.to_vec();
        others.remove(at);
        for rest in permutations(&others) {
            all.push([&[tool], rest.as_slice()].concat());
        }
    }
    all
}

fn set(tools: &[u8]) -> Vec<u8> {
    let mut set = tools.to_vec();
    set.sort_unstable();
    set.dedup();
    set
}

fn is_allowed(orders: &[Vec<u8>], constraints: &Constraints) -> bool {
    let obeys = |order: &Vec<u8>| {
        let place = |tool: u8| order.iter().position(|&one| one == tool);
        constraints.before.iter().all(|&(a, b)| match (place(a), place(b)) {
            (Some(a), Some(b)) => a < b,
            _ => true,
        })
    };
    orders.iter().all(obeys) && constraints.first.is_none_or(|first| orders[0][0] == first)
}

/// The cheapest plan, of equal ones the first in the alphabet, by trying all.
fn slow_free(
    layers: &[Vec<u8>],
    costs: &ToolCosts,
    constraints: &Constraints,
) -> Option<(u64, Vec<Vec<u8>>)> {
    let mut plans: Vec<Vec<Vec<u8>>> = vec![Vec::new()];
    for layer in layers {
        let orders = permutations(&set(layer));
        plans = plans
            .into_iter()
            .flat_map(|plan| {
                orders
                    .iter()
                    .map(move |order| [plan.as_slice(), std::slice::from_ref(order)].concat())
            })
            .collect();
    }
    plans.retain(|plan| is_allowed(plan, constraints));
    plans.into_iter().map(|plan| (sum(&plan, costs).cost, plan)).min()
}

/// The cheapest permutation for all layers, by trying all.
fn slow_shared(
    layers: &[Vec<u8>],
    costs: &ToolCosts,
    constraints: &Constraints,
) -> Option<(u64, Vec<u8>)> {
    let tried = permutations(&set(&layers.concat())).into_iter().filter_map(|permutation| {
        let orders = followed(layers, &permutation);
        is_allowed(&orders, constraints).then(|| (sum(&orders, costs).cost, permutation))
    });
    tried.min()
}

fn followed(layers: &[Vec<u8>], permutation: &[u8]) -> Vec<Vec<u8>> {
    let follow = |layer: &Vec<u8>| {
        permutation.iter().copied().filter(|tool| layer.contains(tool)).collect::<Vec<u8>>()
    };
    layers.iter().map(follow).collect()
}

/// The least cost of any plan, tools used as often as it likes: the nearest of all states by
/// Dijkstra's method.
/// A state is a layer, the tools used in it, and the tool in use; `before` holds for first visits.
fn slow_bound(layers: &[Vec<u8>], costs: &ToolCosts, constraints: &Constraints) -> Option<u64> {
    let tools = costs.tools() as u8;
    let visit = |layer: usize, used: u16, tool: u8| -> Option<u16> {
        let is_new = layers[layer].contains(&tool) && used & 1 << tool == 0;
        let blocked = constraints
            .before
            .iter()
            .any(|&(a, b)| b == tool && layers[layer].contains(&a) && used & 1 << a == 0);
        match (is_new, blocked) {
            (true, true) => None,
            (true, false) => Some(used | 1 << tool),
            (false, _) => Some(used),
        }
    };
    let mut open: BTreeMap<(usize, u16, u8), u64> = BTreeMap::new();
    for tool in (0..tools).filter(|&tool| constraints.first.is_none_or(|first| first == tool)) {
        if let Some(used) = visit(0, 0, tool) {
            open.insert((0, used, tool), 0);
        }
    }
    let mut done = BTreeMap::new();
    while let Some((&state, &cost)) = open.iter().min_by_key(|&(_, cost)| cost) {
        open.remove(&state);
        done.insert(state, cost);
        let (layer, used, now) = state;
        let mut next = Vec::new();
        if layers[layer].iter().all(|&tool| used & 1 << tool != 0) {
            if layer + 1 == layers.len() {
                return Some(cost);
            }
            // The tool in use need not print in the next layer at once.
            next.push(((layer + 1, 0, now), cost));
            next.extend(visit(layer + 1, 0, now).map(|used| ((layer + 1, used, now), cost)));
        }
        for tool in 0..tools {
            let step = cost + u64::from(costs.cost(now, tool));
            next.extend(visit(layer, used, tool).map(|used| ((layer, used, tool), step)));
        }
        for (state, cost) in next {
            if !done.contains_key(&state) {
                let known = open.entry(state).or_insert(cost);
                *known = cost.min(*known);
            }
        }
    }
    None
}

#[derive(Clone, Debug)]
struct Case {
    layers: Vec<Vec<u8>>,
    costs: ToolCosts,
    constraints: Constraints,
}

/// Few costs make many ties, and many of them detours.
fn any_costs(tools: usize) -> impl Strategy<Value = ToolCosts> {
    (1..60_u32).prop_flat_map(move |most| {
        prop::collection::vec(0..=most, tools * tools).prop_map(move |costs| {
            let rows = costs.chunks(tools).enumerate().map(|(from, row)| {
                let row = row.iter().enumerate();
                row.map(|(to, &cost)| if from == to { 0 } else { cost }).collect()
            });
            ToolCosts::new(&rows.collect::<Vec<_>>()).unwrap()
        })
    })
}

fn any_case(tools: u8, most_tools: usize, most_layers: usize) -> impl Strategy<Value = Case> {
    let layer = prop::collection::vec(0..tools, 1..=most_tools);
    let layers = prop::collection::vec(layer, 1..=most_layers);
    let pairs = prop::collection::vec((0..tools, 0..tools), 0..=2);
    let first = prop::option::of(any::<prop::sample::Index>());
    (layers, any_costs(usize::from(tools)), pairs, 0..tools, first).prop_map(
        move |(layers, costs, pairs, shift, first)| {
            // No circles: all pairs rise in some order.
            let rank = |tool: u8| (tool + shift) % tools;
            let pairs = pairs.into_iter().filter(|(a, b)| a != b);
            let before =
                pairs.map(|(a, b)| if rank(a) < rank(b) { (a, b) } else { (b, a) }).collect();
            let first = first.map(|index| *index.get(&layers[0]));
            Case { layers, costs, constraints: Constraints { before, first, same_order: false } }
        },
    )
}

fn check_plan(case: &Case, plan: &ToolOrder) {
    assert!(is_allowed(&plan.orders, &case.constraints));
    for (layer, order) in case.layers.iter().zip(&plan.orders) {
        assert_eq!(set(order), set(layer));
        assert_eq!(order.len(), set(layer).len());
    }
    let FixedOrder { cost, changes } = sum(&plan.orders, &case.costs);
    assert_eq!((plan.cost, plan.changes), (cost, changes));
    assert!(plan.bound <= plan.once_bound && plan.once_bound <= plan.cost);
    assert!(plan.least_changes <= plan.changes);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn free_orders_are_the_best_of_all(case in any_case(5, 4, 3)) {
        let slow = slow_free(&case.layers, &case.costs, &case.constraints);
        match order(&case.layers, &case.costs, &case.constraints) {
            Ok(plan) => {
                check_plan(&case, &plan);
                prop_assert!(plan.is_optimal());
                prop_assert_eq!(Some((plan.cost, plan.orders)), slow);
                let uniform = ToolCosts::uniform(5);
                let (least, _) = slow_free(&case.layers, &uniform, &case.constraints).unwrap();
                prop_assert_eq!(u64::from(plan.least_changes), least);
            }
            Err(error) => {
                assert!(matches!(error, OrderError::FirstContradicted { .. }), "{error}");
                prop_assert_eq!(slow, None);
            }
        }
    }

    #[test]
    fn no_plan_of_many_visits_beats_the_bound(mut case in any_case(4, 4, 4)) {
        if let Ok(plan) = order(&case.layers, &case.costs, &case.constraints) {
            prop_assert!(plan.bound <= slow_bound(&case.layers, &case.costs, &case.constraints).unwrap());
        }
        case.constraints.before.clear();
        let plan = order(&case.layers, &case.costs, &case.constraints).unwrap();
        let slow = slow_bound(&case.layers, &case.costs, &case.constraints);
        prop_assert_eq!(Some(plan.bound), slow, "without pairs some plan meets it");
        if case.costs.is_metric() {
            prop_assert_eq!(plan.gap(), 0);
        }
        let metric = case.costs.with_detours();
        prop_assert_eq!(order(&case.layers, &metric, &case.constraints).unwrap().cost, plan.bound);
    }

    #[test]
    fn shared_orders_are_the_best_of_all(mut case in any_case(5, 4, 6)) {
        case.constraints.same_order = true;
        let slow = slow_shared(&case.layers, &case.costs, &case.constraints);
        let plan = match order(&case.layers, &case.costs, &case.constraints) {
            Ok(plan) => plan,
            Err(error) => {
                assert!(matches!(error, OrderError::FirstContradicted { .. }), "{error}");
                prop_assert_eq!(slow, None);
                return Ok(());
            }
        };
        check_plan(&case, &plan);
        let (least, permutation) = slow.unwrap();
        prop_assert!(plan.is_optimal());
        prop_assert_eq!(plan.cost, least);
        prop_assert_eq!(&plan.orders, &followed(&case.layers, plan.permutation.as_ref().unwrap()));

        // The search alone, with no good start and no shortcut.
        let layers = Layers::new(&case.layers, &case.costs, &case.constraints).unwrap();
        let part = Shared::new(&layers, &case.costs, &case.constraints);
        let found = part.search(u64::MAX, MOST_LABELS).unwrap().unwrap();
        let found: Vec<u8> = found.into_iter().map(|tool| part.tools[tool]).collect();
        prop_assert_eq!(found, permutation);
        prop_assert_eq!(part.search(least, MOST_LABELS), Ok(None));
        prop_assert_eq!(part.search(u64::MAX, 0), Err(TooManyLabels));

        // And without the search: good if not best, and never said to be better than it is.
        let best = free(&layers, &case.costs, &case.constraints);
        let (permutation, proven) = shared(&layers, &case.costs, &case.constraints, &best, 0).unwrap();
        let orders = followed(&case.layers, &permutation);
        let cost = sum(&orders, &case.costs).cost;
        prop_assert!(is_allowed(&orders, &case.constraints));
        prop_assert!(best.cost <= least && least <= cost);
        prop_assert!(!proven || cost == least);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 50, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn all_layers_alike(case in any_case(5, 5, 1), count in 2..40_usize) {
        let case = Case { layers: vec![case.layers[0].clone(); count], ..case };
        let constraints = Constraints { same_order: true, ..case.constraints };
        if let Ok(plan) = order(&case.layers, &case.costs, &constraints) {
            let (least, _) = slow_shared(&case.layers, &case.costs, &constraints).unwrap();
            prop_assert_eq!(plan.cost, least);
            prop_assert!(plan.is_optimal());
        }
    }
}

#[test]
fn two_tools_alternate() {
    for count in 1..30 {
        let layers = vec![vec![1, 0]; count];
        let costs = ToolCosts::uniform(2);
        let plan = order(&layers, &costs, &Constraints::default()).unwrap();
        assert_eq!((plan.changes as usize, plan.bound), (count, count as u64));
        let fixed = fixed_order_cost(&layers, &costs).unwrap();
        assert_eq!((fixed.changes as usize, fixed.cost), (2 * count - 1, 2 * count as u64 - 1));
        let same =
            order(&layers, &costs, &Constraints { same_order: true, ..Constraints::default() })
                .unwrap();
        assert_eq!((same.changes, same.is_optimal()), (fixed.changes, true));
        assert_eq!((same.bound, same.least_changes as usize), (count as u64, count));
    }
}

/// Costs that look drawn.
fn uneven(tools: usize) -> ToolCosts {
    let cost = |from: usize, to: usize| {
        if from == to { 0 } else { 50 + (from * 7_919 + to * 104_729) % 97 }
    };
    let rows: Vec<Vec<u32>> =
        (0..tools).map(|from| (0..tools).map(|to| cost(from, to) as u32).collect()).collect();
    ToolCosts::new(&rows).unwrap()
}

#[test]
fn twelve_tools_in_a_thousand_layers() {
    let layers = vec![(0..12).collect::<Vec<u8>>(); 1_000];
    let costs = uneven(12);
    let plan = order(&layers, &costs, &Constraints::default()).unwrap();
    assert!(plan.is_optimal());
    assert_eq!(plan.least_changes, 11_000);
    assert_eq!(order(&layers, &costs, &Constraints::default()), Ok(plan.clone()));
    let constraints = Constraints { same_order: true, first: Some(5), before: vec![(3, 2)] };
    let same = order(&layers, &costs, &constraints).unwrap();
    assert!(same.is_optimal() && same.cost >= plan.cost);
    assert_eq!(same.orders[0][0], 5);
    assert!(same.cost <= fixed_order_cost(&layers, &costs).unwrap().cost);
}

#[test]
fn many_kinds_of_layers_end_early_with_a_bound() {
    // Each layer uses five of 40 tools: far too many beginnings of one permutation to tell apart.
    let layers: Vec<Vec<u8>> = (0..200_u32)
        .map(|layer| (0..5).map(|tool| ((layer * 13 + tool * tool * 7) % 40) as u8).collect())
        .collect();
    let costs = uneven(40);
    let constraints = Constraints { same_order: true, ..Constraints::default() };
    let plan = order(&layers, &costs, &constraints).unwrap();
    assert!(!plan.is_optimal());
    assert_eq!(plan.once_bound, order(&layers, &costs, &Constraints::default()).unwrap().cost);
    assert!(plan.cost < fixed_order_cost(&layers, &costs).unwrap().cost);
    assert_eq!(order(&layers, &costs, &constraints), Ok(plan));
}

#[test]
fn what_has_no_order_is_refused() {
    let costs = ToolCosts::uniform(20);
    let error = |layers: &[Vec<u8>], constraints: Constraints| {
        order(layers, &costs, &constraints).unwrap_err()
    };
    let none = Constraints::default;
    assert_eq!(error(&[vec![1], vec![]], none()), OrderError::EmptyLayer { layer: 1 });
    assert_eq!(error(&[(0..13).collect()], none()), OrderError::TooManyTools { layer: 0, got: 13 });
    assert_eq!(error(&[vec![20]], none()), OrderError::UnknownTool { tool: 20, tools: 20 });
    let before = |pairs: &[(u8, u8)]| Constraints { before: pairs.to_vec(), ..none() };
    assert_eq!(
        error(&[vec![1]], before(&[(1, 30)])),
        OrderError::UnknownTool { tool: 30, tools: 20 }
    );
    let circle = error(&[vec![1]], before(&[(0, 1), (1, 2), (2, 3), (3, 1), (3, 4), (4, 5)]));
    assert!(matches!(circle, OrderError::Circle { a: 1..=3, b: 1..=3 }), "{circle}");
    assert_eq!(error(&[vec![1]], before(&[(4, 4)])), OrderError::Circle { a: 4, b: 4 });
    let first = |first| Constraints { first: Some(first), ..none() };
    assert_eq!(error(&[vec![1], vec![2]], first(2)), OrderError::FirstMissing { first: 2 });
    assert_eq!(error(&[], first(2)), OrderError::FirstMissing { first: 2 });
    let later = Constraints { before: vec![(3, 2)], ..first(2) };
    let contradicted = OrderError::FirstContradicted { first: 2, other: 3 };
    assert_eq!(error(&[vec![2, 3]], later.clone()), contradicted);
    assert!(order(&[vec![2], vec![2, 3]], &costs, &later).is_ok());
    // Through a third tool that only other layers use: no matter, unless all layers share one
    // order.
    let layers = [vec![2, 3], vec![3, 4], vec![4, 2]];
    let round = Constraints { before: vec![(3, 4), (4, 2)], ..first(2) };
    assert!(order(&layers, &costs, &round).is_ok());
    assert_eq!(error(&layers, Constraints { same_order: true, ..round }), contradicted);
}

#[test]
fn parts_of_no_layer_and_of_one_tool() {
    let costs = ToolCosts::uniform(3);
    for same_order in [false, true] {
        let constraints = Constraints { same_order, ..Constraints::default() };
        let plan = order(&[], &costs, &constraints).unwrap();
        assert_eq!((plan.orders.len(), plan.cost, plan.bound), (0, 0, 0));
        let plan = order(&[vec![2, 2], vec![2]], &costs, &constraints).unwrap();
        assert_eq!((plan.orders, plan.changes), (vec![vec![2], vec![2]], 0));
    }
}
