//! Ranks of a layer's orders by the proxy and by the solver.

use std::collections::HashSet;
use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{bail, ensure};
use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_grid::Cell;
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Screen, Solver, ThermalModel};
use beadwork_heat::trials::try_orders;
use beadwork_part::Order;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use rayon::ThreadPool;
use serde::Serialize;

use crate::heat_parts::HeatPart;
use crate::statistics::{mean, median, rank_correlation};

/// Number of layers that are ranked by default.
const LAYERS: u32 = 5;

/// Orders that the proxy picks, of which the solver decides on one.
const PICKED: usize = 10;

/// Ranks of one layer's orders.
#[derive(Clone, Serialize)]
pub(super) struct LayerRow {
    part: &'static str,
    layer: u32,
    cells: usize,
    /// Named orders that differ.
    orders: usize,
    /// Spearman's rank correlation of the two deviations over all orders.
    all: f64,
    /// The same within the half of the orders whose deviation by the solver is lowest.
    better_half: f64,
    /// By how much the deviation of the best of the picked orders exceeds the lowest of all, in %,
    /// both by the solver.
    picked_excess_percent: f64,
    /// By how much the highest deviation by the solver exceeds the lowest, in %.
    range_percent: f64,
    /// Mean time that the solver takes for an order, times the number of threads.
    solver_ms: f64,
    /// Median time that the proxy takes for an order.
    proxy_ms: f64,
    /// Time to set up the proxy of the layer.
    setup_ms: f64,
}

/// How orders are ranked.
pub(super) struct Setup<'a> {
    /// Order of the layers below.
    pub(super) below: Order,
    pub(super) accuracy: Accuracy,
    pub(super) pool: &'a ThreadPool,
}

impl Setup<'_> {
    /// Ranks the orders of some layers of a part, or of evenly spread ones if none are given.
    pub(super) fn rows(&self, part: HeatPart, layers: &[u32]) -> anyhow::Result<Vec<LayerRow>> {
        let (name, voxels) = (part.name(), Arc::new(part.voxels()));
        let depth = voxels.depth as u32;
        let mut layers = match layers {
            [] => (0..LAYERS).map(|number| number * (depth - 1) / (LAYERS - 1)).collect(),
            given => given.to_vec(),
        };
        layers.sort_unstable();
        if let Some(layer) = layers.iter().find(|&&layer| layer >= depth) {
            bail!("layer {layer}: part {name} has {depth} layers, from 0 to {}", depth - 1);
        }
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let (method, cost) = (Method::Fast(self.accuracy), LayerCost::of(Objective::Reward)?);
        let mut model = Solver::new(voxels.clone(), &material, &process, method, cost)?;
        let mut rows = Vec::new();
        let mut next = 0;
        for layer in layers {
            for below in next..layer {
                let order = self.below.order(&voxels.region(below as usize)?);
                control::quiet(Threads::One, |control| model.deposit(below, &order, control))??;
            }
            next = next.max(layer);
            rows.push(self.row(name, &model, layer)?);
        }
        Ok(rows)
    }

    /// Ranks the orders of the next layer.
    fn row(&self, part: &'static str, model: &Solver, layer: u32) -> anyhow::Result<LayerRow> {
        let region = model.part().region(layer as usize)?;
        let mut seen = HashSet::new();
        let orders = OrderSet::All.orders().into_iter().map(|order| order.order(&region));
        let orders: Vec<Vec<Cell>> = orders.filter(|cells| seen.insert(cells.clone())).collect();
        let (solver, solver_ms) = self.by_solver(model, layer, &orders)?;
        let begin = Instant::now();
        let Some(screen) = model.screen(layer) else { bail!("the solver has no proxy") };
        let setup_ms = milliseconds(begin);
        let (mut proxy, mut times) = (Vec::new(), Vec::new());
        for order in &orders {
            let begin = Instant::now();
            proxy.push(screen.cost(order));
            times.push(milliseconds(begin));
        }
        let ranks = Ranks::of(&solver, &proxy);
        Ok(LayerRow {
            part,
            layer,
            cells: orders[0].len(),
            orders: orders.len(),
            all: ranks.all,
            better_half: ranks.better_half,
            picked_excess_percent: ranks.picked_excess_percent,
            range_percent: ranks.range_percent,
            solver_ms,
            proxy_ms: median(times),
            setup_ms,
        })
    }

    /// Deviation after each order, K, and the time of one.
    fn by_solver(
        &self,
        model: &Solver,
        layer: u32,
        orders: &[Vec<Cell>],
    ) -> anyhow::Result<(Vec<f64>, f64)> {
        let begin = Instant::now();
        let trial =
            |control: &Control<'_>| try_orders(model, layer, orders, 0, |_, cost| cost, control);
        let trials = control::with_bar("orders", Threads::Pool(self.pool), trial)??;
        let threads = self.pool.current_num_threads() as f64;
        let each_ms = milliseconds(begin) * threads / orders.len() as f64;
        let costs: Option<Vec<f64>> = trials.costs.into_iter().collect();
        ensure!(costs.is_some(), "stopped");
        Ok((costs.unwrap_or_default(), each_ms))
    }
}

