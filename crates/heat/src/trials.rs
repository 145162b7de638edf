//! Many orders of one layer, tried from one state.

use std::borrow::Borrow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use beadwork_base::{Control, Interrupted, Progress};
use beadwork_thermal::simulation::DepositError;

use crate::fill::Fill;
use crate::model::{PathOf, ThermalModel};

/// What came of some trials.
#[derive(Clone, Debug)]
pub struct Trials<M> {
    /// Cost of each order, in the order of the input; `None` for an order that was not tried to its
    /// end.
    pub costs: Vec<Option<f64>>,
    /// The trials of the lowest scores, in ascending order.
    pub best: Vec<Trial<M>>,
    /// Why the call ended early; `None` if all orders were tried.
    /// If it is set, the rest depends on the moment of the interruption.
    pub interrupted: Option<Interrupted>,
}

/// One trial, with the state at its end.
#[derive(Clone, Debug)]
pub struct Trial<M> {
    /// Index of the order.
    pub index: usize,
    /// Cost of the layer.
    pub cost: f64,
    /// What trials are compared by: lower is better.
    pub score: f64,
    /// The model after the layer: go on from here, and it need not be simulated again.
    pub model: M,
}

/// Deposits a layer in each of the given orders, each time from the state of `model`, and keeps the
/// `keep` best.
///
/// `score` gets the index of an order and the cost of the layer, and returns what trials are
/// compared by; equal ones compare by index.
/// A score that is not a number (NaN) is never among the best.
///
/// Orders are tried in parallel, and the result is the same on any number of threads.
/// Each thread holds the state of one trial at a time; the best ones so far are kept beside them.
/// Progress counts the voxels of all orders.
///
/// # Interruption
/// An interrupted call returns the trials that were complete by then, and [`Trials::interrupted`].
///
/// # Errors
/// If some orders cannot be deposited, the error is that of the first of them.
pub fn try_orders<M: ThermalModel>(
    model: &M,
    layer: u32,
    orders: &[impl Borrow<PathOf<M>> + Sync],
    keep: usize,
    score: impl Fn(usize, f64) -> f64 + Sync,
    control: &Control<'_>,
) -> Result<Trials<M>, DepositError> {
    let best: Mutex<Vec<Trial<M>>> = Mutex::new(Vec::new());
    let voxels = model.fill().voxel_count(layer);
    let total = orders.len() * voxels;
    let done = AtomicUsize::new(0);
    let outcomes = control.threads.map_numbers(orders.len(), |index| {
        // An order's own progress counts events, travel moves included.
        let counted = AtomicUsize::new(0);
        let count = |voxels: usize| {
            let new = voxels.saturating_sub(counted.fetch_max(voxels, Ordering::Relaxed));
            if new > 0 {
                control.report(done.fetch_add(new, Ordering::Relaxed) + new, total);
            }
        };
        let report = |progress: Progress| count((progress.fraction() * voxels as f64) as usize);
        let own = Control { progress: Some(&report), ..control.on_one_thread() };
        own.check()?;
        let mut model = model.clone();
        let cost = model.deposit(layer, orders[index].borrow(), &own)?;
        count(voxels);
        let score = score(index, cost);
        if !score.is_nan() {
            let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
            let position = best.partition_point(|other: &Trial<M>| {
                other.score.total_cmp(&score).then(other.index.cmp(&index)).is_lt()
            });
            if position < keep {
                best.truncate(keep - 1);
                best.insert(position, Trial { index, cost, score, model });
            }
        }
        Ok(cost)
    });
    let mut interrupted = None;
    let mut costs = Vec::with_capacity(orders.len());
    for outcome in outcomes {
        costs.push(match outcome {
            Ok(cost) => Some(cost),
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

#[cfg(test)]
mod tests {
    use beadwork_base::{CancelToken, Threads};
    use beadwork_grid::Cell;
    use beadwork_part::Pattern;
    use beadwork_thermal::objective::Objective;

    use super::*;
    use crate::model::Solver;
    use crate::testing::{part, solver, stairs};

    #[test]
    fn the_best_trials_are_kept_in_order_on_any_threads() {
        let part = part([9, 7, 2], |_| true);
        let model = solver(&part, Objective::Reward);
        let region = part.region(0).unwrap();
        let orders = Pattern::ALL.map(|pattern| pattern.order(&region));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let alone: Vec<f64> = orders
            .iter()
            .map(|order| model.clone().deposit(0, order, &Control::default()).unwrap())
            .collect();
        // Not a number for odd orders, and equal scores for many.
        let score = |index: usize, cost: f64| if index % 2 == 1 { f64::NAN } else { cost.round() };
        for control in [Control::default(), Control::on(Threads::Pool(&pool))] {
            for keep in [0, 1, 4, 100] {
                let trials = try_orders(&model, 0, &orders, keep, score, &control).unwrap();
                assert_eq!(trials.costs, alone.iter().copied().map(Some).collect::<Vec<_>>());
                let mut expected: Vec<usize> = (0..38).step_by(2).collect();
                expected.sort_by(|&a, &b| alone[a].round().total_cmp(&alone[b].round()));
                expected.truncate(keep);
                let kept: Vec<usize> = trials.best.iter().map(|trial| trial.index).collect();
                assert_eq!(kept, expected);
                for trial in &trials.best {
                    assert_eq!(trial.cost.to_bits(), alone[trial.index].to_bits());
                    assert_eq!(trial.model.last_cell(), orders[trial.index].last().copied());
                }
            }
        }
        let control = Control::default();
        let none = try_orders(&model, 0, &[] as &[Vec<Cell>], 1, score, &control).unwrap();
        assert!(none.best.is_empty() && none.costs.is_empty());
        let (twice, none) = (vec![0, 0], Vec::new());
        let wrong = [&orders[0], &twice, &none];
        let error = try_orders(&model, 0, &wrong, 1, score, &control).unwrap_err();
        assert!(!matches!(error, DepositError::Interrupted(_)), "{error}");
    }

    /// The model after one layer, and all patterns of the next.
    fn layer_and_orders() -> (Solver, Vec<Vec<Cell>>) {
        let part = stairs();
        let mut model = solver(&part, Objective::Reward);
        let order = Pattern::CONVENTIONAL.order(&part.region(0).unwrap());
        model.deposit(0, &order, &Control::default()).unwrap();
        let region = part.region(1).unwrap();
        (model, Pattern::ALL.iter().map(|pattern| pattern.order(&region)).collect())
    }

    #[test]
    fn the_best_trial_keeps_its_state() {
        let (model, orders) = layer_and_orders();
        let control = Control::default();
        let trials = try_orders(&model, 1, &orders, 38, |_, cost| cost, &control).unwrap();
        for trial in trials.best {
            let mut fork = model.simulation().clone();
            fork.deposit(1, &orders[trial.index], &control).unwrap();
            let end = trial.model.simulation();
            for layer in 0..2 {
                assert!(fork.cell_temperatures_c(layer).eq(end.cell_temperatures_c(layer)));
            }
            assert_eq!(fork.seconds().to_bits(), end.seconds().to_bits());
        }
        assert!(model.simulation().layer_statistics(1).is_none());
    }

    #[test]
    fn progress_counts_the_voxels_of_all_orders() {
        let (model, orders) = layer_and_orders();
        let cells = orders.iter().map(Vec::len).sum::<usize>();
        let last = AtomicUsize::new(0);
        let report = |Progress { done, total }| {
            assert_eq!(total, cells);
            assert!(last.swap(done, Ordering::Relaxed) <= done);
        };
        let control = Control { progress: Some(&report), ..Control::default() };
        try_orders(&model, 1, &orders, 1, |_, cost| cost, &control).unwrap();
        assert_eq!(last.into_inner(), cells);
    }

    #[test]
    fn interrupted_trials_return_the_best_so_far() {
        let (model, orders) = layer_and_orders();
        let cancel = CancelToken::new();
        let control = Control { cancel: Some(&cancel), ..Control::default() };
        let tried = AtomicUsize::new(0);
        let score = |_: usize, cost: f64| {
            if tried.fetch_add(1, Ordering::Relaxed) == 4 {
                cancel.cancel();
            }
            cost
        };
        let trials = try_orders(&model, 1, &orders, 1, score, &control).unwrap();
        assert_eq!(trials.interrupted, Some(Interrupted::Cancelled));
        assert_eq!(trials.costs.iter().flatten().count(), 5);
        let min = trials.costs.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(trials.best[0].cost.to_bits(), min.to_bits());
        let none = try_orders(&model, 1, &orders, 1, |_, cost| cost, &control).unwrap();
        assert!(none.best.is_empty() && none.interrupted.is_some());
    }
}
