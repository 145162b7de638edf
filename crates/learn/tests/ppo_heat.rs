//! The heat environment against the thermal solver, its network, and training on a small part.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_heat::model::{LayerCost, Screen, Solver, ThermalModel};
use beadwork_heat::trials::try_orders;
use beadwork_learn::Device;
use beadwork_learn::ppo::{
    self, Environment, EpisodeEnd, Event, FieldsConfig, HeatEnvironment, HeatError, HeatSettings,
    HeatTask, Kept, NetworkConfig, Observation, Policy, Space, Step, TimePrice, TrainingConfig,
};
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use ndarray::Array3;
use tch::{Kind, Tensor};
use tempfile::tempdir;

/// A part of 14 x 9 x 4 voxels in a larger frame, without a corner.
fn small_part() -> Arc<Voxels> {
    let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 20, 15);
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm, layer_mm, width, height };
    let material = |(z, y, x): (usize, usize, usize)| {
        let inside = (3..17).contains(&x) && (2..11).contains(&y) && !(x > 12 && y > 7 && z > 0);
        if inside { 0 } else { Voxels::EMPTY }
    };
    Arc::new(Voxels::new(frame, Array3::from_shape_fn((4, 15, 20), material)))
}

fn unprinted(part: &Arc<Voxels>) -> Simulation {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    Simulation::new(part.clone(), &material, &process, Method::default()).unwrap()
}

fn solver(part: &Arc<Voxels>, objective: Objective) -> Solver {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let cost = LayerCost::of(objective).unwrap();
    Solver::new(part.clone(), &material, &process, Method::default(), cost).unwrap()
}

fn orders(part: &Voxels) -> Vec<Vec<Vec<Cell>>> {
    (0..part.depth)
        .map(|layer| {
            let region = part.region(layer).unwrap();
            Pattern::ALL.iter().map(|pattern| pattern.order(&region)).collect()
        })
        .collect()
}

fn task() -> Arc<HeatTask> {
    let part = small_part();
    let settings = HeatSettings { depth: 2, ..HeatSettings::default() };
    Arc::new(HeatTask::new(solver(&part, Objective::Reward), orders(&part), &settings).unwrap())
}

fn std_k(simulation: &Simulation) -> f64 {
    simulation.statistics().unwrap().std_c
}

#[test]
fn the_return_is_the_gain_over_the_baseline() {
    let task = task();
    let part = small_part();
    let orders = orders(&part);
    let mut environment = HeatEnvironment::new(task.clone());
    for round in 0..5 {
        let mut observation = environment.reset(round);
        let (mut simulation, mut reward, mut gained) = (unprinted(&part), 0.0, 0.0);
        for (layer, orders) in orders.iter().enumerate() {
            let permitted = |action: &usize| observation.permitted[*action];
            let wanted = (round as usize * 7 + layer * 11) % 38;
            let action = (wanted..38).chain(0..38).find(permitted).unwrap();
            let step = environment.step(action);
            simulation.deposit(layer as u32, &orders[action], &Control::default()).unwrap();
            reward -= std_k(&simulation);
            gained += step.reward;
            let last = layer + 1 == part.depth;
            assert_eq!(step.end, last.then_some(EpisodeEnd::Terminated));
            observation = step.observation;
            assert!(environment.space().fits(&observation));
        }
        assert!((task.baseline_reward() + gained - reward).abs() < 1e-9);
    }
    // The baseline itself gains nothing.
    environment.reset(0);
    for _ in 0..part.depth {
        let Step { reward, .. } = environment.step(Pattern::CONVENTIONAL.number());
        assert!(reward.abs() < 1e-12);
    }
}

