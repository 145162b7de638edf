//! Steps per second of environments that deposit a layer a step.

use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_grid::Cell;
use beadwork_heat::model::{LayerCost, Solver, ThermalModel};
use beadwork_part::Pattern;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::{Accuracy, DepositError, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use serde::Serialize;

use crate::heat_parts::{HeatPart, all_orders};

/// Rates of one part and one accuracy of the solver.
#[derive(Clone, Serialize)]
pub(super) struct StepsRow {
    part: &'static str,
    accuracy: &'static str,
    /// Layers per second of one environment on one thread.
    one_thread: f64,
    /// Layers per second of two environments on two threads, together.
    two_threads: f64,
}

/// Deposits a part in `episodes` episodes per environment, each layer in another pattern.
pub(super) fn rows(part: HeatPart, episodes: u32) -> anyhow::Result<Vec<StepsRow>> {
    let (name, voxels) = (part.name(), Arc::new(part.voxels()));
    let orders = all_orders(&voxels)?;
    let pool = control::pool(2)?;
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let row = |(accuracy_name, accuracy): (&'static str, Accuracy)| {
        let cost = LayerCost::of(Objective::Reward)?;
        let method = Method::Fast(accuracy);
        let unprinted = Solver::new(voxels.clone(), &material, &process, method, cost)?;
        let rate = |environments: usize, threads: Threads<'_>| -> anyhow::Result<f64> {
            let own = control::cancellable(Threads::One)?;
            let begin = Instant::now();
            let results = threads.map_numbers(environments, |number| {
                (0..episodes).try_for_each(|at| episode(&unprinted, &orders, number, at, &own))
            });
            results.into_iter().collect::<Result<Vec<()>, _>>()?;
            let steps = environments * episodes as usize * orders.len();
            Ok(steps as f64 / begin.elapsed().as_secs_f64())
        };
        Ok(StepsRow {
            part: name,
            accuracy: accuracy_name,
            one_thread: rate(1, Threads::One)?,
            two_threads: rate(2, Threads::Pool(&pool))?,
        })
    };
    [("draft", Accuracy::Draft), ("standard", Accuracy::Standard)].into_iter().map(row).collect()
}

/// Deposits all layers, in patterns that depend on the numbers of the layer, of the environment and
/// of the episode.
fn episode(
    unprinted: &Solver,
    orders: &[Vec<Vec<Cell>>],
    environment: usize,
    episode: u32,
    control: &Control<'_>,
) -> Result<(), DepositError> {
    let mut model = unprinted.clone();
    for (layer, orders) in orders.iter().enumerate() {
        let pattern = (layer * 11 + episode as usize * 7 + environment * 5) % Pattern::COUNT;
        model.deposit(layer as u32, &orders[pattern], control)?;
    }
    Ok(())
}

/// One line per part and accuracy.
pub(super) fn table(rows: &[StepsRow]) -> Result<String, std::fmt::Error> {
    let mut text = String::from(
        "\nSteps of environments per second: layers deposited, each in one of the 38 patterns\n\
         \n\
         | part | accuracy | one environment, 1 thread | two environments, 2 threads | ratio |\n\
         |---|---|---|---|---|\n",
    );
    for StepsRow { part, accuracy, one_thread, two_threads } in rows {
        let ratio = two_threads / one_thread;
        writeln!(
            text,
            "| {part} | {accuracy} | {one_thread:.1} | {two_threads:.1} | {ratio:.2} |"
        )?;
    }
    Ok(text)
}
