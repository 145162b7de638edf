//! Random parts as an environment, plans of policies for any part, and the committed policy.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::path::Path;
use std::sync::Arc;

use beadwork_base::{CancelToken, Control};
use beadwork_dataset::random_part;
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver, ThermalModel};
use beadwork_heat::plan::{HeatPlan, same_order};
use beadwork_learn::Device;
use beadwork_learn::ppo::{
    self, Environment, HeatEnvironment, HeatPolicy, HeatPolicyError, HeatSettings, HeatTask, Kept,
    Observation, Policy, PolicyTask, RandomHeatEnvironment, RandomHeatTask, TrainingConfig,
};
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order};
use beadwork_search::Stop;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use ndarray::Array3;
use tempfile::tempdir;

fn cost() -> LayerCost {
    LayerCost::of(Objective::Reward).unwrap()
}

/// Random parts of a few small layers.
fn small_parts(settings: HeatSettings) -> RandomHeatTask {
    let orders = OrderSet::Patterns.orders();
    let parts = random_part::Settings {
        width: 20,
        height: 16,
        min_layers: 2,
        max_layers: 4,
        min_side: 6,
        max_side: 14,
        max_indentation_side: 4,
        ..random_part::Settings::default()
    };
    RandomHeatTask { parts, count: 5, ..RandomHeatTask::new(orders, cost(), settings) }
}

fn unprinted(part: &Arc<Voxels>) -> Solver {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let method = Method::Fast(Accuracy::Draft);
    Solver::new(part.clone(), &material, &process, method, cost()).unwrap()
}

/// A part of `size` voxels in a larger grid, of which `inside` are filled.
fn part([x, y, z]: [usize; 3], inside: impl Fn([usize; 3]) -> bool) -> Arc<Voxels> {
    let (width, height) = (x as u32 + 5, y as u32 + 3);
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    let material = |(z, row, column): (usize, usize, usize)| {
        let is_inside = (2..2 + x).contains(&column) && (1..=y).contains(&row);
        if is_inside && inside([column - 2, row - 1, z]) { 0 } else { Voxels::EMPTY }
    };
    Arc::new(Voxels::new(frame, Array3::from_shape_fn((z, y + 3, x + 5), material)))
}

/// A policy for any part, hardly trained.
fn untrained(folder: &Path) -> HeatPolicy {
    let task = PolicyTask {
        orders: OrderSet::Patterns,
        objective: Objective::Reward,
        depth: 4,
        window: 16,
    };
    std::fs::write(PolicyTask::file(folder), task.to_toml()).unwrap();
    let config = TrainingConfig {
        steps: 8,
        environments: 4,
        rollout: 2,
        minibatches: 2,
        evaluation_episodes: 2,
        ..TrainingConfig::general()
    };
    let environment =
        RandomHeatEnvironment::new(Arc::new(small_parts(HeatSettings::general()))).unwrap();
    let mut observer = |_: &_| {};
    let run = ppo::Run { device: Device::Cpu, out: folder, observer: &mut observer };
    ppo::train(&|| environment.clone(), &config, run, &Control::default()).unwrap();
    HeatPolicy::open(folder, Device::Cpu).unwrap()
}

/// Checks a plan against the solver: each cell once, times and costs as simulated.
fn check(plan: &HeatPlan, part: &Arc<Voxels>) {
    let mut solver = unprinted(part);
    assert_eq!(plan.layers.len(), part.depth);
    for (layer, planned) in plan.layers.iter().enumerate() {
        let mut cells = planned.path.clone();
        cells.sort_unstable();
        assert!(cells.iter().copied().eq(part.cells(layer)));
        if cells.is_empty() {
            assert!(planned.order.is_none());
            continue;
        }
        let region = part.region(layer).unwrap();
        assert_eq!(planned.order.unwrap().order(&region), planned.path);
        let seconds = solver.path_seconds(layer as u32, &planned.path);
        assert!((planned.seconds - seconds).abs() < 1e-9 * (1.0 + seconds));
        let cost = solver.deposit(layer as u32, &planned.path, &Control::default()).unwrap();
        assert!((planned.cost - cost).abs() < 1e-9, "{} {cost}", planned.cost);
    }
}

