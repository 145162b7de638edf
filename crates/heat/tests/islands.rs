//! Every planner on parts whose layers have several components.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::plan::{HeatPlan, same_order};
use beadwork_heat::planner::{Annealing, Planner, Settings, plan};
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order};
use beadwork_thermal::objective::{self, Objective, measure_plan};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use ndarray::Array3;
use proptest::prelude::*;

const SIZE: [usize; 3] = [3, 11, 14];

/// The voxels of which `inside` holds.
fn part(inside: impl Fn([usize; 3]) -> bool) -> Arc<Voxels> {
    let [_, height, width] = SIZE.map(|count| count as u32);
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    // Two materials, which are one for the heat.
    let material = |(z, y, x): (usize, usize, usize)| {
        if inside([x, y, z]) { u8::from(x > 8) } else { Voxels::EMPTY }
    };
    Arc::new(Voxels::new(frame, Array3::from_shape_fn(SIZE, material)))
}

fn solver(part: &Arc<Voxels>) -> Solver {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let cost = LayerCost::of(Objective::Reward).unwrap();
    Solver::new(part.clone(), &material, &process, Method::default(), cost).unwrap()
}

/// Plans a part with every planner, and checks that each cell is deposited once, within the limit,
/// at the cost that an independent simulation measures.
fn check(part: &Arc<Voxels>) {
    let (model, control) = (solver(part), Control::default());
    let conventional = same_order(&model, Order::CONVENTIONAL, &control).unwrap();
    for planner in Planner::ALL {
        let settings = Settings {
            planner,
            orders: OrderSet::All.orders().into_iter().step_by(9).collect(),
            max_seconds: 1.1 * conventional.seconds(),
            annealing: Some(Annealing { trials: 20, model_trials: 120, ..Annealing::default() }),
            ..Settings::default()
        };
        let plan = plan(&model, &settings, &control).unwrap();
        assert!(plan.seconds() <= settings.max_seconds, "{planner}");
        assert_eq!(plan.layers.len(), part.depth, "{planner}");
        for (layer, planned) in plan.layers.iter().enumerate() {
            let mut cells = planned.path.clone();
            cells.sort_unstable();
            assert_eq!(cells, part.cells(layer).collect::<Vec<_>>(), "{planner} {layer}");
        }
        assert!((plan.cost() + reward(part, &plan)).abs() < 1e-9, "{planner}");
    }
}

fn reward(part: &Arc<Voxels>, plan: &HeatPlan) -> f64 {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let (method, settings) = (Method::default(), objective::Settings::default());
    let (orders, control) = (plan.paths(), Control::default());
    measure_plan(part, &material, &process, method, &orders, &settings, &control).unwrap().reward()
}

#[test]
fn islands_are_planned() {
    // A frame around a block, beside a column of single cells, and a block without support.
    check(&part(|[x, y, z]| {
        let frame = x < 8 && y < 8 && (x == 0 || y == 0 || x == 7 || y == 7);
        let block = (2..6).contains(&x) && (2..6).contains(&y);
        frame || block || [x, y] == [10, 9] || (z == 2 && x > 11 && y < 4)
    }));
    // Cells that touch at corners only: every component is one cell.
    check(&part(|[x, y, z]| (x + y) % 2 == 0 && x + y + 2 * z < 14));
    // A layer of one cell.
    check(&part(|[x, y, z]| z == 0 && x < 5 || [x, y] == [2, 3]));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..<_>::default() })]

    #[test]
    fn scattered_cells_are_planned(
        filled in proptest::collection::vec(0_u8..3, SIZE.iter().product::<usize>()),
    ) {
        let [_, height, width] = SIZE;
        check(&part(|[x, y, z]| [x, y] == [0, 0] || filled[(z * height + y) * width + x] == 0));
    }
}
