//! Run time of trying all 38 patterns on each layer, and the speed-up by a second thread.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::{control, progress};
use beadwork_heat::model::{LayerCost, Solver, ThermalModel};
use beadwork_heat::trials::try_orders;
use beadwork_part::Pattern;
use beadwork_thermal::ThermalMaterial;
use beadwork_thermal::objective::Objective;
use serde::Serialize;

use super::printing::{FAST, process};
use crate::heat_parts::{HeatPart, all_orders};
use crate::statistics::median;

/// Figures of the rectangular part: all patterns are tried on each layer, which is then deposited
/// in the conventional pattern.
#[derive(Serialize)]
pub(super) struct Patterns {
    /// Mean time over the layers for their 38 patterns on two threads, in seconds.
    mean_s: f64,
    /// Maximum time over the layers.
    #[serde(rename = "most_s")]
    max_s: f64,
    /// Time of two simulations one after the other, divided by their time on two threads: median
    /// over the layers.
    forks_ratio: f64,
}

pub(super) fn measure() -> anyhow::Result<Patterns> {
    let part = Arc::new(HeatPart::Rectangular.voxels());
    let pool = control::pool(2)?;
    let bar = progress::bar(part.depth as u64, "layers");
    let cost = LayerCost::of(Objective::Reward)?;
    let mut model = Solver::new(part.clone(), &ThermalMaterial::abs(), &process(), FAST, cost)?;
    let (mut all_patterns, mut ratios) = (Vec::new(), Vec::new());
    for (layer, orders) in (0..).zip(all_orders(&part)?) {
        let time = |orders: &[Vec<u32>], threads| -> anyhow::Result<f64> {
            let control = control::cancellable(threads)?;
            let begin = Instant::now();
            try_orders(&model, layer, orders, 1, |_, cost| cost, &control)?;
            Ok(begin.elapsed().as_secs_f64())
        };
        all_patterns.push(time(&orders, Threads::Pool(&pool))?);
        for _ in 0..5 {
            let twice = [orders[0].clone(), orders[0].clone()];
            ratios.push(time(&twice, Threads::One)? / time(&twice, Threads::Pool(&pool))?);
        }
        let conventional = &orders[Pattern::CONVENTIONAL.number()];
        model.deposit(layer, conventional, &control::cancellable(Threads::One)?)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mean_s = all_patterns.iter().sum::<f64>() / all_patterns.len() as f64;
    Ok(Patterns {
        mean_s,
        max_s: all_patterns.into_iter().fold(0.0, f64::max),
        forks_ratio: median(ratios),
    })
}

impl fmt::Display for Patterns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mean_s, max_s, forks_ratio } = self;
        writeln!(
            f,
            "| 38 patterns of a layer, 2 threads: mean s | max s \
             | two simulations, 1 thread / 2 threads |\n\
             |---|---|---|\n\
             | {mean_s:.2} | {max_s:.2} | {forks_ratio:.2} |"
        )
    }
}