#[test]
fn rewards_follow_the_objective() {
    let part = small_part();
    for objective in [Objective::NoTravel, Objective::TimeAveraged, Objective::Peak] {
        let settings = HeatSettings::default();
        let task = HeatTask::new(solver(&part, objective), orders(&part), &settings).unwrap();
        let task = Arc::new(task);
        let (mut environment, mut gained) = (HeatEnvironment::new(task.clone()), 0.0);
        let (mut solver, mut cost) = (solver(&part, objective), 0.0);
        environment.reset(0);
        for (layer, orders) in (0..).zip(orders(&part)) {
            gained += environment.step(5).reward;
            cost += solver.deposit(layer, &orders[5], &Control::default()).unwrap();
        }
        assert!((task.baseline_reward() + gained + cost).abs() < 1e-9, "{objective}");
    }
}

#[test]
fn observations_show_the_part_around_the_layer() {
    let part = small_part();
    let mut environment = HeatEnvironment::new(task());
    let first = environment.reset(0);
    // The bounding box of 14 x 9 voxels in cells of 4 x 4.
    let expected = vec![vec![1, 2, 3, 4], vec![2, 3, 4], vec![4]];
    assert_eq!(environment.space(), Space { observation: expected, actions: 38 });
    assert!(first.tensors[0].iter().all(|value| value.to_bits() == 0));
    assert_eq!(first.tensors[1][0..4], [1.0, 1.0, 1.0, 0.5]);
    assert_eq!(first.tensors[2], [0.0; 4]);
    let second = environment.step(0).observation;
    // Nothing is below the first layer; it is above the ambient temperature and below the nozzle's.
    let (below, layer) = second.tensors[0].split_at(12);
    assert!(below.iter().all(|value| value.to_bits() == 0));
    assert!(layer.iter().all(|&value| value > 0.1 && value < 1.0), "{layer:?}");
    // The mean over cells, weighted by their voxels, is the mean over voxels.
    let order = &orders(&part)[0][0];
    let mut simulation = unprinted(&part);
    simulation.deposit(0, order, &Control::default()).unwrap();
    let mean = (simulation.statistics().unwrap().mean_c - 25.0) / (230.0 - 25.0);
    let shares = &first.tensors[1][..12];
    let weighted: f32 = layer.iter().zip(shares).map(|(value, share)| value * share).sum();
    let got = f64::from(weighted / shares.iter().sum::<f32>());
    assert!((got - mean).abs() < 1e-5, "{got} for {mean}");
    let last = order[order.len() - 1];
    let nozzle = [(last % 20) as f32 / 20.0, (last / 20) as f32 / 15.0];
    assert_eq!(second.tensors[2], [0.25, nozzle[0], nozzle[1], 0.0]);
}

#[test]
fn candidates_that_repeat_are_masked() {
    let part = small_part();
    let conventional = |layer| Pattern::CONVENTIONAL.order(&part.region(layer).unwrap());
    let other = |layer| Pattern::ALL[0].order(&part.region(layer).unwrap());
    let orders = (0..4)
        .map(|layer| vec![conventional(layer), conventional(layer), other(layer), other(layer)])
        .collect();
    let settings = HeatSettings { baseline: 1, ..HeatSettings::default() };
    let task = HeatTask::new(solver(&part, Objective::Reward), orders, &settings).unwrap();
    let observation = HeatEnvironment::new(Arc::new(task)).reset(0);
    assert_eq!(observation.permitted, [true, false, true, false]);
}

