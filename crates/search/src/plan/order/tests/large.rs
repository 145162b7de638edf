//! Orders of large sets of tools, compared with exact ones, and their bounds.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;

/// Solves sets of more than `max_exact` tools as large ones.
fn solve_large(case: &Case, max_exact: usize) -> Result<ToolOrder, OrderError> {
    let Case { layers, costs, constraints } = case;
    Ok(super::super::solve(layers, costs, constraints, max_exact, &Control::default())?.order)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn large_sets_agree_with_the_exact_method(
        mut case in any_case(7, 6, 4),
        max_exact in 0..4_usize,
        same_order: bool,
    ) {
        case.constraints.same_order = same_order;
        let (exact, large) = (solve(&case), solve_large(&case, max_exact));
        match (exact, large) {
            (Ok(exact), Ok(large)) => {
                check_plan(&case, &large);
                prop_assert!(!large.is_optimal() || exact.is_optimal());
                prop_assert!(large.bound <= exact.bound && large.once_bound <= exact.cost);
                // The search misses the optimum in about one of 100,000 cases.
                prop_assert!(large.cost >= exact.cost);
                prop_assert!(!large.is_optimal() || large.cost <= exact.cost);
                prop_assert_eq!(large.min_changes, exact.min_changes);
            }
            (Err(OrderError::Forbidden { layer }), Err(error)) => {
                let is_expected = match error {
                    OrderError::Forbidden { layer: at } | OrderError::NotFound { layer: at } => {
                        at >= layer
                    }
                    _ => false,
                };
                prop_assert!(is_expected, "{error}");
            }
            (Err(exact), Err(large)) => prop_assert_eq!(exact, large),
            (exact, large) => prop_assert!(false, "{exact:?} {large:?}"),
        }
    }
}

#[test]
fn large_sets_are_solved_as_well_as_small_ones() {
    let mut runner = TestRunner::deterministic();
    let cases = any_case(7, 6, 4);
    let [mut solved, mut missed] = [0_u32; 2];
    for number in 0..3000 {
        let case = cases.new_tree(&mut runner).unwrap().current();
        if let (Ok(exact), Ok(large)) = (solve(&case), solve_large(&case, number % 4)) {
            solved += 1;
            missed += u32::from(large.cost > exact.cost);
        }
    }
    assert!(solved > 2000 && missed == 0, "{missed} of {solved} are not optimal");
}

/// Random costs of a kind.
fn draw_costs(rng: &mut Xoshiro256PlusPlus, tools: usize, kind: usize) -> CostMatrix {
    let mut draw = || (0..tools).map(|_| rng.random_range(0.0..100.0)).collect::<Vec<f64>>();
    let (x, y) = (draw(), draw());
    let noise: Vec<f64> = (0..tools * tools).map(|_| rng.random_range(1.0..100.0)).collect();
    let cost = |from: usize, to: usize| match kind % 4 {
        0 => noise[from * tools + to],
        // Distances in the plane, without and with directions.
        1 => (x[from] - x[to]).hypot(y[from] - y[to]),
        2 => (x[from] - x[to]).hypot(y[from] - y[to]) + 0.5 * y[to],
        // From dark to light colours takes more than from light to dark.
        _ => 20.0 + 2.0 * (x[to] - x[from]).max(0.0) + 0.1 * noise[from * tools + to],
    };
    CostMatrix::from_fn(tools, |from, to| cost(from, to).round()).unwrap()
}

#[test]
fn fourteen_tools_are_solved_as_well_as_by_the_exact_method() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut optimal = 0;
    for kind in 0..8 {
        let costs = draw_costs(&mut rng, 14, kind);
        let layers = vec![(0..14).collect::<Vec<u8>>(); 1 + kind % 3];
        let before = if kind % 2 == 0 { vec![(3, 7), (7, 5)] } else { Vec::new() };
        let constraints = Constraints { before, ..Constraints::default() };
        let case = Case { layers, costs, constraints };
        let (exact, large) = (solve_large(&case, 14).unwrap(), solve(&case).unwrap());
        check_plan(&case, &large);
        assert!(exact.is_optimal() && large.once_bound <= exact.cost);
        assert_eq!(large.cost.to_bits(), exact.cost.to_bits());
        optimal += u32::from(large.is_optimal());
    }
    assert!(optimal >= 4, "{optimal} of 8 are proven optimal");
}

#[test]
fn up_to_thirty_tools_have_good_orders_and_bounds() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for (kind, tools) in [30, 19, 17, 15, 13_u8].into_iter().enumerate() {
        let costs = draw_costs(&mut rng, tools.into(), kind);
        let layers: Vec<Vec<u8>> = (0..4)
            .map(|layer| (0..tools).filter(|tool| layer % 2 == 0 || tool % 7 > 0).collect())
            .collect();
        let loaded = Some(kind as u8);
        let before = if kind % 2 == 0 { vec![(3, 7), (8, 1)] } else { Vec::new() };
        let constraints = Constraints { before, loaded, ..Constraints::default() };
        let case = Case { layers, costs, constraints };
        let plan = solve(&case).unwrap();
        check_plan(&case, &plan);
        let gap = (plan.cost - plan.once_bound) / plan.cost;
        assert!(gap < 0.06, "{tools} tools: the bound is {:.1} % below the plan", 100.0 * gap);
        let fixed = fixed_order_cost(&case.layers, &case.costs, loaded).unwrap();
        assert!(plan.cost < fixed.cost);
        if tools < 16 {
            assert_eq!(solve(&case), Ok(plan.clone()), "the same plan every time");
            let constraints = Constraints { same_order: true, ..case.constraints.clone() };
            let shared = solve(&Case { constraints, ..case.clone() }).unwrap();
            check_plan(&case, &shared);
            assert!(shared.cost >= plan.once_bound);
        }
    }
}

/// A cheap cycle is hidden among expensive changes: the plan follows it, and the bound proves it.
#[test]
fn a_hidden_order_of_many_tools_is_found_and_proven() {
    for tools in [13, 20, 40_usize] {
        let position = |tool: usize| tool * 7 % tools;
        let cost = |from, to| if position(to) == (position(from) + 1) % tools { 1.0 } else { 9.0 };
        let costs = CostMatrix::from_fn(tools, cost).unwrap();
        let layers = vec![(0..tools as u8).collect::<Vec<u8>>(); 3];
        let plan = order_alone(&layers, &costs, &Constraints::default()).unwrap();
        let steps = 3 * (tools - 1);
        assert_eq!((plan.cost as usize, plan.stop), (steps, Stop::Optimal));
        assert_eq!((plan.changes as usize, plan.min_changes as usize), (steps, steps));
    }
}
