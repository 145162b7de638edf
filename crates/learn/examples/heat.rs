//! Trains a policy that chooses the order of each layer of a part, for even temperature, and
//! compares it with a greedy choice among the same candidates.
//!
//! ```text
//! cargo run --release -p beadwork-learn --example heat -- rect 1 runs/heat
//! cargo run --release -p beadwork-learn --example heat -- rect 1 runs/lines all 1.02 - estimated
//! ```
//!
//! The arguments are the part (rect, u or pyramid), the seed and the folder to write to.
//! Optional arguments, `-` for the default:
//! - the candidates: `patterns` (the default), `lines` or `all`;
//! - the limit on the printing time, as a ratio to the conventional one; by default, none;
//! - a configuration file; by default, the preset `small`, or `estimated` with estimates;
//! - how observations describe each candidate: by default, not at all; `described`, by crude
//!   estimates, as for random parts; `estimated`, by those of the planner `lines`;
//! - the price of time, K/s: by default, 0; `estimated`, the price of the limit.
//!
//! With orders of lines, it also plans by `lines`, and anneals the lines of the policy's plan.

#![allow(clippy::print_stdout, reason = "an example reports on the terminal")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver, ThermalModel};
use beadwork_heat::plan::{HeatPlan, PlannedLayer};
use beadwork_heat::planner;
use beadwork_learn::Device;
use beadwork_learn::ppo::{
    self, Environment, Event, HeatEnvironment, HeatSettings, HeatTask, TimePrice, TrainingConfig,
};
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order, Pattern};
use beadwork_search::Stop;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use ndarray::Array3;

/// Whether a part has a voxel at x, y and z.
type Inside = fn([u32; 3]) -> bool;

/// The paper's parts, in voxels of 0.5 x 0.5 x 0.25 mm.
fn part(name: &str) -> Result<Voxels, String> {
    let (size, inside): ([u32; 3], Inside) = match name {
        "rect" => ([120, 40, 12], |_| true),
        "u" => ([90, 50, 12], |[x, y, _]| !(y >= 20 && (25..65).contains(&x))),
        "pyramid" => ([60, 60, 77], |[x, y, z]| {
            let side = (60.0 - 56.0 * f64::from(z) / 76.0).round() as u32;
            let from = (60 - side) / 2;
            (from..from + side).contains(&x) && (from..from + side).contains(&y)
        }),
        _ => return Err(format!("unknown part '{name}': expected rect, u or pyramid")),
    };
    let [width, height, depth] = size;
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    let material = |(z, y, x): (usize, usize, usize)| {
        if inside([x as u32, y as u32, z as u32]) { 0 } else { Voxels::EMPTY }
    };
    let shape = (depth as usize, height as usize, width as usize);
    Ok(Voxels::new(frame, Array3::from_shape_fn(shape, material)))
}

/// The gain of the plan that prints each layer in its best permitted order, and its actions.
fn greedy(task: &Arc<HeatTask>) -> (f64, Vec<usize>) {
    let mut environment = HeatEnvironment::new(task.clone());
    let mut observation = environment.reset(0);
    let (mut rewards, mut actions) = (0.0, Vec::new());
    loop {
        let permitted = observation.permitted.iter();
        let permitted: Vec<usize> = (0..)
            .zip(permitted)
            .filter_map(|(action, permitted)| permitted.then_some(action))
            .collect();
        let tried =
            Threads::Current.map(&permitted, |&action| environment.clone().step(action).reward);
        let best = (0..tried.len()).max_by(|&a, &b| tried[a].total_cmp(&tried[b]));
        let action = permitted[best.unwrap_or(0)];
        let step = environment.step(action);
        rewards += step.reward;
        actions.push(action);
        observation = step.observation;
        if step.end.is_some() {
            return (environment.score(rewards), actions);
        }
    }
}

/// Printing time of a plan, s.
fn seconds(task: &Arc<HeatTask>, actions: &[usize]) -> f64 {
    let mut environment = HeatEnvironment::new(task.clone());
    environment.reset(0);
    for &action in actions {
        environment.step(action);
    }
    environment.seconds()
}

/// The plan with these actions, so that its lines can be annealed.
fn named_plan(
    solver: &Solver,
    names: &[Order],
    actions: &[usize],
) -> Result<HeatPlan, Box<dyn Error>> {
    let mut solver = solver.clone();
    let mut layers = Vec::new();
    for (layer, &action) in (0..).zip(actions) {
        let cells = names[action].order(&solver.part().region(layer as usize)?);
        let seconds = solver.path_seconds(layer, &cells);
        let cost = solver.deposit(layer, &cells, &Control::default())?;
        layers.push(PlannedLayer { path: cells, order: Some(names[action]), seconds, cost });
    }
    Ok(HeatPlan { deposited_layers: layers.len(), layers, stop: Stop::Done })
}

