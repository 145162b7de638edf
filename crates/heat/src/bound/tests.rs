//! The bound against many orders.

use beadwork_grid::Cell;
use beadwork_thermal::objective::Objective;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::candidates::OrderSet;
use crate::model::{Solver, ThermalModel};
use crate::plan::same_order;
use crate::testing::{part, solver};

fn bound(part: &Arc<Voxels>) -> HeatBound {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    heat_bound(part, &material, &process, Method::default(), &Control::default()).unwrap()
}

fn shuffled(mut cells: Vec<Cell>, rng: &mut Xoshiro256PlusPlus) -> Vec<Cell> {
    for last in (1..cells.len()).rev() {
        cells.swap(last, (rng.next_u64() % (last as u64 + 1)) as usize);
    }
    cells
}

fn random_order_cost(model: &Solver, part: &Voxels, rng: &mut Xoshiro256PlusPlus) -> f64 {
    let mut state = model.clone();
    let deposit = |layer: usize| {
        let cells = shuffled(part.cells(layer).collect(), rng);
        state.deposit(layer as u32, &cells, &Control::default()).unwrap()
    };
    (0..part.depth).map(deposit).sum()
}

#[test]
fn no_order_is_more_even_than_the_bound() {
    let parts = [
        part([24, 16, 6], |_| true),
        part([24, 16, 6], |[x, y, _]| x < 8 || y < 6),
        part([20, 20, 9], |[x, y, z]| x.min(y).min(19 - x).min(19 - y) >= z),
    ];
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
    let control = Control::default();
    for part in parts {
        let bound = bound(&part);
        let model = solver(&part, Objective::NoTravel);
        let conventional = same_order(&model, Order::CONVENTIONAL, &control).unwrap().cost();
        let gain = |cost: f64| 100.0 * (1.0 - cost / conventional);
        let (any, lines) = (bound.any_order_percent(), bound.whole_lines_percent());
        let (any, lines) = (any.unwrap(), lines.unwrap());
        assert!(0.0 < lines && lines < any && any < 100.0, "{lines} {any}");
        let best = OrderSet::All
            .orders()
            .into_iter()
            .step_by(3)
            .map(|order| gain(same_order(&model, order, &control).unwrap().cost()));
        let best = best.fold(f64::NEG_INFINITY, f64::max);
        assert!(best < lines, "{best} {lines}");
        for _ in 0..20 {
            let random = gain(random_order_cost(&model, &part, &mut rng));
            assert!(random < any, "{random} {any}");
        }
    }
}

#[test]
fn parts_of_any_shape_have_a_bound() {
    // A single cell, a layer without cells, a line, and an overhang.
    for part in [
        part([1, 1, 1], |_| true),
        part([6, 5, 3], |[_, _, z]| z != 1),
        part([9, 1, 2], |_| true),
        part([9, 4, 3], |[x, _, z]| z == 2 || x < 3),
    ] {
        let bound = bound(&part);
        assert_eq!(bound.any_order_std_c.len(), part.depth);
        for layer in 0..part.depth {
            let stds = [
                bound.any_order_std_c[layer],
                bound.whole_lines_std_c[layer],
                bound.conventional_std_c[layer],
            ];
            let is_empty = part.cells(layer).next().is_none();
            assert!(stds.iter().all(|std| std.is_finite() && *std >= 0.0), "{stds:?}");
            assert!(!is_empty || stds.iter().all(|std| std.to_bits() == 0), "{stds:?}");
        }
        assert!(bound.any_order_percent().is_none_or(f64::is_finite));
    }
}

#[test]
fn an_interrupted_bound_says_why() {
    let is_up = || true;
    let control = Control { time_is_up: Some(&is_up), ..Control::default() };
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let part = part([6, 5, 3], |_| true);
    let error = heat_bound(&part, &material, &process, Method::default(), &control).unwrap_err();
    assert!(matches!(error, BoundError::Deposit(DepositError::Interrupted(_))), "{error}");
}
