//! Trains a policy for the task `CartPole-v1` with the published settings of the reference
//! implementation, and compares its returns with the published ones.
//!
//! ```text
//! cargo run --release -p beadwork-learn --example cart_pole -- 1 2 3
//! ```
//!
//! The arguments are the seeds.
//! `CleanRL` publishes 490.04 ± 6.12 for its `ppo.py`: the mean return of three seeds after 500,000
//! steps, and the deviation between them (docs/rl-algorithms/ppo.md).
//! Compared with it is the mean return of the last 100 training episodes.

#![allow(clippy::print_stdout, reason = "an example reports on the terminal")]

use std::error::Error;
use std::time::Instant;

use beadwork_base::Control;
use beadwork_learn::Device;
use beadwork_learn::ppo::tasks::CartPole;
use beadwork_learn::ppo::{self, Event, TrainingConfig};

/// Steps between two rows of the table.
const EVERY: u64 = 25_000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut seeds =
        std::env::args().skip(1).map(|seed| seed.parse()).collect::<Result<Vec<u64>, _>>()?;
    if seeds.is_empty() {
        seeds = vec![1, 2, 3];
    }
    let mut last = Vec::new();
    for seed in seeds {
        let config = TrainingConfig { seed, threads: 1, ..TrainingConfig::cart_pole() };
        let out = tempfile::tempdir()?;
        let begin = Instant::now();
        let (mut next, mut evaluated) = (EVERY, f64::NAN);
        let mut mean_return = f64::NAN;
        println!("seed {seed}\n  steps  return  evaluated  entropy  steps/s");
        let mut observer = |event: &Event| match event {
            Event::Evaluated { evaluation, .. } => evaluated = evaluation.mean(),
            Event::Updated(update) => {
                mean_return = update.mean_return.unwrap_or(f64::NAN);
                if update.steps >= next || update.update == config.updates() {
                    next += EVERY;
                    println!(
                        "{:>7}  {mean_return:>6.1}  {evaluated:>9.1}  {:>7.3}  {:>7.0}",
                        update.steps,
                        update.entropy,
                        update.steps as f64 / begin.elapsed().as_secs_f64(),
                    );
                }
            }
            _ => {}
        };
        let run = ppo::Run { device: Device::Cpu, out: out.path(), observer: &mut observer };
        ppo::train(&CartPole::default, &config, run, &Control::default())?;
        last.push(mean_return);
    }
    let count = last.len() as f64;
    let mean = last.iter().sum::<f64>() / count;
    let deviation = (last.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    println!("{} seeds: {mean:.2} ± {deviation:.2}; published: 490.04 ± 6.12", last.len());
    Ok(())
}