#[test]
fn episodes_print_the_part_of_their_seed() {
    let task = Arc::new(small_parts(HeatSettings::general()));
    let mut environment = RandomHeatEnvironment::new(task.clone()).unwrap();
    let space = environment.space();
    let mut first_observations: Vec<Observation> = Vec::new();
    for seed in 0..12 {
        let mut observation = environment.reset(seed);
        let part = Arc::new(task.part(seed % 5).unwrap());
        let (mut solver, mut baseline) = (unprinted(&part), 0.0);
        let conventional = same_order(&solver, Order::CONVENTIONAL, &Control::default()).unwrap();
        let (mut gain, mut cost) = (0.0, 0.0);
        for layer in 0..part.depth {
            assert!(space.fits(&observation));
            assert_eq!(environment.space(), space);
            let wanted = (seed as usize * 7 + layer * 11) % 38;
            let permitted = |action: &usize| observation.permitted[*action];
            let action = (wanted..38).chain(0..38).find(permitted).unwrap();
            let order = task.orders[action].order(&part.region(layer).unwrap());
            cost += solver.deposit(layer as u32, &order, &Control::default()).unwrap();
            baseline += conventional.layers[layer].cost;
            let step = environment.step(action);
            gain += step.reward;
            assert_eq!(step.end.is_some(), layer + 1 == part.depth);
            if layer == 0 {
                first_observations.push(step.observation.clone());
            }
            observation = step.observation;
        }
        // The return is the gain in percent, whether the baseline was simulated or known.
        let expected = 100.0 * (baseline - cost) / baseline;
        assert!((gain - expected).abs() < 1e-9, "{gain} for {expected}");
    }
    assert_ne!(first_observations[0], first_observations[1]);
    // Without a limit, episodes of one part are alike.
    let mut again = RandomHeatEnvironment::new(task).unwrap();
    assert_eq!(again.reset(11), environment.reset(1));
}

#[test]
fn half_of_the_episodes_have_a_limit() {
    let settings = HeatSettings { max_time_ratio: Some(1.05), ..HeatSettings::general() };
    let mut environment = RandomHeatEnvironment::new(Arc::new(small_parts(settings))).unwrap();
    let mut limited = 0;
    for seed in 0..100 {
        let slack = environment.reset(seed).tensors[2][3];
        assert!((0.0..=0.05 + 1e-6).contains(&slack) || slack.to_bits() == 1.0_f32.to_bits());
        limited += usize::from(slack < 1.0);
    }
    assert!((30..70).contains(&limited), "{limited}");
}

#[test]
fn candidates_are_described_relative_to_the_baseline() {
    let part = part([40, 6, 2], |_| true);
    let orders = OrderSet::Patterns.orders();
    let settings = HeatSettings::general();
    let task = Arc::new(HeatTask::named(unprinted(&part), &orders, &settings).unwrap());
    let mut environment = HeatEnvironment::new(task);
    let observation = environment.reset(0);
    // Observed cells are 3 x 3 voxels, and the part is in the middle of the window.
    let shares = &observation.tensors[1][..256];
    let rows: Vec<f32> = shares.chunks_exact(16).map(|row| row.iter().sum()).collect();
    let voxels: f32 = shares.iter().sum::<f32>() * 9.0;
    assert!((voxels - 240.0).abs() < 1e-3);
    assert!(rows[..6].iter().chain(&rows[10..]).all(|&sum| sum.abs() < 1e-6), "{rows:?}");
    assert!((observation.tensors[2][4] - 3.0 / 8.0).abs() < 1e-6);
    let solver = unprinted(&part);
    let conventional = &observation.tensors[3][5 * settings.baseline..][..5];
    assert!(conventional[..3].iter().all(|&value| value.abs() < 1e-6));
    for (order, numbers) in orders.iter().zip(observation.tensors[3].chunks_exact(5)) {
        let cells = order.order(&part.region(0).unwrap());
        let seconds = |cells: &Vec<u32>| solver.path_seconds(0, cells);
        let baseline = orders[settings.baseline].order(&part.region(0).unwrap());
        let relative = 10.0 * (seconds(&cells) / seconds(&baseline) - 1.0);
        assert!((f64::from(numbers[0]) - relative.clamp(-3.0, 3.0)).abs() < 1e-5);
        assert!(numbers[3..].iter().all(|share| (0.0..1.0).contains(share)));
    }
}

