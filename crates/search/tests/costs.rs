//! Costs in any unit: the exact search with fractions, large numbers and forbidden crossings.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

use beadwork_base::Control;
use beadwork_grid::{Layout, LayoutSpec, Region, Zones};
use beadwork_search::CostMatrix;
use beadwork_search::exact::{Outcome, Settings, SolveError, solve};

fn instance(seed: u64) -> (Region, Zones) {
    let region = Region::rectangle(20, 15).unwrap();
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
    (region, zones)
}

fn solve_alone(seed: u64, costs: &CostMatrix) -> Outcome {
    let (region, zones) = instance(seed);
    let settings = Settings { costs: Some(costs), ..Settings::default() };
    solve(&region, &zones, &settings, &Control::default()).unwrap()
}

/// Costs of three zones, in multiples of `unit`.
fn costs(unit: f64) -> CostMatrix {
    CostMatrix::from_fn(3, |from, to| unit * [3.0, 5.0, 4.0, 7.0, 6.0][from + 2 * to - 1]).unwrap()
}

#[test]
fn outcomes_do_not_depend_on_the_unit() {
    for seed in 0..10 {
        let whole = solve_alone(seed, &costs(1.0));
        for unit in [0.25, 0.1] {
            let scaled = solve_alone(seed, &costs(unit));
            // The scale may add a factor of ten, which changes no comparison of costs.
            assert!((scaled.cost - unit * whole.cost).abs() < 1e-9 * whole.cost);
            assert_eq!(scaled.is_optimal(), whole.is_optimal());
        }
    }
}

#[test]
fn bounds_hold_for_costs_that_are_rounded_for_the_search() {
    for seed in 0..10 {
        let (whole, large) = (solve_alone(seed, &costs(1.0)), solve_alone(seed, &costs(1e6 / 7.0)));
        assert_eq!(large.pieces, whole.pieces);
        let unit = 1e6 / 7.0;
        assert!(large.bound <= large.cost && large.bound <= (1.0 + 1e-9) * unit * whole.cost);
        // Some bounds gain from costs being multiples of a large step, as whole numbers are.
        assert!(large.bound >= 0.9 * unit * whole.bound, "{} {}", large.bound, whole.bound);
    }
}

#[test]
fn forbidden_crossings_are_refused() {
    let (region, zones) = instance(0);
    let costs = CostMatrix::from_fn(3, |from, _| if from == 1 { f64::INFINITY } else { 1.0 });
    let costs = costs.unwrap();
    let settings = Settings { costs: Some(&costs), ..Settings::default() };
    let error = solve(&region, &zones, &settings, &Control::default()).unwrap_err();
    assert_eq!(error, SolveError::Forbidden { from: 1, to: 0 });
}
