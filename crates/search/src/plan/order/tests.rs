//! Compares orders with the best of all plans on small parts.

mod brute_force;
mod large;
mod minimum_travel;

use proptest::prelude::*;

use self::brute_force::{
    cost_of, followed, is_allowed, set, slow_bound, slow_layered, slow_shared,
};
use super::layered::layered;
use super::shared::{Abandoned, MAX_LABELS, Shared};
use super::*;

#[derive(Clone, Debug)]
struct Case {
    layers: Vec<Vec<u8>>,
    costs: CostMatrix,
    constraints: Constraints,
}

/// Costs from a small range cause many ties, costs from a large range many detours.
/// In half of the cases a tenth of the changes is forbidden.
fn any_costs(tools: usize) -> impl Strategy<Value = CostMatrix> {
    (1..60_u32, any::<bool>()).prop_flat_map(move |(max, forbids)| {
        let cost = (0..=max, 0..10).prop_map(move |(cost, drawn)| {
            if forbids && drawn == 0 { f64::INFINITY } else { cost.into() }
        });
        prop::collection::vec(cost, tools * tools).prop_map(move |costs| {
            CostMatrix::from_fn(tools, |from, to| costs[from * tools + to]).unwrap()
        })
    })
}

fn any_case(tools: u8, max_tools: usize, max_layers: usize) -> impl Strategy<Value = Case> {
    // One layer in ten is empty.
    let layer = prop::collection::vec(0..tools, 1..=max_tools);
    let layer = (layer, 0..10).prop_map(|(layer, drawn)| if drawn == 0 { vec![] } else { layer });
    let layers = prop::collection::vec(layer, 1..=max_layers);
    let pairs = prop::collection::vec((0..tools, 0..tools), 0..=2);
    let first = prop::option::of(any::<prop::sample::Index>());
    let loaded = prop::option::of(0..tools);
    (layers, any_costs(usize::from(tools)), pairs, 0..tools, first, loaded).prop_map(
        move |(layers, costs, pairs, shift, first, loaded)| {
            // No cycles: all pairs rise in some order.
            let rank = |tool: u8| (tool + shift) % tools;
            let pairs = pairs.into_iter().filter(|(a, b)| a != b);
            let before =
                pairs.map(|(a, b)| if rank(a) < rank(b) { (a, b) } else { (b, a) }).collect();
            let begin = layers.iter().find(|layer| !layer.is_empty());
            let first = first.zip(begin).map(|(index, layer)| *index.get(layer));
            let constraints = Constraints { before, first, loaded, same_order: false };
            Case { layers, costs, constraints }
        },
    )
}

fn check_plan(case: &Case, plan: &ToolOrder) {
    assert!(is_allowed(&plan.orders, &case.costs, &case.constraints));
    for (layer, order) in case.layers.iter().zip(&plan.orders) {
        assert_eq!(set(order), set(layer));
        assert_eq!(order.len(), set(layer).len());
    }
    let (cost, changes) = cost_and_changes(&plan.orders, &case.costs, case.constraints.loaded);
    assert_eq!((plan.cost.to_bits(), plan.changes), ((cost as f64).to_bits(), changes));
    assert!(plan.bound <= plan.once_bound && plan.once_bound <= plan.cost);
    assert!(plan.min_changes <= plan.changes);
    assert_eq!(plan.is_optimal(), plan.stop == Stop::Optimal);
}