#[test]
fn plans_of_policies_keep_to_the_limit() {
    let folder = tempdir().unwrap();
    let policy = untrained(folder.path());
    let parts = [
        part([12, 9, 4], |[x, y, z]| !(x > 7 && y > 5 && z > 0)),
        part([30, 5, 3], |[x, _, z]| z != 1 || x < 20),
        // A layer without cells, a single cell, and nothing at all.
        part([6, 6, 3], |[_, _, z]| z != 1),
        part([5, 5, 2], |at| at == [2, 2, 0] || at == [2, 2, 1]),
        part([5, 5, 2], |_| false),
        // Larger than any part it was trained on.
        part([150, 20, 2], |_| true),
    ];
    for part in &parts {
        let solver = unprinted(part);
        let conventional = same_order(&solver, Order::CONVENTIONAL, &Control::default()).unwrap();
        for ratio in [1.0, 1.001, 1.02, 1.2, f64::INFINITY] {
            let limit = ratio * conventional.seconds();
            // Nothing takes no time, and has no limit.
            let limit = if limit.is_nan() { f64::INFINITY } else { limit };
            let plan = policy.plan(&solver, limit, &Control::default()).unwrap();
            check(&plan, part);
            assert!(plan.seconds() <= limit, "{} of {limit}", plan.seconds());
            assert_eq!(plan.stop, Stop::Done);
        }
        if conventional.seconds() > 0.0 {
            let error = policy.plan(&solver, 0.99 * conventional.seconds(), &Control::default());
            assert!(matches!(error, Err(HeatPolicyError::TooSlow { .. })));
        }
    }
    // After an interruption, the other layers are conventional.
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let plan = policy.plan(&unprinted(&parts[0]), f64::INFINITY, &control).unwrap();
    assert_eq!(plan.stop, Stop::Cancelled);
    assert!(plan.layers.iter().all(|layer| layer.order == Some(Order::CONVENTIONAL)));
}

#[test]
fn policies_that_do_not_fit_their_task_are_refused() {
    let folder = tempdir().unwrap();
    untrained(folder.path());
    let file = PolicyTask::file(folder.path());
    let message = |text: &str| {
        std::fs::write(&file, text).unwrap();
        HeatPolicy::open(folder.path(), Device::Cpu).unwrap_err().to_string()
    };
    let task = std::fs::read_to_string(&file).unwrap();
    assert!(message(&task.replace("16", "8")).contains("does not fit its task.toml"));
    assert!(message(&task.replace("patterns", "lines")).contains("does not fit its task.toml"));
    assert!(message(&task.replace("patterns", "none")).contains("unknown set of orders 'none'"));
    assert!(message(&task.replace("16", "0")).contains("window is 0"));
    std::fs::remove_file(&file).unwrap();
    let error = HeatPolicy::open(folder.path(), Device::Cpu).unwrap_err().to_string();
    assert!(error.starts_with("cannot read"), "{error}");
    assert!(Policy::open(folder.path(), Kept::Last, Device::Cpu).is_ok());
}

#[test]
fn the_committed_policy_gains_on_a_small_part() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/ppo-small");
    let policy = HeatPolicy::open(&folder, Device::Cpu).unwrap();
    assert_eq!(policy.policy.config.resolved(), {
        let text = std::fs::read_to_string(Policy::config_file(&folder)).unwrap();
        TrainingConfig::from_toml(&text).unwrap().resolved()
    });
    let part = part([30, 24, 4], |[x, y, z]| !(x > 20 && y > 12 && z > 1));
    let solver = unprinted(&part);
    let conventional = same_order(&solver, Order::CONVENTIONAL, &Control::default()).unwrap();
    for (ratio, minimum) in [(f64::INFINITY, 2.0), (1.02, 0.0)] {
        let limit = ratio * conventional.seconds();
        let plan = policy.plan(&solver, limit, &Control::default()).unwrap();
        check(&plan, &part);
        let gain = 100.0 * (1.0 - plan.cost() / conventional.cost());
        assert!(gain > minimum, "{gain} %");
    }
}