#[test]
fn tasks_that_cannot_be_printed_are_refused() {
    let part = small_part();
    let new = |orders: Vec<Vec<Vec<Cell>>>, settings: &HeatSettings| {
        HeatTask::new(solver(&part, Objective::Reward), orders, settings).unwrap_err()
    };
    let (all, usual) = (|| orders(&part), HeatSettings::default());
    let wrong = [
        HeatSettings { depth: 0, ..usual },
        HeatSettings { cell: 0, ..usual },
        HeatSettings { max_time_ratio: Some(0.9), ..usual },
        HeatSettings { max_time_ratio: Some(f64::NAN), ..usual },
        HeatSettings { max_time_ratio: Some(f64::INFINITY), ..usual },
        HeatSettings { time_price: TimePrice::Given(-0.1), ..usual },
        HeatSettings { time_price: TimePrice::Given(f64::NAN), ..usual },
    ];
    for settings in wrong {
        assert!(matches!(new(all(), &settings), HeatError::Settings(_)), "{settings:?}");
    }
    let baseline = HeatSettings { baseline: 38, ..usual };
    assert!(matches!(new(all(), &baseline), HeatError::Candidates { layer: 0, count: 38, .. }));
    assert!(matches!(new(all()[..3].to_vec(), &usual), HeatError::Layers { count: 3, .. }));
    let mut fewer = all();
    fewer[2].pop();
    assert!(matches!(new(fewer, &usual), HeatError::Candidates { layer: 2, count: 37, .. }));
    let mut broken = all();
    broken[1][5][0] = broken[1][5][1];
    assert!(matches!(new(broken, &usual), HeatError::Order { layer: 1, candidate: 5 }));
    let mut printed = solver(&part, Objective::Reward);
    printed.deposit(0, &all()[0][0], &Control::default()).unwrap();
    let error = HeatTask::new(printed, all(), &usual).unwrap_err();
    assert!(matches!(error, HeatError::Baseline(_)), "{error}");
}

#[test]
fn the_time_limit_holds_at_the_end_of_each_layer() {
    let part = small_part();
    let all = orders(&part);
    let mut baseline = unprinted(&part);
    let ends: Vec<f64> = (0..)
        .zip(&all)
        .map(|(layer, orders)| {
            let order = &orders[Pattern::CONVENTIONAL.number()];
            baseline.deposit(layer, order, &Control::default()).unwrap();
            baseline.seconds()
        })
        .collect();
    let mut masked = 0;
    for ratio in [1.0, 1.02, 1.1, 1.5] {
        let settings = HeatSettings { max_time_ratio: Some(ratio), ..HeatSettings::default() };
        let task = HeatTask::new(solver(&part, Objective::Reward), all.clone(), &settings).unwrap();
        let mut environment = HeatEnvironment::new(Arc::new(task));
        for round in 0..20 {
            let mut observation = environment.reset(round);
            for (layer, orders) in all.iter().enumerate() {
                // A candidate is masked if it repeats another one, or if it ends too late.
                let ends_at = |order: &Vec<Cell>| {
                    environment.seconds() + environment.solver().path_seconds(layer as u32, order)
                };
                let limit = ratio * ends[layer];
                let fastest = orders.iter().map(ends_at).fold(f64::INFINITY, f64::min);
                let permitted: Vec<usize> =
                    (0..38).filter(|&action| observation.permitted[action]).collect();
                if fastest > limit + 1e-9 {
                    assert_eq!(permitted.len(), 1);
                    assert!(ends_at(&orders[permitted[0]]) < fastest + 1e-9);
                }
                for (action, order) in orders.iter().enumerate() {
                    let end = ends_at(order);
                    if fastest < limit - 1e-9
                        && (end - limit).abs() > 1e-9
                        && !orders[..action].contains(order)
                    {
                        assert_eq!(observation.permitted[action], end < limit, "{action}");
                        masked += usize::from(end > limit);
                    }
                }
                let slack = observation.tensors[2][3];
                assert!(slack.is_finite(), "{slack}");
                let action = permitted[(round as usize * 13 + layer * 5) % permitted.len()];
                observation = environment.step(action).observation;
                assert!(environment.seconds() <= limit.max(fastest) + 1e-9);
                let simulated = environment.solver().simulation().seconds();
                assert!((environment.seconds() - simulated).abs() < 1e-6);
            }
        }
    }
    assert!(masked > 1000, "{masked}");
}

/// The task of the small part with a limit on the printing time.
fn limited(time_price: TimePrice, window: Option<usize>, relative: bool) -> Arc<HeatTask> {
    let part = small_part();
    let estimated = window.is_some();
    let max_time_ratio = Some(1.05);
    let usual = HeatSettings::default();
    let settings =
        HeatSettings { max_time_ratio, time_price, window, estimated, relative, ..usual };
    Arc::new(HeatTask::new(solver(&part, Objective::Reward), orders(&part), &settings).unwrap())
}

