//! All 38 patterns of each layer, tried from one state, and two forks on two threads.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_part::Pattern;
use beadwork_thermal::{Simulation, ThermalMaterial};
use serde::Serialize;

use super::{FAST, process};
use crate::bench::middle;
use crate::heat_parts::{HeatPart, all_orders};

/// On the rectangular part, whose layers are then laid by the conventional pattern.
#[derive(Serialize)]
pub(super) struct Patterns {
    /// Seconds for the 38 patterns of a layer on two threads, mean and most over the layers.
    mean_s: f64,
    most_s: f64,
    /// Time of two forks one after the other over that on two threads: the median over the layers
    /// and their ends.
    forks_ratio: f64,
}

pub(super) fn measure() -> anyhow::Result<Patterns> {
    let part = Arc::new(HeatPart::Rectangular.voxels());
    let pool = control::pool(2)?;
    let mut simulation = Simulation::new(part.clone(), &ThermalMaterial::abs(), &process(), FAST)?;
    let (mut all, mut ratios) = (Vec::new(), Vec::new());
    for (layer, orders) in all_orders(&part)?.iter().enumerate() {
        let time = |orders: &[Vec<u32>], threads| -> anyhow::Result<f64> {
            let begin = Instant::now();
            let (layer, control) = (layer as u32, Control::on(threads));
            simulation.try_orders(layer, orders, Simulation::statistics, &control)?;
            Ok(begin.elapsed().as_secs_f64())
        };
        all.push(time(orders, Threads::Pool(&pool))?);
        for _ in 0..5 {
            let twice = [orders[0].clone(), orders[0].clone()];
            ratios.push(time(&twice, Threads::One)? / time(&twice, Threads::Pool(&pool))?);
        }
        let conventional = &orders[Pattern::CONVENTIONAL.number()];
        simulation.deposit(layer as u32, conventional, &Control::default())?;
    }
    let mean_s = all.iter().sum::<f64>() / all.len() as f64;
    Ok(Patterns {
        mean_s,
        most_s: all.into_iter().fold(0.0, f64::max),
        forks_ratio: middle(ratios),
    })
}

impl fmt::Display for Patterns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| 38 patterns of a layer, 2 threads: mean s | most s | two forks, 1 thread / 2 threads |"
        )?;
        writeln!(
            f,
            "|---|---|---|\n| {:.2} | {:.2} | {:.2} |",
            self.mean_s, self.most_s, self.forks_ratio
        )
    }
}
