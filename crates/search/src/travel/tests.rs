//! Compares routes with the shortest of all routes of few items, and with long runs on many.

mod cases;

use beadwork_base::Control;
use proptest::prelude::*;

use self::cases::{Case, any_case, shortest};
use super::*;

fn check(items: &[Item<'_>], settings: &Settings, route: &Route) {
    assert!(is_allowed(items, &route.visits, settings.order), "{route:?}");
    let travel = travel_mm(items, &route.visits, settings.from);
    assert_eq!(travel.to_bits(), route.travel_mm.to_bits());
    if let Some(bound) = route.bound_mm {
        assert!(bound >= 0.0 && bound <= travel, "bound {bound}, travel {travel}");
    }
}

fn settings(case: &Case) -> Settings {
    let Case { order, from, seed, .. } = *case;
    Settings { order, from, seed, bound_iterations: 30, ..Settings::default() }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn few_items_are_ordered_no_shorter_than_possible(case in any_case(0..=6, 3)) {
        let items = case.items();
        let settings = settings(&case);
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        let shortest = shortest(&items, case.order, case.from);
        prop_assert!(route.travel_mm >= shortest - 1e-9);
        prop_assert!(route.bound_mm.is_none_or(|bound| bound <= shortest));
    }

    #[test]
    fn many_items_are_ordered_as_allowed(case in any_case(7..=40, 40)) {
        let items = case.items();
        let settings = settings(&case);
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        prop_assert_eq!(&route, &solve(&items, &settings, &Control::default()).unwrap());
        let nearest = nearest_neighbour(&items, case.order, case.from).unwrap();
        check(&items, &settings, &nearest);
        prop_assert!(route.travel_mm <= nearest.travel_mm + 1e-9);
    }
}
