//! Planners against each other, against slow searches, and under limits.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{CancelToken, Control, Threads};
use beadwork_part::slice::Voxels;
use beadwork_search::Stop;
use beadwork_thermal::objective::{self, HeatMeasures, Objective, Weighted, measure_plan};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};

use super::*;
use crate::fill::LineSet;
use crate::model::{LayerCost, Solver};
use crate::plan::same_order;
use crate::testing::{part, solver, stairs};

const PLANNERS: [Planner; 6] = [
    Planner::Conventional,
    Planner::Constant,
    Planner::Greedy,
    Planner::Beam,
    Planner::SmartScan,
    Planner::Lines,
];

/// Few candidates and little annealing, for short tests.
fn settings(planner: Planner) -> Settings {
    let orders = ["spiral-out-0", "zigzag-y-0", "lines-x-scattered-3-0", "lines-y-interleaved-2-0"];
    Settings {
        planner,
        orders: orders.map(|name| name.parse().unwrap()).to_vec(),
        beam_width: 3,
        screened: 3,
        annealing: Some(Annealing {
            runs: 2,
            trials: 20,
            model_trials: 160,
            ..Annealing::default()
        }),
        ..Settings::default()
    }
}

fn conventional(model: &Solver) -> HeatPlan {
    same_order(model, Order::CONVENTIONAL, &Control::default()).unwrap()
}

fn measures(part: &Arc<Voxels>, plan: &HeatPlan) -> HeatMeasures {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let settings = objective::Settings::default();
    let method = Method::default();
    let control = Control::default();
    measure_plan(part, &material, &process, method, &plan.paths(), &settings, &control).unwrap()
}

#[test]
fn plans_print_every_cell_once_and_cost_what_they_say() {
    let part = stairs();
    let model = solver(&part, Objective::Reward);
    for planner in PLANNERS {
        let plan = plan(&model, &settings(planner), &Control::default()).unwrap();
        assert_eq!(plan.stop, Stop::Done);
        for (z, layer) in plan.layers.iter().enumerate() {
            let mut cells = layer.path.clone();
            cells.sort_unstable();
            assert_eq!(cells, part.cells(z).collect::<Vec<_>>());
            if let Some(order) = layer.order {
                assert_eq!(layer.path, order.order(&part.region(z).unwrap()));
            }
        }
        let measures = measures(&part, &plan);
        assert!((plan.cost() + measures.reward()).abs() < 1e-9, "{planner}");
        assert!((plan.seconds() - measures.print_seconds()).abs() < 1e-9);
    }
}

#[test]
fn costs_are_the_objectives_of_the_print() {
    let part = stairs();
    let plan = conventional(&solver(&part, Objective::Reward));
    let measures = measures(&part, &plan);
    for objective in [Objective::Reward, Objective::NoTravel, Objective::Peak] {
        let cost = conventional(&solver(&part, objective)).cost();
        assert!((cost - objective.cost(&measures).unwrap()).abs() < 1e-9, "{objective}");
    }
    let weighted: Weighted = "reward=2,no_travel=1,time_averaged=0.5,peak=1.5".parse().unwrap();
    let cost = LayerCost::relative(&weighted, &measures).unwrap();
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let model = Solver::new(part, &material, &process, Method::default(), cost).unwrap();
    // The time average weights layers by their voxels instead of their time.
    assert!((conventional(&model).cost() - 5.0).abs() < 0.05);
    assert!(LayerCost::of(Objective::Warpage).is_err());
    assert!(LayerCost::relative(&"warpage".parse().unwrap(), &measures).is_err());
}

#[test]
fn greedy_takes_the_best_order_of_each_layer() {
    let part = stairs();
    let model = solver(&part, Objective::Reward);
    let settings = settings(Planner::Greedy);
    let plan = plan(&model, &settings, &Control::default()).unwrap();
    let mut state = model.clone();
    for (z, layer) in plan.layers.iter().enumerate() {
        let region = part.region(z).unwrap();
        let orders = [Order::CONVENTIONAL].into_iter().chain(settings.orders.iter().copied());
        let costs = orders.map(|order| {
            let mut fork = state.clone();
            fork.deposit(z as u32, &order.order(&region), &Control::default()).unwrap()
        });
        let best = costs.fold(f64::INFINITY, f64::min);
        assert_eq!(layer.cost.to_bits(), best.to_bits());
        state.deposit(z as u32, &layer.path, &Control::default()).unwrap();
    }
}

