//! Many orders of one layer, tried from one state.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use beadwork_base::{Control, Interrupted, Progress};
use beadwork_grid::Cell;

use super::deposit::DepositError;
use super::setup::Simulation;

/// What came of the trials of [`Simulation::best_order`] and [`Simulation::best_trial`].
#[derive(Clone, Debug)]
pub struct Trials<R> {
    /// Cost of each order, in the order of the input; `None` for an order that was not tried to its
    /// end, as it takes too long or the call was interrupted.
    pub costs: Vec<Option<f64>>,
    /// The order of the lowest cost, and of these the one with the lowest index; `None` if no order
    /// has a cost that is a number.
    pub best: Option<BestTrial<R>>,
    /// Why the call ended early; `None` if all orders were tried.
    /// If it is set, `costs` and `best` depend on the moment of the interruption.
    pub interrupted: Option<Interrupted>,
}

/// The winner of some trials, with the state at its end.
#[derive(Clone, Debug)]
pub struct BestTrial<R> {
    /// Index of the order.
    pub index: usize,
    /// Its cost.
    pub cost: f64,
    /// The simulation after the trial: go on from here, and the layer need not be simulated again.
    pub simulation: Simulation,
    /// What the trial returned beside its cost.
    pub result: R,
}

impl<R> BestTrial<R> {
    /// Whether a trial of the given cost and index comes before this one.
    fn is_beaten_by(&self, cost: f64, index: usize) -> bool {
        // Costs are numbers, so the lower one wins; equal ones compare by index.
        cost < self.cost || (cost <= self.cost && index < self.index)
    }
}