#[test]
fn priced_rewards_sum_to_the_gain_minus_the_price_of_the_excess_time() {
    for (relative, scale) in [(false, 1.0), (true, 100.0 / -task().baseline_reward())] {
        let mut free = HeatEnvironment::new(limited(TimePrice::Free, None, relative));
        let mut all_priced = 0;
        for price in [0.0, 0.01, 0.5, 20.0] {
            let task = limited(TimePrice::Given(price), None, relative);
            let mut priced = HeatEnvironment::new(task.clone());
            for round in 0..10 {
                // The mask is that of the limit alone, and so is everything else that is observed.
                let (mut observation, other) = (free.reset(round), priced.reset(round));
                assert_eq!(observation, other);
                let (mut gain, mut rewards) = (0.0, 0.0);
                for layer in 0..4 {
                    let permitted: Vec<usize> =
                        (0..38).filter(|&action| observation.permitted[action]).collect();
                    let action = permitted[(round as usize * 13 + layer * 5) % permitted.len()];
                    let (step, other) = (free.step(action), priced.step(action));
                    gain += step.reward;
                    rewards += other.reward;
                    assert_eq!(step.observation, other.observation);
                    observation = step.observation;
                }
                let excess_s = priced.seconds() - task.baseline_seconds();
                assert!((rewards - (gain - scale * price * excess_s)).abs() < 1e-9);
                assert!((priced.score(rewards) - gain).abs() < 1e-9);
                assert!((free.score(gain) - gain).abs() < 1e-12);
                all_priced += usize::from(price > 0.0 && excess_s.abs() > 0.1);
            }
        }
        assert!(all_priced > 10, "{all_priced}");
    }
}

#[test]
fn the_price_of_time_is_that_of_the_limit() {
    let price = |ratio: Option<f64>| {
        let part = small_part();
        let settings = HeatSettings {
            max_time_ratio: ratio,
            time_price: TimePrice::Estimated,
            ..HeatSettings::default()
        };
        let solver = solver(&part, Objective::Reward);
        HeatTask::new(solver, orders(&part), &settings).unwrap().time_price()
    };
    // The tighter the limit, the more a second is worth.
    let prices = [1.0, 1.02, 1.05, 1.1, 1.5, 10.0].map(|ratio| price(Some(ratio)));
    assert!(prices.is_sorted_by(|a, b| a >= b), "{prices:?}");
    assert!(prices[1] > 0.0 && prices[5] <= 0.0, "{prices:?}");
    assert!(price(None) <= 0.0);
}

#[test]
fn candidates_are_described_by_their_estimates() {
    let task = limited(TimePrice::Free, Some(16), false);
    let mut environment = HeatEnvironment::new(task.clone());
    let part = small_part();
    let orders = orders(&part);
    let (mut baseline, mut observation) = (solver(&part, Objective::Reward), environment.reset(0));
    for (layer, orders) in (0..).zip(&orders) {
        let numbers = &observation.tensors[3];
        assert_eq!(numbers.len(), 38 * 5);
        let screen = baseline.screen(layer).unwrap();
        let estimates: Vec<f64> = orders.iter().map(|order| screen.cost(order)).collect();
        // The candidate with the lowest estimate misses nothing, and others more by rank.
        let missed = |action: usize| numbers[5 * action + 2];
        let mut ranked: Vec<usize> = (0..38).collect();
        ranked.sort_by(|&a, &b| estimates[a].total_cmp(&estimates[b]));
        assert!(missed(ranked[0]) <= 0.0, "{}", missed(ranked[0]));
        assert!(ranked.is_sorted_by_key(|&action| missed(action)));
        assert!(missed(ranked[37]) > 0.5 && missed(ranked[37]) <= 3.0);
        let conventional = Pattern::CONVENTIONAL.number();
        let share = 4.0 * (estimates[3] / estimates[conventional] - 1.0);
        assert!((f64::from(numbers[5 * 3 + 1]) - share.clamp(-3.0, 3.0)).abs() < 1e-5);
        let order = &orders[conventional];
        baseline.deposit(layer, order, &Control::default()).unwrap();
        let last = observation.permitted.iter().rposition(|&permitted| permitted).unwrap();
        observation = environment.step(last).observation;
    }
    // Costs over time have no estimate.
    let settings = HeatSettings { estimated: true, window: Some(16), ..HeatSettings::default() };
    let over_time = solver(&part, Objective::TimeAveraged);
    let error = HeatTask::new(over_time, orders, &settings).unwrap_err();
    assert!(matches!(error, HeatError::NoEstimates), "{error}");
}