#[allow(clippy::too_many_lines, reason = "the example is read from top to bottom")]
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, seed, out, rest @ ..] = arguments.as_slice() else {
        return Err("expected: part, seed, folder".into());
    };
    let names = rest.first().map_or("patterns", String::as_str).parse::<OrderSet>()?.orders();
    let limit = rest.get(1).filter(|limit| *limit != "-");
    let max_time_ratio = limit.map(|limit| limit.parse()).transpose()?;
    let observed = rest.get(3).map_or("-", String::as_str);
    let mut config = match rest.get(2).filter(|file| *file != "-") {
        Some(file) => TrainingConfig::from_toml(&std::fs::read_to_string(file)?)?,
        None if observed == "estimated" => TrainingConfig::estimated(),
        None => TrainingConfig::small(),
    };
    config.seed = seed.parse()?;
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;

    let part = Arc::new(part(name)?);
    let orders = |layer| {
        let region = part.region(layer)?;
        Ok(names.iter().map(|order| order.order(&region)).collect())
    };
    let orders = (0..part.depth).map(orders).collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let cost = LayerCost::of(Objective::Reward)?;
    let solver = Solver::new(part.clone(), &material, &process, Method::default(), cost)?;
    let baseline = names.iter().position(|&order| order == Order::CONVENTIONAL).unwrap_or(0);
    let observed = match observed {
        "-" => HeatSettings::default(),
        "described" => HeatSettings { window: Some(16), ..HeatSettings::default() },
        "estimated" => HeatSettings::estimated(),
        _ => return Err("expected: -, described or estimated".into()),
    };
    let time_price = match rest.get(4).map_or("-", String::as_str) {
        "-" => TimePrice::Free,
        "estimated" => TimePrice::Estimated,
        price => TimePrice::Given(price.parse()?),
    };
    let settings = HeatSettings { baseline, max_time_ratio, time_price, ..observed };
    let task = Arc::new(HeatTask::new(solver.clone(), orders, &settings)?);
    let baseline = task.baseline_reward();
    if task.time_price() > 0.0 {
        println!("price of time: {:.4} K/s", task.time_price());
    }
    let begin = Instant::now();
    let (greedy_gain, greedy_actions) = greedy(&task);
    let named = |actions: &[usize]| {
        let names: Vec<String> = actions.iter().map(|&action| names[action].to_string()).collect();
        names.join(" ")
    };
    let time =
        |actions: &[usize]| 100.0 * (seconds(&task, actions) / task.baseline_seconds() - 1.0);
    println!(
        "{name}: conventional {baseline:.3}; greedy {:.3} ({:+.2} %), time {:+.2} %, {:.1} s: {}",
        baseline + greedy_gain,
        -100.0 * greedy_gain / baseline,
        time(&greedy_actions),
        begin.elapsed().as_secs_f64(),
        named(&greedy_actions),
    );

    let limit = max_time_ratio.unwrap_or(f64::INFINITY) * task.baseline_seconds();
    let report = |what: &str, plan: &HeatPlan| {
        println!(
            "{what}: {:+.2} %, time {:+.2} %",
            100.0 * (1.0 + plan.cost() / baseline),
            100.0 * (plan.seconds() / task.baseline_seconds() - 1.0),
        );
    };
    let has_lines = names.len() > Pattern::ALL.len();
    let annealed = planner::Settings { max_seconds: limit, ..planner::Settings::default() };
    if has_lines {
        let unannealed = planner::Settings { annealing: None, ..annealed.clone() };
        for (what, settings) in [("lines, not annealed", &unannealed), ("lines", &annealed)] {
            report(what, &planner::plan(&solver, settings, &Control::on(Threads::Current))?);
        }
    }

    // A return is what a plan gains over the conventional one.
    let share = |gain: f64| 100.0 * gain / greedy_gain;
    let begin = Instant::now();
    let (mut mean, mut best, mut best_actions) = (f64::NAN, f64::NEG_INFINITY, Vec::new());
    let mut observer = |event: &Event| match event {
        Event::Updated(update) => {
            mean = update.mean_return.map_or(f64::NAN, share);
            if update.update.is_multiple_of(10) {
                println!(
                    "{:>7} steps {:>5.0} s {mean:>6.1} % entropy {:.2} kl {:.4} clip {:.2} \
                     value {:.3} explained {:.2}",
                    update.steps,
                    begin.elapsed().as_secs_f64(),
                    update.entropy,
                    update.approximate_kl,
                    update.clip_fraction,
                    update.value_loss,
                    update.explained_variance.unwrap_or(f64::NAN),
                );
            }
        }
        Event::Evaluated { steps, evaluation, .. } => {
            let share = share(evaluation.mean());
            println!(
                "{steps:>7} steps {:>5.0} s {share:>6.1} % of the way to greedy",
                begin.elapsed().as_secs_f64(),
            );
            if share > best {
                best = share;
                best_actions.clone_from(&evaluation.actions[0]);
            }
        }
        _ => {}
    };
    let make = || HeatEnvironment::new(task.clone());
    let run = ppo::Run { device: Device::Cpu, out, observer: &mut observer };
    ppo::train(&make, &config, run, &Control::on(Threads::Current))?;
    println!(
        "last {} training episodes {mean:.2} %, best evaluation {best:.2} % of the way to greedy, \
         time {:+.2} %, {:.0} s: {}",
        config.window,
        time(&best_actions),
        begin.elapsed().as_secs_f64(),
        named(&best_actions),
    );
    if has_lines {
        let plan = named_plan(&solver, &names, &best_actions)?;
        report("policy", &plan);
        let control = Control::on(Threads::Current);
        report("policy, lines annealed", &planner::refine(&solver, &plan, &annealed, &control)?);
    }
    Ok(())
}
