//! Many orders of one layer, tried from one state.

use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{Control, Progress};
use beadwork_grid::Cell;

use super::deposit::DepositError;
use super::setup::Simulation;

impl Simulation {
    /// Deposits a layer in each of the given orders, each time from the present state, and returns
    /// what `sample` makes of the state at the layer's end.
    ///
    /// The simulation itself does not change.
    /// Orders are tried in parallel; each thread holds one copy of the state at a time.
    /// Progress counts the voxels of all orders.
    /// If some orders cannot be deposited, or the call is interrupted, the error is that of the
    /// first order without a result.
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
        let total = orders.iter().map(Vec::len).sum();
        let done = AtomicUsize::new(0);
        let attempt = |order: &Vec<Cell>| {
            // An order's own progress counts travel moves, too.
            let counted = AtomicUsize::new(0);
            let report = |progress: Progress| {
                let voxels = (progress.fraction() * order.len() as f64) as usize;
                let new = voxels - counted.swap(voxels, Ordering::Relaxed);
                control.report(done.fetch_add(new, Ordering::Relaxed) + new, total);
            };
            let own = Control { progress: Some(&report), ..control.on_one_thread() };
            let mut fork = self.clone();
            fork.deposit(layer, order, &own)?;
            Ok(sample(&fork))
        };
        control.threads.map(orders, attempt).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
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
}