#[test]
fn no_planner_is_worse_than_the_one_before() {
    let part = part([14, 9, 4], |[x, y, _]| x < 5 || y < 4);
    let model = solver(&part, Objective::Reward);
    let cost = |planner| plan(&model, &settings(planner), &Control::default()).unwrap().cost();
    let costs = PLANNERS.map(cost);
    assert!(costs[1] <= costs[0], "{costs:?}");
    assert!(costs[3] <= costs[2], "{costs:?}");
    assert!(costs[4] <= costs[0], "{costs:?}");
    let mut unrefined = settings(Planner::Lines);
    unrefined.annealing = None;
    let unrefined = plan(&model, &unrefined, &Control::default()).unwrap();
    assert!(unrefined.cost() <= costs[0]);
}

#[test]
fn a_wide_beam_finds_the_best_of_all_sequences() {
    let part = part([8, 6, 3], |_| true);
    let model = solver(&part, Objective::Reward);
    let names = ["spiral-in-0", "zigzag-y-0"];
    let orders = names.map(|name| name.parse().unwrap()).to_vec();
    let settings = Settings { orders, beam_width: 27, ..settings(Planner::Beam) };
    let beam = plan(&model, &settings, &Control::default()).unwrap();
    let candidates = [Order::CONVENTIONAL, settings.orders[0], settings.orders[1]];
    let region = part.region(0).unwrap();
    let mut best = f64::INFINITY;
    for sequence in 0..27 {
        let mut state = model.clone();
        let deposit = |layer: u32| {
            let order = candidates[sequence / 3_usize.pow(layer) % 3].order(&region);
            state.deposit(layer, &order, &Control::default()).unwrap()
        };
        best = best.min((0..3).map(deposit).sum());
    }
    assert!((beam.cost() - best).abs() < 1e-9);
}

#[test]
fn limits_on_the_printing_time_hold() {
    let part = part([16, 9, 4], |[x, y, z]| x < 5 || y < 4 + z);
    let model = solver(&part, Objective::NoTravel);
    let conventional = conventional(&model).seconds();
    for planner in PLANNERS {
        let mut last = f64::INFINITY;
        for factor in [1.0, 1.01, 1.05, 1.2] {
            let max_seconds = factor * conventional;
            let settings = Settings { max_seconds, ..settings(planner) };
            let plan = plan(&model, &settings, &Control::default()).unwrap();
            assert!(plan.seconds() <= max_seconds, "{planner} {factor}");
            if planner == Planner::Constant {
                assert!(plan.cost() <= last);
                last = plan.cost();
            }
        }
        let settings = Settings { max_seconds: 0.5 * conventional, ..settings(planner) };
        let error = plan(&model, &settings, &Control::default()).unwrap_err();
        assert!(matches!(error, PlanError::TooSlow { .. }), "{planner}: {error}");
    }
}

#[test]
fn threads_do_not_change_plans() {
    let part = stairs();
    let model = solver(&part, Objective::Reward);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for planner in PLANNERS {
        let settings = settings(planner);
        let alone = plan(&model, &settings, &Control::default()).unwrap();
        let parallel = plan(&model, &settings, &Control::on(Threads::Pool(&pool))).unwrap();
        assert_eq!(alone, parallel);
    }
}

#[test]
fn interrupted_planners_return_a_whole_plan() {
    let part = stairs();
    let model = solver(&part, Objective::Reward);
    for &planner in &PLANNERS[1..] {
        for polls in [0, 1, 5, 40, 200, 900] {
            let left = AtomicUsize::new(polls);
            let is_up = || {
                left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1))
                    .is_err()
            };
            let control = Control { time_is_up: Some(&is_up), ..Control::default() };
            let plan = plan(&model, &settings(planner), &control).unwrap();
            let cells = plan.layers.iter().map(|layer| layer.path.len()).sum::<usize>();
            assert_eq!(cells, part.count(), "{planner} {polls}");
            let measured = measures(&part, &plan).reward();
            assert!((plan.cost() + measured).abs() < 1e-9, "{planner} {polls}");
        }
        let cancel = CancelToken::new();
        cancel.cancel();
        let control = Control { cancel: Some(&cancel), ..Control::default() };
        let plan = plan(&model, &settings(planner), &control).unwrap();
        assert_eq!(plan.stop, Stop::Cancelled, "{planner}");
    }
}

