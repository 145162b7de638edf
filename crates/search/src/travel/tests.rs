//! Compares routes with the shortest of all routes of few items, and with long runs on many.

mod cases;

use beadwork_base::{CancelToken, Control};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use self::cases::{Case, any_case, cheapest, cost_mm_of, shortest};
use super::problem::Problem;
use super::solve::improve;
use super::*;
use crate::Stop;
use crate::random::unit;

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
    fn routes_of_few_items_are_the_shortest(case in any_case(0..=6, 3)) {
        let items = case.items();
        let settings = settings(&case);
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        let shortest = shortest(&items, case.order, case.from);
        prop_assert!((route.travel_mm - shortest).abs() <= 1e-9 || items.is_empty());
        prop_assert_eq!(route.stop, Stop::Optimal);
    }

    #[test]
    fn few_items_have_the_cheapest_route(
        case in any_case(0..=6, 3),
        beyond_mm in 0.0..12.0_f64,
        cost_mm in 0.0..20.0_f64,
    ) {
        let items = case.items();
        let retraction = Some(Retraction { beyond_mm, cost_mm });
        let settings = Settings { retraction, ..settings(&case) };
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        let cost = cost_mm_of(&items, &route.visits, case.from, retraction);
        let cheapest = cheapest(&items, case.order, case.from, retraction);
        prop_assert!((cost - cheapest).abs() <= 1e-9 || items.is_empty());
    }

    #[test]
    fn local_search_avoids_retractions(case in any_case(7..=40, 40), cost_mm in 0.0..20.0_f64) {
        let items = case.items();
        let retraction = Some(Retraction { beyond_mm: 2.0, cost_mm });
        let settings = Settings { kicks_per_item: 2, retraction, ..settings(&case) };
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        let nearest = nearest_neighbour(&items, case.order, case.from).unwrap();
        let [cost, other] = [&route.visits, &nearest.visits]
            .map(|visits| cost_mm_of(&items, visits, case.from, retraction));
        prop_assert!(cost <= other + 1e-9, "{} {}", cost, other);
    }

    #[test]
    fn no_route_from_anywhere_is_below_the_lower_bound(case in any_case(1..=6, 3)) {
        let items = case.items();
        let shortest = shortest(&items, case.order, None);
        for known in [shortest, 2.0 * shortest] {
            let control = Control::default();
            let bound = lower_bound_mm(&items, case.order, known, 30, &control).unwrap().unwrap();
            prop_assert!((0.0..=shortest).contains(&bound), "{} {}", bound, shortest);
            prop_assert!(bound >= shortest * 0.999_999, "few items are solved exactly");
        }
    }

    #[test]
    fn many_items_are_ordered_as_allowed(case in any_case(7..=40, 40)) {
        let items = case.items();
        let settings = Settings { kicks_per_item: 2, ..settings(&case) };
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        prop_assert_eq!(&route, &solve(&items, &settings, &Control::default()).unwrap());
        let nearest = nearest_neighbour(&items, case.order, case.from).unwrap();
        check(&items, &settings, &nearest);
        prop_assert!(route.travel_mm <= nearest.travel_mm + 1e-9);
    }
}

/// Local search on cases that are small enough for the exact method.
#[test]
fn local_search_and_bound_enclose_the_shortest_route() {
    let mut runner = TestRunner::deterministic();
    let strategy = any_case(1..=6, 3);
    let (mut optimal, mut routes, mut bounds) = (0, 0.0, 0.0);
    for _ in 0..2_000 {
        let case = strategy.new_tree(&mut runner).unwrap().current();
        let items = case.items();
        let settings = Settings { kicks_per_item: 30, ..settings(&case) };
        let problem = Problem::new(&items, case.order, case.from, None);
        let (visits, _) = improve(&problem, &settings, &Control::default());
        assert!(is_allowed(&items, &visits, case.order));
        let travel = travel_mm(&items, &visits, case.from);
        let shortest = shortest(&items, case.order, case.from);
        assert!(travel >= shortest - 1e-9);
        let bound = bound::bound(&problem, travel, 50, &Control::default()).unwrap();
        assert!(bound <= shortest, "bound {bound}, shortest {shortest}");
        optimal += usize::from(travel <= shortest + 1e-9);
        routes += travel / shortest.max(1e-9);
        bounds += bound / shortest.max(1e-9);
    }
    println!("optimal: {optimal}, mean ratios: {:.4}, {:.4}", routes / 2e3, bounds / 2e3);
    assert!(optimal >= 1_900, "{optimal} of 2000 routes are the shortest");
}

/// The ends of a bead, or the entries of a loop.
type Points = Vec<[f64; 2]>;

/// Beads of random lengths, in groups on a grid, every third one replaced by a square loop.
fn layer(count: usize, seed: u64) -> (Vec<Points>, Vec<(u32, u32)>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut shapes = Vec::new();
    let mut groups = Vec::new();
    let side = (count as f64 / 25.0).sqrt().ceil();
    for _ in 0..count {
        let cell = [(unit(&mut rng) * side).floor(), (unit(&mut rng) * side).floor()];
        let [x, y] = cell.map(|cell| 50.0 * cell + 40.0 * unit(&mut rng));
        let [dx, dy] = [10.0 * unit(&mut rng) - 5.0, 10.0 * unit(&mut rng) - 5.0];
        let is_loop = unit(&mut rng) < 0.3;
        shapes.push(if is_loop {
            let edge = |k: f64| [(k, 0.0), (8.0, k), (8.0 - k, 8.0), (0.0, 8.0 - k)];
            (0..8).flat_map(|k| edge(f64::from(k))).map(|(dx, dy)| [x + dx, y + dy]).collect()
        } else {
            vec![[x, y], [x + dx, y + dy]]
        });
        groups.push(((cell[0] * side + cell[1]) as u32, u32::from(!is_loop)));
    }
    (shapes, groups)
}