/// Calls [`order`] without control.
fn solve(case: &Case) -> Result<ToolOrder, OrderError> {
    order(&case.layers, &case.costs, &case.constraints, &Control::default())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn orders_are_the_best_of_all(case in any_case(5, 4, 3)) {
        let slow = slow_layered(&case.layers, &case.costs, &case.constraints);
        match solve(&case) {
            Ok(plan) => {
                check_plan(&case, &plan);
                prop_assert!(plan.is_optimal());
                prop_assert_eq!(Some((plan.cost as u64, plan.orders)), slow);
                let uniform = CostMatrix::uniform(5);
                let (changes, _) = slow_layered(&case.layers, &uniform, &case.constraints).unwrap();
                prop_assert_eq!(u64::from(plan.min_changes), changes);
            }
            Err(OrderError::Forbidden { layer }) => {
                prop_assert_eq!(slow, None);
                // The layers below have an order, but not together with this one.
                let slow = |layers| slow_layered(layers, &case.costs, &case.constraints);
                prop_assert_eq!(slow(&case.layers[..=layer]), None);
                let below = &case.layers[..layer];
                let is_begin = case.constraints.first.is_some() && below.iter().all(Vec::is_empty);
                prop_assert!(is_begin || slow(below).is_some());
            }
            Err(error) => {
                assert!(matches!(error, OrderError::FirstContradicted { .. }), "{error}");
                prop_assert_eq!(slow, None);
            }
        }
    }

    #[test]
    fn no_plan_of_repeated_uses_beats_the_bound(mut case in any_case(4, 4, 4)) {
        let slow = |case: &Case| slow_bound(&case.layers, &case.costs, &case.constraints);
        if let Ok(plan) = solve(&case) {
            prop_assert!(plan.bound as u64 <= slow(&case).unwrap());
        }
        case.constraints.before.clear();
        let Ok(plan) = solve(&case) else { return Ok(()) };
        prop_assert_eq!(Some(plan.bound as u64), slow(&case), "without pairs some plan meets it");
        if case.costs.is_metric() {
            prop_assert!(plan.gap() <= 0.0);
        }
        let metric = Case { costs: case.costs.with_detours(), ..case };
        prop_assert_eq!(solve(&metric).unwrap().cost.to_bits(), plan.bound.to_bits());
    }

    #[test]
    fn shared_orders_are_the_best_of_all(mut case in any_case(5, 4, 6)) {
        case.constraints.same_order = true;
        let slow = slow_shared(&case.layers, &case.costs, &case.constraints);
        let plan = match solve(&case) {
            Ok(plan) => plan,
            Err(error) => {
                let is_expected = matches!(
                    error,
                    OrderError::FirstContradicted { .. }
                        | OrderError::Forbidden { .. }
                        | OrderError::NoPermutation
                );
                prop_assert!(is_expected, "{error}");
                prop_assert_eq!(slow, None);
                return Ok(());
            }
        };
        check_plan(&case, &plan);
        let (min, permutation) = slow.unwrap();
        prop_assert!(plan.is_optimal());
        prop_assert_eq!(plan.cost as u64, min);
        prop_assert_eq!(&plan.orders, &followed(&case.layers, plan.permutation.as_ref().unwrap()));

        // The search alone, without a good start or a shortcut.
        let control = Control::default();
        let layers = Layers::new(&case.layers, &case.costs, &case.constraints).unwrap();
        let part = Shared::new(&layers, &case.costs, &case.constraints);
        let found = part.search(u64::MAX, MAX_LABELS, &control).unwrap().unwrap();
        let found: Vec<u8> = found.into_iter().map(|tool| part.tools[tool]).collect();
        prop_assert_eq!(found, permutation);
        if !layers.kinds.is_empty() {
            prop_assert_eq!(part.search(min, MAX_LABELS, &control), Ok(None));
            prop_assert_eq!(part.search(u64::MAX, 0, &control), Err(Abandoned));
        }

        // Without the search the result may not be the best, and is not reported as proven.
        let table = |set: &Vec<u8>| Within::exact(set, &case.costs, &case.constraints.before);
        let tables: Vec<Within> = layers.kinds.iter().map(table).collect();
        let tables: Vec<&Within> = tables.iter().collect();
        let best = layered(&layers, &tables, &case.costs, &case.constraints).ok().unwrap();
        let found =
            shared(&layers, &case.costs, &case.constraints, &best, best.cost, 0, &control);
        let (permutation, is_proven) = match found {
            Err(error) => {
                prop_assert_eq!(error, OrderError::NoPermutation);
                return Ok(());
            }
            Ok(found) => found,
        };
        let orders = followed(&case.layers, &permutation);
        let cost = cost_of(&orders, &case.costs, &case.constraints);
        prop_assert!(is_allowed(&orders, &case.costs, &case.constraints));
        prop_assert!(best.cost <= min && min <= cost);
        prop_assert!(!is_proven || cost == min);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 50,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn many_equal_layers(case in any_case(5, 5, 1), count in 2..40_usize) {
        let mut case = Case { layers: vec![case.layers[0].clone(); count], ..case };
        case.constraints.same_order = true;
        if let Ok(plan) = solve(&case) {
            let (min, _) = slow_shared(&case.layers, &case.costs, &case.constraints).unwrap();
            prop_assert_eq!(plan.cost as u64, min);
            prop_assert!(plan.is_optimal());
        }
    }
}

fn order_alone(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> Result<ToolOrder, OrderError> {
    order(layers, costs, constraints, &Control::default())
}

#[test]
fn two_tools_alternate() {
    for count in 1..30 {
        let layers = vec![vec![1, 0]; count];
        let costs = CostMatrix::uniform(2);
        let plan = order_alone(&layers, &costs, &Constraints::default()).unwrap();
        assert_eq!((plan.changes as usize, plan.bound as usize), (count, count));
        let fixed = fixed_order_cost(&layers, &costs, None).unwrap();
        assert_eq!((fixed.changes as usize, fixed.cost as usize), (2 * count - 1, 2 * count - 1));
        let constraints = Constraints { same_order: true, ..Constraints::default() };
        let same = order_alone(&layers, &costs, &constraints).unwrap();
        assert_eq!((same.changes, same.is_optimal()), (fixed.changes, true));
        assert_eq!((same.bound as usize, same.min_changes as usize), (count, count));
    }
}

/// Costs without any pattern.
fn uneven(tools: usize) -> CostMatrix {
    let cost = |from: usize, to: usize| (50 + (from * 7_919 + to * 104_729) % 97) as f64;
    CostMatrix::from_fn(tools, cost).unwrap()
}

#[test]
fn twelve_tools_in_a_thousand_layers() {
    let layers = vec![(0..12).collect::<Vec<u8>>(); 1_000];
    let costs = uneven(12);
    let plan = order_alone(&layers, &costs, &Constraints::default()).unwrap();
    assert!(plan.is_optimal());
    assert_eq!(plan.min_changes, 11_000);
    assert_eq!(order_alone(&layers, &costs, &Constraints::default()), Ok(plan.clone()));
    let constraints = Constraints {
        same_order: true,
        first: Some(5),
        before: vec![(3, 2)],
        ..Constraints::default()
    };
    let same = order_alone(&layers, &costs, &constraints).unwrap();
    assert!(same.is_optimal() && same.cost >= plan.cost);
    assert_eq!(same.orders[0][0], 5);
    assert!(same.cost <= fixed_order_cost(&layers, &costs, None).unwrap().cost);
}

/// Each layer uses five of 40 tools: the permutations have far too many labels.
fn many_kinds() -> (Vec<Vec<u8>>, CostMatrix) {
    let layers: Vec<Vec<u8>> = (0..200_u32)
        .map(|layer| (0..5).map(|tool| ((layer * 13 + tool * tool * 7) % 40) as u8).collect())
        .collect();
    (layers, uneven(40))
}

#[test]
fn many_kinds_of_layers_end_early_with_a_bound() {
    let (layers, costs) = many_kinds();
    let constraints = Constraints { same_order: true, ..Constraints::default() };
    let plan = order_alone(&layers, &costs, &constraints).unwrap();
    assert!(!plan.is_optimal());
    assert_eq!(plan.stop, Stop::Done);
    let free = order_alone(&layers, &costs, &Constraints::default()).unwrap();
    assert_eq!(plan.once_bound.to_bits(), free.cost.to_bits());
    assert!(plan.cost < fixed_order_cost(&layers, &costs, None).unwrap().cost);
    assert_eq!(order_alone(&layers, &costs, &constraints), Ok(plan));
}

#[test]
fn interrupted_calls_return_a_plan() {
    let time_is_up = || true;
    let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
    for (layers, costs) in [many_kinds(), (vec![(0..30).collect(); 4], uneven(30))] {
        for same_order in [false, true] {
            let before = vec![(2, 1), (3, 2)];
            let constraints = Constraints { before, same_order, ..Constraints::default() };
            let plan = order(&layers, &costs, &constraints, &control).unwrap();
            let case = Case { layers: layers.clone(), costs: costs.clone(), constraints };
            check_plan(&case, &plan);
            assert!(plan.stop == Stop::TimeUp || plan.is_optimal());
        }
    }
}

#[test]
fn progress_counts_sets_of_tools() {
    let seen = std::sync::Mutex::new(Vec::new());
    let progress = |progress: beadwork_base::Progress| {
        seen.lock().unwrap().push((progress.done, progress.total));
    };
    let control = Control { progress: Some(&progress), ..Control::default() };
    let layers = vec![vec![0, 1], (0..13).collect(), vec![1, 0], vec![2], vec![]];
    order(&layers, &uneven(13), &Constraints::default(), &control).unwrap();
    assert_eq!(*seen.lock().unwrap(), [(1, 3), (2, 3), (3, 3)]);
}

#[test]
fn costs_are_reported_in_their_unit() {
    let layers = vec![vec![0, 1, 2], vec![], vec![2, 1]];
    let (whole, quarters) =
        (uneven(3), CostMatrix::from_fn(3, |a, b| uneven(3).cost(a as u8, b as u8) / 4.0));
    let constraints = Constraints { loaded: Some(2), ..Constraints::default() };
    let plan = |costs: &CostMatrix| order_alone(&layers, costs, &constraints).unwrap();
    let (whole, quarters) = (plan(&whole), plan(&quarters.unwrap()));
    assert_eq!(whole.orders, quarters.orders);
    for (whole, quarter) in [(whole.cost, quarters.cost), (whole.bound, quarters.bound)] {
        assert_eq!((whole / 4.0).to_bits(), quarter.to_bits());
    }
}

#[test]
fn impossible_orders_are_refused() {
    let costs = CostMatrix::uniform(20);
    let error = |layers: &[Vec<u8>], constraints: Constraints| {
        order_alone(layers, &costs, &constraints).unwrap_err()
    };
    let none = Constraints::default;
    assert_eq!(error(&[vec![20]], none()), OrderError::UnknownTool { tool: 20, tools: 20 });
    let before = |pairs: &[(u8, u8)]| Constraints { before: pairs.to_vec(), ..none() };
    let unknown = OrderError::UnknownTool { tool: 30, tools: 20 };
    assert_eq!(error(&[vec![1]], before(&[(1, 30)])), unknown);
    assert_eq!(error(&[vec![1]], Constraints { loaded: Some(30), ..none() }), unknown);
    let cycle = error(&[vec![1]], before(&[(0, 1), (1, 2), (2, 3), (3, 1), (3, 4), (4, 5)]));
    assert!(matches!(cycle, OrderError::Cycle { a: 1..=3, b: 1..=3 }), "{cycle}");
    assert_eq!(error(&[vec![1]], before(&[(4, 4)])), OrderError::Cycle { a: 4, b: 4 });
    let first = |first| Constraints { first: Some(first), ..none() };
    assert_eq!(error(&[vec![1], vec![2]], first(2)), OrderError::FirstMissing { first: 2 });
    assert_eq!(error(&[], first(2)), OrderError::FirstMissing { first: 2 });
    assert!(order_alone(&[vec![], vec![2]], &costs, &first(2)).is_ok());
    let later = Constraints { before: vec![(3, 2)], ..first(2) };
    let contradicted = OrderError::FirstContradicted { first: 2, other: 3 };
    assert_eq!(error(&[vec![2, 3]], later.clone()), contradicted);
    assert!(order_alone(&[vec![2], vec![2, 3]], &costs, &later).is_ok());
    // Tool 2 must come after tool 4 and that after tool 3, but no layer uses all three: only one
    // order for all layers is impossible.
    let layers = [vec![2, 3], vec![3, 4], vec![4, 2]];
    let round = Constraints { before: vec![(3, 4), (4, 2)], ..first(2) };
    assert!(order_alone(&layers, &costs, &round).is_ok());
    assert_eq!(error(&layers, Constraints { same_order: true, ..round }), contradicted);
}

#[test]
fn forbidden_changes_are_avoided() {
    // From 0 only to 1, from 1 only to 2, from 2 only to 0.
    let cost = |from, to| if to == (from + 1) % 3 { 1.0 } else { f64::INFINITY };
    let costs = CostMatrix::from_fn(3, cost).unwrap();
    let layers = vec![vec![0, 1], vec![], vec![0, 2], vec![1]];
    let constraints = Constraints { loaded: Some(0), ..Constraints::default() };
    let plan = order_alone(&layers, &costs, &constraints).unwrap();
    assert_eq!(plan.orders, [vec![0, 1], vec![], vec![2, 0], vec![1]]);
    assert_eq!((plan.cost as u32, plan.changes, plan.min_changes), (4, 4, 4));
    let error = |layers: &[Vec<u8>]| order_alone(layers, &costs, &constraints).unwrap_err();
    let blocked = error(&[vec![0], vec![1], vec![0]]);
    assert_eq!(blocked, OrderError::Forbidden { layer: 2 });
    let text = "layer 2: no order of the tools up to this layer avoids the forbidden changes";
    assert_eq!(blocked.to_string(), text);
    assert_eq!(error(&[vec![], vec![2]]), OrderError::Forbidden { layer: 1 });
    assert!(fixed_order_cost(&layers, &costs, None).unwrap().cost.is_infinite());
    let constraints = Constraints { same_order: true, ..Constraints::default() };
    let layers = vec![vec![0, 1], vec![2], vec![2, 0]];
    assert_eq!(order_alone(&layers, &costs, &constraints).unwrap().orders[2], [2, 0]);
    let layers = vec![vec![0, 1], vec![1, 2], vec![2, 0]];
    assert!(order_alone(&layers, &costs, &Constraints::default()).is_ok());
    let error = order_alone(&layers, &costs, &constraints).unwrap_err();
    assert_eq!(error, OrderError::NoPermutation);
}

#[test]
fn parts_without_layers_and_with_one_tool() {
    let costs = CostMatrix::uniform(3);
    for same_order in [false, true] {
        let constraints = Constraints { same_order, ..Constraints::default() };
        for empty in [vec![], vec![vec![]], vec![vec![], vec![]]] {
            let plan = order_alone(&empty, &costs, &constraints).unwrap();
            assert_eq!(plan.orders, empty);
            assert_eq!((plan.cost as u32, plan.bound as u32, plan.min_changes), (0, 0, 0));
        }
        let plan = order_alone(&[vec![2, 2], vec![], vec![2]], &costs, &constraints).unwrap();
        assert_eq!((plan.orders, plan.changes), (vec![vec![2], vec![], vec![2]], 0));
        for (loaded, changes) in [(2, 0), (1, 1)] {
            let constraints = Constraints { loaded: Some(loaded), ..constraints.clone() };
            let plan = order_alone(&[vec![], vec![2]], &costs, &constraints).unwrap();
            assert_eq!(
                (plan.changes, plan.min_changes, plan.cost as u32),
                (changes, changes, changes)
            );
        }
    }
}