#[test]
fn lines_in_two_parts_are_the_layer() {
    let part = part([14, 9, 3], |[x, y, z]| x < 5 || y < 4 + z);
    for objective in [Objective::Reward, Objective::NoTravel] {
        let mut whole = solver(&part, objective);
        for layer in 0..3 {
            let lines = whole.fill().lines(layer, None);
            let order = lines.start(whole.position());
            let (begin, tail) = order.split_at(order.len() / 2);
            let control = Control::default();
            let mut parts = whole.clone();
            parts.deposit_lines(layer, &lines.path(begin, parts.position()), &control).unwrap();
            let rest = lines.rest(tail, parts.position());
            let cost = parts.deposit_lines(layer, &rest, &control).unwrap();
            let path = lines.path(&order, whole.position());
            let expected = whole.deposit(layer, &path, &control).unwrap();
            assert!((cost / expected - 1.0).abs() < 2e-3, "{objective}: {cost} {expected}");
            assert_eq!(parts.position(), whole.position());
        }
    }
}

#[test]
fn annealing_on_the_model_gains_more_than_on_the_screen() {
    let part = part([40, 24, 3], |[x, y, _]| x < 14 || y < 10);
    let model = solver(&part, Objective::NoTravel);
    let cost = |model_trials: usize| {
        let annealing = Annealing { trials: 600, model_trials, ..Annealing::default() };
        let settings = Settings { annealing: Some(annealing), ..settings(Planner::Lines) };
        plan(&model, &settings, &Control::default()).unwrap().cost()
    };
    let (with, without) = (cost(300), cost(0));
    assert!(with < without, "{with} {without}");
}

#[test]
fn lines_cannot_plan_for_measures_over_time() {
    let model = solver(&stairs(), Objective::TimeAveraged);
    let error = plan(&model, &settings(Planner::Lines), &Control::default()).unwrap_err();
    assert_eq!(error, PlanError::NoScreen);
    assert!(plan(&model, &settings(Planner::Greedy), &Control::default()).is_ok());
}

#[test]
fn layers_without_cells_stay_empty() {
    let part = part([6, 5, 3], |[_, _, z]| z != 1);
    let model = solver(&part, Objective::Reward);
    for planner in PLANNERS {
        let plan = plan(&model, &settings(planner), &Control::default()).unwrap();
        assert_eq!(plan.layers[1].path, [0; 0]);
        assert_eq!((plan.layers[1].order, plan.layers[1].seconds), (None, 0.0));
        assert_eq!(plan.layers.len(), 3);
    }
}

#[test]
fn refined_plans_cost_no_more_and_keep_to_the_limit() {
    let part = stairs();
    let model = solver(&part, Objective::Reward);
    let control = Control::default();
    for name in ["contour-zigzag-x-0", "lines-x-scattered-3-0"] {
        let first = same_order(&model, name.parse().unwrap(), &control).unwrap();
        for ratio in [1.0, 1.03, f64::INFINITY] {
            let max_seconds = ratio * first.seconds();
            let settings = Settings { max_seconds, ..settings(Planner::Lines) };
            let refined = refine(&model, &first, &settings, &control).unwrap();
            assert!(refined.seconds() <= max_seconds);
            for (z, layer) in refined.layers.iter().enumerate() {
                let mut cells = layer.path.clone();
                cells.sort_unstable();
                assert_eq!(cells, part.cells(z).collect::<Vec<_>>());
            }
            let measures = measures(&part, &refined);
            assert!((refined.cost() + measures.reward()).abs() < 1e-9);
            assert!(refined.cost() <= first.cost(), "{name} {ratio}");
            if ratio.is_infinite() {
                assert!(refined.cost() < first.cost(), "{name}");
            }
            let kept = Settings { annealing: None, ..settings.clone() };
            assert_eq!(refine(&model, &first, &kept, &control).unwrap(), first);
        }
        let short = Settings { max_seconds: 0.9 * first.seconds(), ..settings(Planner::Lines) };
        let error = refine(&model, &first, &short, &control);
        assert!(matches!(error, Err(PlanError::TooSlow { .. })));
    }
}
