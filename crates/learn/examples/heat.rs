//! Trains a policy that chooses the order of each layer of a part, for even temperature, among the
//! 38 patterns, and compares it with a greedy choice.
//!
//! ```text
//! cargo run --release -p beadwork-learn --example heat -- rect 1 30 runs/heat
//! ```
//!
//! The arguments are the part (rect, u or pyramid), the seed, the time limit in minutes, the folder
//! to write to, and optionally a configuration file.

#![allow(clippy::print_stdout, reason = "an example reports on the terminal")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_grid::Cell;
use beadwork_learn::Device;
use beadwork_learn::ppo::{self, Event, HeatEnvironment, HeatTask, TrainingConfig};
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
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

/// The paper's reward when each layer is printed in its best order.
fn greedy_reward(unprinted: &Simulation, orders: &[Vec<Vec<Cell>>]) -> Result<f64, Box<dyn Error>> {
    let std_k = |end: &Simulation| end.statistics().map_or(0.0, |all| all.std_c);
    let control = Control::on(Threads::Current);
    let (mut simulation, mut reward) = (unprinted.clone(), 0.0);
    let mut names = Vec::new();
    for (layer, orders) in (0..).zip(orders) {
        let trials = simulation.best_order(layer, orders, f64::INFINITY, std_k, &control)?;
        let best = trials.best.ok_or("a layer has no order")?;
        reward -= best.cost;
        names.push(Pattern::ALL[best.index].name());
        simulation = best.simulation;
    }
    println!("greedy: {}", names.join(" "));
    Ok(reward)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, seed, minutes, out, rest @ ..] = arguments.as_slice() else {
        return Err("expected: part, seed, minutes, folder, and optionally a configuration".into());
    };
    let mut config = match rest.first() {
        Some(file) => TrainingConfig::from_toml(&std::fs::read_to_string(file)?)?,
        None => TrainingConfig::small(),
    };
    config.seed = seed.parse()?;
    let limit_s = 60.0 * minutes.parse::<f64>()?;
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;

    let part = Arc::new(part(name)?);
    let orders = |layer| {
        let region = part.region(layer)?;
        Ok(Pattern::ALL.iter().map(|pattern| pattern.order(&region)).collect())
    };
    let orders = (0..part.depth).map(orders).collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let unprinted = Simulation::new(part.clone(), &material, &process, Method::default())?;
    let begin = Instant::now();
    let greedy = greedy_reward(&unprinted, &orders)?;
    let greedy_s = begin.elapsed().as_secs_f64();
    let task = HeatTask::new(unprinted, orders, Pattern::CONVENTIONAL.number(), 4, 4)?;
    let task = Arc::new(task);
    let baseline = task.baseline_reward();
    println!("{name}: conventional {baseline:.3}, greedy {greedy:.3} ({greedy_s:.1} s)");

    // A return is what a plan gains over the conventional one.
    let share = |gain: f64| 100.0 * gain / (greedy - baseline);
    let begin = Instant::now();
    let (mut mean, mut best) = (f64::NAN, f64::NEG_INFINITY);
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
            let greedy = share(evaluation.mean());
            if greedy > best {
                let names = evaluation.actions[0].iter().map(|&action| Pattern::ALL[action].name());
                println!("policy: {}", names.collect::<Vec<_>>().join(" "));
            }
            best = best.max(greedy);
            println!(
                "{steps:>7} steps {:>5.0} s {greedy:>6.1} % of the way to greedy, best {best:.1} %",
                begin.elapsed().as_secs_f64(),
            );
        }
        _ => {}
    };
    let time_is_up = || begin.elapsed().as_secs_f64() > limit_s;
    let control = Control { time_is_up: Some(&time_is_up), ..Control::on(Threads::Current) };
    let make = || HeatEnvironment::new(task.clone());
    let run = ppo::Run { device: Device::Cpu, out, observer: &mut observer };
    let end = ppo::train(&make, &config, run, &control)?;
    println!("{end:?}: training episodes {mean:.2} %, best evaluation {best:.2} %");
    Ok(())
}
