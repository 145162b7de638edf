//! Trials on threads, with limits and interruptions, against one deposit after the other.

use beadwork_base::{CancelToken, Interrupted, Threads};
use beadwork_part::Pattern;

use super::*;
use crate::testing::{stairs, unprinted};

/// A simulation with one layer, and all patterns of the next.
fn layer_and_orders() -> (Simulation, Vec<Vec<Cell>>) {
    let part = stairs(20, 12, 3);
    let mut simulation = unprinted(part.clone());
    let order = Pattern::CONVENTIONAL.order(&part.region(0).unwrap());
    simulation.deposit(0, &order, &Control::default()).unwrap();
    let region = part.region(1).unwrap();
    (simulation, Pattern::ALL.iter().map(|pattern| pattern.order(&region)).collect())
}

#[test]
fn orders_and_threads_are_independent() {
    let (simulation, orders) = layer_and_orders();
    let sample = |end: &Simulation| {
        end.cell_temperatures_c(1).map(|(_, celsius)| celsius.to_bits()).collect::<Vec<_>>()
    };
    let alone: Vec<_> = orders
        .iter()
        .map(|order| {
            let mut fork = simulation.clone();
            fork.deposit(1, order, &Control::default()).unwrap();
            sample(&fork)
        })
        .collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let on_pool = Control::on(Threads::Pool(&pool));
    assert_eq!(simulation.try_orders(1, &orders, sample, &on_pool).unwrap(), alone);
    assert_eq!(simulation.try_orders(1, &orders, sample, &Control::default()).unwrap(), alone);
    assert!(simulation.layer_statistics(1).is_none());
    let wrong = [orders[0].clone(), vec![0]];
    assert!(simulation.try_orders(1, &wrong, sample, &on_pool).is_err());
}

#[test]
fn progress_counts_the_voxels_of_all_orders() {
    let (simulation, orders) = layer_and_orders();
    let last = AtomicUsize::new(0);
    let report = |Progress { done, total }| {
        assert_eq!(total, orders.iter().map(Vec::len).sum::<usize>());
        assert!(last.swap(done, Ordering::Relaxed) <= done);
    };
    let control = Control { progress: Some(&report), ..Control::default() };
    simulation.try_orders(1, &orders, |_| (), &control).unwrap();
    assert_eq!(last.into_inner(), orders.iter().map(Vec::len).sum::<usize>());
}

#[test]
fn cancelled_trials_have_no_result() {
    let (simulation, orders) = layer_and_orders();
    let cancel = CancelToken::new();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let sample = |_: &Simulation| cancel.cancel();
    let result = simulation.try_orders(1, &orders, sample, &control);
    assert_eq!(result, Err(DepositError::Interrupted(Interrupted::Cancelled)));
}

fn std_c(end: &Simulation) -> f64 {
    end.statistics().unwrap().std_c
}

#[test]
fn the_best_order_keeps_its_state() {
    let (simulation, mut orders) = layer_and_orders();
    // Ties: every order twice.
    orders.extend(orders.clone());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let all = simulation.try_orders(1, &orders, std_c, &Control::default()).unwrap();
    let mut seconds: Vec<_> =
        orders.iter().map(|order| simulation.order_seconds(1, order)).collect();
    let each = seconds.clone();
    seconds.sort_by(f64::total_cmp);
    for max_seconds in [f64::INFINITY, seconds[40], seconds[3], 0.0, f64::NEG_INFINITY] {
        let costs: Vec<_> =
            (0..orders.len()).map(|i| Some(all[i]).filter(|_| each[i] <= max_seconds)).collect();
        let expected = (0..orders.len())
            .filter(|&i| costs[i].is_some())
            .min_by(|&a, &b| all[a].total_cmp(&all[b]));
        for threads in [Threads::One, Threads::Pool(&pool)] {
            let control = Control::on(threads);
            let trials = simulation.best_order(1, &orders, max_seconds, std_c, &control).unwrap();
            assert_eq!((&trials.costs, trials.interrupted), (&costs, None));
            assert_eq!(trials.best.as_ref().map(|best| best.index), expected);
            let Some(best) = trials.best else { continue };
            assert_eq!(best.cost.to_bits(), all[best.index].to_bits());
            let mut fork = simulation.clone();
            let print_seconds = fork.deposit(1, &orders[best.index], &Control::default()).unwrap();
            assert!((print_seconds - each[best.index]).abs() < 1e-9);
            assert!(fork.cell_temperatures_c(1).eq(best.simulation.cell_temperatures_c(1)));
            assert!(fork.cell_temperatures_c(0).eq(best.simulation.cell_temperatures_c(0)));
            assert_eq!(fork.seconds().to_bits(), best.simulation.seconds().to_bits());
        }
    }
    assert!(simulation.layer_statistics(1).is_none());
}

#[test]
fn no_order_and_no_number_have_no_best() {
    let (simulation, orders) = layer_and_orders();
    let control = Control::default();
    let none = simulation.best_order(1, &[], f64::INFINITY, std_c, &control).unwrap();
    assert!(none.best.is_none() && none.costs.is_empty());
    let nan = simulation.best_order(1, &orders[..2], f64::INFINITY, |_| f64::NAN, &control);
    assert!(nan.unwrap().best.is_none());
    let wrong = [orders[0].clone(), vec![0], Vec::new()];
    let error = simulation.best_order(1, &wrong, f64::INFINITY, std_c, &control).unwrap_err();
    assert!(!matches!(error, DepositError::Interrupted(_)), "{error}");
}

#[test]
fn interrupted_trials_return_the_best_so_far() {
    let (simulation, orders) = layer_and_orders();
    let before = simulation.clone();
    let cancel = CancelToken::new();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let tried = AtomicUsize::new(0);
    let cost = |end: &Simulation| {
        if tried.fetch_add(1, Ordering::Relaxed) == 4 {
            cancel.cancel();
        }
        std_c(end)
    };
    let trials = simulation.best_order(1, &orders, f64::INFINITY, cost, &control).unwrap();
    assert_eq!(trials.interrupted, Some(Interrupted::Cancelled));
    assert_eq!(trials.costs.iter().flatten().count(), 5);
    let min = trials.costs.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(trials.best.unwrap().cost.to_bits(), min.to_bits());
    assert_eq!(simulation.statistics(), before.statistics());
    assert_eq!(simulation.seconds().to_bits(), before.seconds().to_bits());
    let none = simulation.best_order(1, &orders, f64::INFINITY, std_c, &control).unwrap();
    assert!(none.best.is_none() && none.interrupted.is_some());
}

#[test]
fn skipped_orders_count_as_progress() {
    let (simulation, orders) = layer_and_orders();
    let (last, total) = (AtomicUsize::new(0), orders.iter().map(Vec::len).sum::<usize>());
    let report = |progress: Progress| {
        assert_eq!(progress.total, total);
        assert!(last.swap(progress.done, Ordering::Relaxed) <= progress.done);
    };
    let control = Control { progress: Some(&report), ..Control::default() };
    let max_seconds = simulation.order_seconds(1, &orders[0]);
    simulation.best_order(1, &orders, max_seconds, std_c, &control).unwrap();
    assert_eq!(last.into_inner(), total);
}