/// A configuration for the small part.
fn small() -> TrainingConfig {
    TrainingConfig {
        steps: 4096,
        environments: 8,
        rollout: 16,
        learning_rate: 2e-3,
        threads: 1,
        window: 30,
        network: NetworkConfig::Fields(FieldsConfig {
            volume: vec![4, 8],
            image: vec![4],
            pooled: 2,
            units: 32,
            ..FieldsConfig::small()
        }),
        ..TrainingConfig::small()
    }
}

#[test]
fn training_approaches_the_greedy_choice() {
    let task = task();
    let part = small_part();
    let (mut model, mut greedy) = (solver(&part, Objective::Reward), 0.0);
    for (layer, orders) in (0..).zip(orders(&part)) {
        let control = Control::default();
        let trials = try_orders(&model, layer, &orders, 1, |_, cost| cost, &control).unwrap();
        let best = trials.best.into_iter().next().unwrap();
        greedy -= best.cost;
        model = best.model;
    }
    let out = tempdir().unwrap();
    let mut evaluations = Vec::new();
    let mut observer = |event: &Event| {
        if let Event::Evaluated { evaluation, .. } = event {
            evaluations.push(evaluation.clone());
        }
    };
    let run = ppo::Run { device: Device::Cpu, out: out.path(), observer: &mut observer };
    let make = || HeatEnvironment::new(task.clone());
    ppo::train(&make, &small(), run, &Control::default()).unwrap();
    let best = evaluations.iter().max_by(|a, b| a.mean().total_cmp(&b.mean())).unwrap();
    let share = best.mean() / (greedy - task.baseline_reward());
    assert!(share > 0.9, "{share}");

    // The policy that was saved makes the same choices.
    let policy = Policy::open(out.path(), Kept::Evaluation, Device::Cpu).unwrap();
    let mut environment = make();
    let mut observation = environment.reset(0);
    let mut actions = Vec::new();
    let mut ended = false;
    while !ended {
        actions.push(policy.act(&observation));
        let step = environment.step(actions[actions.len() - 1]);
        ended = step.end.is_some();
        observation = step.observation;
    }
    assert_eq!(vec![actions], best.actions);
}

/// Observations of one step, whose end is the whole task: its space can be anything.
struct Blank {
    space: Space,
}

impl Environment for Blank {
    fn identity(&self) -> String {
        "task = \"blank\"".into()
    }

    fn space(&self) -> Space {
        self.space.clone()
    }

    fn reset(&mut self, seed: u64) -> Observation {
        let value = |index| ((index as u64 * 7919 + seed) % 101) as f32 / 101.0;
        let tensor = |shape: &Vec<i64>| (0..shape.iter().product::<i64>()).map(value).collect();
        Observation {
            tensors: self.space.observation.iter().map(tensor).collect(),
            permitted: vec![true; self.space.actions],
        }
    }

    fn step(&mut self, action: usize) -> Step {
        let reward = if action == 0 { 1.0 } else { 0.0 };
        Step { observation: self.reset(0), reward, end: Some(EpisodeEnd::Terminated) }
    }
}