impl Simulation {
    /// Deposits a layer in each of the given orders, each time from the present state, and returns
    /// what `sample` makes of the state at the layer's end.
    ///
    /// The simulation itself does not change.
    /// Orders are tried in parallel; each thread holds one copy of the state at a time.
    /// Progress counts the voxels of all orders.
    /// If some orders cannot be deposited, or the call is interrupted, the error is that of the
    /// first order without a result.
    /// [`Simulation::best_order`] keeps the state at the end of the best order.
    ///
    /// ```
    /// # use std::sync::Arc;
    /// # use beadwork_part::slice::Voxels;
    /// # use beadwork_part::Frame;
    /// # use beadwork_thermal::simulation::Method;
    /// # use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
    /// use beadwork_base::{Control, Threads};
    /// use beadwork_part::Pattern;
    ///
    /// # let (left_mm, back_mm) = (0.0, 0.0);
    /// # let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 20, 10);
    /// # let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width, height };
    /// # let part = Arc::new(Voxels::new(frame, ndarray::Array3::zeros((1, 10, 20))));
    /// # let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    /// # let simulation = Simulation::new(part.clone(), &abs, &process, Method::default())?;
    /// let orders = Pattern::ALL.map(|pattern| pattern.order(&part.region(0).unwrap()));
    /// let std_c = |end: &Simulation| end.statistics().map_or(0.0, |all| all.std_c);
    /// let deviations =
    ///     simulation.try_orders(0, &orders, std_c, &Control::on(Threads::Current))?;
    /// let best = (0..38).min_by(|&a, &b| deviations[a].total_cmp(&deviations[b])).unwrap();
    /// println!("{} leaves the most even temperatures", Pattern::ALL[best]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn try_orders<R: Send>(
        &self,
        layer: u32,
        orders: &[Vec<Cell>],
        sample: impl Fn(&Self) -> R + Sync,
        control: &Control<'_>,
    ) -> Result<Vec<R>, DepositError> {
        let attempt = |index: usize, own: &Control<'_>| {
            let mut fork = self.clone();
            fork.deposit(layer, &orders[index], own)?;
            Ok(sample(&fork))
        };
        for_each_order(orders, attempt, control).into_iter().collect()
    }

    /// Deposits a layer in each of the given orders, each time from the present state, and returns
    /// the order whose state at the layer's end has the lowest `cost`, with that state.
    ///
    /// An order that would print the layer in more than `max_seconds`, travel included, is not
    /// simulated; `f64::INFINITY` sets no limit.
    /// [`Simulation::best_trial`] is the general form, and describes progress, memory, interruption
    /// and errors.
    ///
    /// ```
    /// # use std::sync::Arc;
    /// # use beadwork_part::slice::Voxels;
    /// # use beadwork_part::Frame;
    /// # use beadwork_thermal::simulation::Method;
    /// # use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
    /// use beadwork_base::{Control, Threads};
    /// use beadwork_part::Pattern;
    ///
    /// # let (left_mm, back_mm) = (0.0, 0.0);
    /// # let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 20, 10);
    /// # let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width, height };
    /// # let part = Arc::new(Voxels::new(frame, ndarray::Array3::zeros((2, 10, 20))));
    /// # let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    /// # let mut simulation = Simulation::new(part.clone(), &abs, &process, Method::default())?;
    /// let control = Control::on(Threads::Current);
    /// let std_c = |end: &Simulation| end.statistics().map_or(0.0, |all| all.std_c);
    /// for layer in 0..2 {
    ///     let orders = Pattern::ALL.map(|pattern| pattern.order(&part.region(0).unwrap()));
    ///     let conventional = &orders[Pattern::CONVENTIONAL.number()];
    ///     let max_seconds = 1.02 * simulation.order_seconds(layer, conventional);
    ///     let trials = simulation.best_order(layer, &orders, max_seconds, std_c, &control)?;
    ///     let best = trials.best.expect("the conventional order is fast enough");
    ///     println!("layer {layer}: {}, {:.2} K", Pattern::ALL[best.index], best.cost);
    ///     simulation = best.simulation;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn best_order(
        &self,
        layer: u32,
        orders: &[Vec<Cell>],
        max_seconds: f64,
        cost: impl Fn(&Self) -> f64 + Sync,
        control: &Control<'_>,
    ) -> Result<Trials<()>, DepositError> {
        let trial = |fork: &mut Self, index: usize, own: &Control<'_>| {
            fork.deposit(layer, &orders[index], own)?;
            Ok((cost(fork), ()))
        };
        self.best_trial(layer, orders, max_seconds, trial, control)
    }

    /// Makes a trial of each of the given orders of a layer, and returns the one of the lowest cost
    /// with its state at the end.
    ///
    /// `trial` gets a copy of the simulation, the index of an order, and a control that it must
    /// pass on to one long call, which deposits the order.
    /// It returns the cost and whatever else is worth keeping of the best trial, such as a
    /// `HeatMeter` that has measured the layer.
    /// A cost that is not a number (NaN) is never the best.
    /// An order for which [`Simulation::order_seconds`] exceeds `max_seconds` is not tried; a pause
    /// that `trial` adds does not count.
    ///
    /// The simulation itself does not change, whatever happens.
    /// The result is the same on any number of threads.
    /// Orders are tried in parallel; each thread holds the state of one trial at a time, and the
    /// best one so far is kept beside them.
    /// Progress counts the voxels of all orders; those of orders that are not tried count at once.
    ///
    /// # Interruption
    /// An interrupted call returns the best of the trials that were complete by then, and
    /// [`Trials::interrupted`].
    ///
    /// # Errors
    /// If some orders cannot be deposited, the error is that of the first of them that was tried.
    pub fn best_trial<R: Send>(
        &self,
        layer: u32,
        orders: &[Vec<Cell>],
        max_seconds: f64,
        trial: impl Fn(&mut Self, usize, &Control<'_>) -> Result<(f64, R), DepositError> + Sync,
        control: &Control<'_>,
    ) -> Result<Trials<R>, DepositError> {
        let best: Mutex<Option<BestTrial<R>>> = Mutex::new(None);
        let attempt = |index: usize, own: &Control<'_>| {
            own.check()?;
            if self.order_seconds(layer, &orders[index]) > max_seconds {
                return Ok(None);
            }
            let mut simulation = self.clone();
            let (cost, result) = trial(&mut simulation, index, own)?;
            if !cost.is_nan() {
                let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
                if best.as_ref().is_none_or(|best| best.is_beaten_by(cost, index)) {
                    *best = Some(BestTrial { index, cost, simulation, result });
                }
            }
            Ok(Some(cost))
        };
        let mut interrupted = None;
        let mut costs = Vec::with_capacity(orders.len());
        for outcome in for_each_order(orders, attempt, control) {
            costs.push(match outcome {
                Ok(cost) => cost,
                Err(DepositError::Interrupted(reason)) => {
                    interrupted = Some(reason);
                    None
                }
                Err(error) => return Err(error),
            });
        }
        let best = best.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Trials { costs, best, interrupted })
    }

    /// Time that depositing a layer in the given order would take now, travel included, s.
    ///
    /// Cells that are not of the layer are not refused.
    /// Linear in the order's length: no simulation.
    pub fn order_seconds(&self, layer: u32, order: &[Cell]) -> f64 {
        self.layer_events(layer, order).iter().map(|event| event.seconds).sum()
    }
}

/// Calls `attempt` with the index of each order, and with a control for one call that deposits it,
/// on the threads of `control`.
/// Reports the voxels of all orders as progress.
fn for_each_order<R: Send>(
    orders: &[Vec<Cell>],
    attempt: impl Fn(usize, &Control<'_>) -> Result<R, DepositError> + Sync,
    control: &Control<'_>,
) -> Vec<Result<R, DepositError>> {
    let total = orders.iter().map(Vec::len).sum();
    let done = AtomicUsize::new(0);
    control.threads.map_numbers(orders.len(), |index| {
        let cells = orders[index].len();
        // An order's own progress counts travel moves, too.
        let counted = AtomicUsize::new(0);
        let count = |voxels: usize| {
            let new = voxels.saturating_sub(counted.fetch_max(voxels, Ordering::Relaxed));
            if new > 0 {
                control.report(done.fetch_add(new, Ordering::Relaxed) + new, total);
            }
        };
        let report = |progress: Progress| count((progress.fraction() * cells as f64) as usize);
        let own = Control { progress: Some(&report), ..control.on_one_thread() };
        let result = attempt(index, &own);
        if result.is_ok() {
            count(cells);
        }
        result
    })
}

#[cfg(test)]
mod tests;