/// How one list of values ranks orders, compared with another.
struct Ranks {
    all: f64,
    better_half: f64,
    picked_excess_percent: f64,
    range_percent: f64,
}

impl Ranks {
    fn of(solver: &[f64], proxy: &[f64]) -> Self {
        let sorted = |values: &[f64]| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            order
        };
        let best = sorted(solver);
        let half = &best[..best.len() / 2];
        let of = |values: &[f64]| half.iter().map(|&order| values[order]).collect::<Vec<_>>();
        let lowest = solver[best[0]];
        let excess_percent = |value: f64| 100.0 * (value / lowest - 1.0);
        let picked = sorted(proxy).into_iter().take(PICKED).map(|order| solver[order]);
        Self {
            all: rank_correlation(solver, proxy),
            better_half: rank_correlation(&of(solver), &of(proxy)),
            picked_excess_percent: excess_percent(picked.fold(f64::INFINITY, f64::min)),
            range_percent: excess_percent(solver[best[best.len() - 1]]),
        }
    }
}

fn milliseconds(begin: Instant) -> f64 {
    1e3 * begin.elapsed().as_secs_f64()
}

/// One line per layer, and one per part with the minima and means over the layers above the first.
pub(super) fn table(rows: &[LayerRow]) -> Result<String, std::fmt::Error> {
    let mut text = String::from(
        "\nProxy against solver: rank correlation over all named orders of a layer and within the \
         better half;\n\
         excess of the best of ten that the proxy picks, and of the worst order, over the best, %\n\
         \n\
         | part | layer | cells | orders | all | better half | picked % | worst % | solver ms \
         | proxy ms | set-up ms |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let LayerRow { part, layer, cells, orders, all, better_half, .. } = row;
        writeln!(
            text,
            "| {part} | {layer} | {cells} | {orders} | {all:.3} | {better_half:.3} | {:.2} \
             | {:.1} | {:.1} | {:.3} | {:.1} |",
            row.picked_excess_percent, row.range_percent, row.solver_ms, row.proxy_ms, row.setup_ms
        )?;
    }
    text += "\nAbove the first layer\n\n| part | all: minimum | mean | better half: minimum \
             | mean |\n|---|---|---|---|---|\n";
    for rows in rows.chunk_by(|a, b| a.part == b.part) {
        let above: Vec<&LayerRow> = rows.iter().filter(|row| row.layer > 0).collect();
        let min = |value: fn(&LayerRow) -> f64| {
            above.iter().map(|row| value(row)).fold(f64::INFINITY, f64::min)
        };
        let mean = |value: fn(&LayerRow) -> f64| mean(above.iter().map(|row| value(row)));
        if !above.is_empty() {
            writeln!(
                text,
                "| {} | {:.3} | {:.3} | {:.3} | {:.3} |",
                rows[0].part,
                min(|row| row.all),
                mean(|row| row.all),
                min(|row| row.better_half),
                mean(|row| row.better_half)
            )?;
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_better_half_is_that_of_the_solver() {
        // The solver's better half is 1, 2, 3, which the proxy ranks in reverse.
        let solver = [6.0, 1.0, 4.0, 2.0, 5.0, 3.0];
        let proxy = [60.0, 30.0, 40.0, 20.0, 50.0, 10.0];
        let ranks = Ranks::of(&solver, &proxy);
        assert!((ranks.better_half + 1.0).abs() < 1e-12, "{}", ranks.better_half);
        assert!((ranks.all - (1.0 - 6.0 * 8.0 / 210.0)).abs() < 1e-12, "{}", ranks.all);
        assert!((ranks.range_percent - 500.0).abs() < 1e-9);
        assert!(ranks.picked_excess_percent.abs() < 1e-9);
    }

    #[test]
    fn layers_outside_of_the_part_are_refused() {
        let pool = control::pool(1).unwrap();
        let below = Order::CONVENTIONAL;
        let setup = Setup { below, accuracy: Accuracy::Draft, pool: &pool };
        let error = setup.rows(HeatPart::U, &[12]).err().unwrap().to_string();
        assert_eq!(error, "layer 12: part U has 12 layers, from 0 to 11");
    }
}