/// Trains for two updates, and returns the last policy or the error.
fn policy_for(space: &Space, network: FieldsConfig) -> Result<Policy, String> {
    let out = tempdir().unwrap();
    let config = TrainingConfig {
        steps: 32,
        environments: 4,
        rollout: 4,
        threads: 1,
        network: NetworkConfig::Fields(network),
        ..TrainingConfig::default()
    };
    let mut observer = |_: &Event| {};
    let run = ppo::Run { device: Device::Cpu, out: out.path(), observer: &mut observer };
    let make = || Blank { space: space.clone() };
    ppo::train(&make, &config, run, &Control::default()).map_err(|error| error.to_string())?;
    Ok(Policy::open(out.path(), Kept::Last, Device::Cpu).unwrap())
}

#[test]
fn the_network_takes_fields_of_any_size() {
    let mut shapes = Vec::new();
    for (depth, y, x) in [(1, 1, 1), (2, 3, 7), (5, 16, 9), (16, 16, 16)] {
        let observation = vec![vec![2, depth, y, x], vec![3, y, x], vec![4]];
        let policy = policy_for(&Space { observation, actions: 5 }, FieldsConfig::small()).unwrap();
        let mut parameters: Vec<(String, Vec<i64>)> = policy
            .variables
            .variables()
            .into_iter()
            .map(|(name, tensor)| (name, tensor.size()))
            .collect();
        parameters.sort();
        shapes.push(parameters);
    }
    assert!(shapes.iter().all(|parameters| *parameters == shapes[0]));
    let names: Vec<&str> = shapes[0].iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.contains(&"extractor.0.2.conv1.weight"), "{names:?}");
    assert!(names.contains(&"actor.2.bias"), "{names:?}");
}

#[test]
fn gradients_reach_all_parameters_and_inputs() {
    let observation = vec![vec![1, 4, 11, 13], vec![2, 11, 13], vec![3]];
    let policy = policy_for(&Space { observation, actions: 5 }, FieldsConfig::small()).unwrap();
    let inputs: Vec<Tensor> = [vec![6, 1, 4, 11, 13], vec![6, 2, 11, 13], vec![6, 3]]
        .iter()
        .map(|shape: &Vec<i64>| {
            let count: i64 = shape.iter().product();
            let values: Vec<f32> = (0..count).map(|i| (i * i % 97) as f32 / 97.0).collect();
            Tensor::from_slice(&values).view(shape.as_slice()).set_requires_grad(true)
        })
        .collect();
    let output = policy.network.forward(&inputs);
    assert_eq!((output.logits.size(), output.value.size()), (vec![6, 5], vec![6]));
    (output.logits.square().sum(Kind::Float) + output.value.square().sum(Kind::Float)).backward();
    let parameters = policy.variables.variables().into_iter();
    let inputs = inputs.into_iter().map(|input| ("input".to_owned(), input));
    for (name, tensor) in parameters.chain(inputs) {
        let gradient = tensor.grad();
        assert!(
            gradient.defined() && gradient.abs().sum(Kind::Float).double_value(&[]) > 0.0,
            "{name}"
        );
    }
}

#[test]
fn networks_that_do_not_fit_are_refused() {
    let error = |space: &Space, network| policy_for(space, network).unwrap_err();
    let space = Space { observation: vec![vec![3, 4]], actions: 2 };
    assert!(error(&space, FieldsConfig::small()).contains("tensors of shape [3, 4]"));
    let space = Space { observation: vec![vec![1, 4, 4]], actions: 2 };
    let image = vec![8, 12];
    let message = error(&space, FieldsConfig { image, ..FieldsConfig::small() });
    assert!(message.starts_with("network.image is 12"), "{message}");
    for config in [TrainingConfig::small(), TrainingConfig::paper(), small()] {
        assert_eq!(TrainingConfig::from_toml(&config.resolved()).unwrap(), config);
    }
}