#[test]
fn default_settings_come_near_long_runs() {
    for order in [Order::Free, Order::Groups, Order::Stages] {
        for (count, seed) in [(100, 1), (200, 2)] {
            let (shapes, groups) = layer(count, seed);
            let items: Vec<Item<'_>> = shapes
                .iter()
                .zip(&groups)
                .map(|(points, &(group, stage))| match points[..] {
                    [start, end] => Item::bead(start, end).within(group, stage),
                    _ => Item::closed(points).within(group, stage),
                })
                .collect();
            let solve = |settings: Settings| solve(&items, &settings, &Control::default()).unwrap();
            let settings = Settings { order, bound_iterations: 100, ..Settings::default() };
            let route = solve(settings);
            check(&items, &settings, &route);
            let long =
                |seed| Settings { seed, kicks_per_item: 50, bound_iterations: 0, ..settings };
            let best = (1..=10).map(|seed| solve(long(seed)).travel_mm).fold(f64::MAX, f64::min);
            let nearest = nearest_neighbour(&items, order, None).unwrap().travel_mm;
            let bound = route.bound_mm.unwrap();
            assert!(bound <= best);
            println!(
                "{order:?}, {count} items: {:.4} of the best of long runs, {:.4} of the bound, \
                 {:.3} of nearest neighbours",
                route.travel_mm / best,
                route.travel_mm / bound,
                route.travel_mm / nearest,
            );
            assert!(route.travel_mm <= 1.05 * best);
        }
    }
}

#[test]
fn degenerate_items_have_routes() {
    let point = [3.0, 4.0];
    let equal = vec![Item::bead(point, point); 30];
    let line: Vec<Item<'_>> =
        (0..30).map(|x| Item::bead([f64::from(x), 0.0], [f64::from(x), 0.0])).collect();
    let huge: Vec<Item<'_>> =
        (0..30).map(|x| Item::bead([f64::from(x) * 1e7, -1e9], [1e9, 1e9])).collect();
    let tiny: Vec<Item<'_>> =
        (0..30).map(|x| Item::bead([f64::from(x) * 1e-200, 0.0], [0.0, 0.0])).collect();
    let none = Vec::new();
    for items in [&none, &equal[..1].to_vec(), &equal, &line, &huge, &tiny] {
        for order in [Order::Free, Order::Groups, Order::Stages] {
            for from in [None, Some(point)] {
                let settings =
                    Settings { order, from, bound_iterations: 20, ..Settings::default() };
                let route = solve(items, &settings, &Control::default()).unwrap();
                check(items, &settings, &route);
            }
        }
    }
    let solve = |items: &[Item<'_>]| solve(items, &Settings::default(), &Control::default());
    assert_eq!(solve(&equal).unwrap().travel_mm.to_bits(), 0.0_f64.to_bits());
    assert!((solve(&line).unwrap().travel_mm - 29.0).abs() <= 1e-9);
}

#[test]
fn unusable_items_are_errors() {
    let solve = |items: &[Item<'_>], from| {
        let settings = Settings { from, ..Settings::default() };
        solve(items, &settings, &Control::default())
    };
    for bad in [f64::NAN, f64::INFINITY, 1e10] {
        let items = [Item::bead([0.0, 0.0], [1.0, 0.0]), Item::bead([0.0, bad], [1.0, 0.0])];
        assert_eq!(solve(&items, None), Err(TravelError::Coordinate { item: 1 }));
        assert_eq!(
            solve(&[Item::closed(&[[bad, 0.0]])], None).unwrap_err().to_string(),
            "item 0: coordinate is not a finite number within 1e9 mm"
        );
        assert_eq!(solve(&items[..1], Some([bad, 0.0])), Err(TravelError::From));
    }
    assert_eq!(solve(&[Item::closed(&[])], None), Err(TravelError::NoEntry { item: 0 }));
}

#[test]
fn interrupted_search_returns_a_route() {
    let (shapes, _) = layer(300, 5);
    let items: Vec<Item<'_>> = shapes.iter().map(|points| Item::closed(points)).collect();
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let settings = Settings { bound_iterations: 50, ..Settings::default() };
    let route = solve(&items, &settings, &control).unwrap();
    check(&items, &settings, &route);
    assert_eq!(route.stop, Stop::Cancelled);
}

#[test]
fn twenty_thousand_items_are_ordered() {
    let (shapes, groups) = layer(20_000, 6);
    let items: Vec<Item<'_>> = shapes
        .iter()
        .zip(&groups)
        .map(|(points, &(group, stage))| Item::bead(points[0], points[1]).within(group, stage))
        .collect();
    for order in [Order::Free, Order::Stages] {
        let settings =
            Settings { order, kicks_per_item: 0, bound_iterations: 1, ..Settings::default() };
        let route = solve(&items, &settings, &Control::default()).unwrap();
        check(&items, &settings, &route);
        assert_eq!(route.bound_mm, None);
        let nearest = nearest_neighbour(&items, order, None).unwrap();
        println!("{order:?}: {:.4} of nearest neighbours", route.travel_mm / nearest.travel_mm);
        assert!(route.travel_mm <= 0.9 * nearest.travel_mm);
    }
}
