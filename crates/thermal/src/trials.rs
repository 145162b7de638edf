//! Many orders of one layer, tried from one state.

use beadwork_grid::Cell;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::simulation::{DepositError, Simulation};

impl Simulation {
    /// Deposits a layer in each of some orders, each time from the present state, and tells what
    /// `look` sees at its end.
    ///
    /// The simulation itself does not go on.
    /// Orders are tried in the given threads, or one after the other; the results do not depend on
    /// it.
    /// Each thread holds one copy of the state at a time.
    /// The first order that can't be deposited is an error, even if others can.
    ///
    /// ```
    /// # use std::sync::Arc;
    /// # use beadwork_part::slice::Voxels;
    /// # use beadwork_part::{Frame, Pattern};
    /// # use beadwork_thermal::{Material, Method, Process, Simulation};
    /// # let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 20, height: 10 };
    /// # let part = Arc::new(Voxels::new(frame, ndarray::Array3::zeros((1, 10, 20))));
    /// # let simulation = Simulation::new(part.clone(), &Material::abs(), &Process::default(), Method::default())?;
    /// let orders = Pattern::ALL.map(|pattern| pattern.order(&part.region(0).unwrap()));
    /// let spreads = simulation.try_orders(0, &orders, None, |end| end.spread().map_or(0.0, |spread| spread.std_c))?;
    /// let best = (0..38).min_by(|&a, &b| spreads[a].total_cmp(&spreads[b])).unwrap();
    /// println!("{} leaves the layer at its most even", Pattern::ALL[best]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn try_orders<R: Send>(
        &self,
        layer: u32,
        orders: &[Vec<Cell>],
        pool: Option<&ThreadPool>,
        look: impl Fn(&Self) -> R + Sync,
    ) -> Result<Vec<R>, DepositError> {
        let attempt = |order: &Vec<Cell>| {
            let mut fork = self.clone();
            fork.deposit(layer, order)?;
            Ok(look(&fork))
        };
        match pool {
            Some(pool) => pool.install(|| orders.par_iter().map(attempt).collect()),
            None => orders.iter().map(attempt).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use beadwork_part::Pattern;

    use crate::testing::stairs;
    use crate::{Material, Method, Process, Simulation};

    #[test]
    fn orders_do_not_see_each_other_nor_the_threads() {
        let part = stairs(20, 12, 3);
        let mut simulation =
            Simulation::new(part.clone(), &Material::abs(), &Process::default(), Method::default())
                .unwrap();
        simulation.deposit(0, &Pattern::CONVENTIONAL.order(&part.region(0).unwrap())).unwrap();
        let orders: Vec<_> =
            Pattern::ALL.iter().map(|pattern| pattern.order(&part.region(1).unwrap())).collect();
        let look = |end: &Simulation| {
            end.layer_c(1).map(|(_, celsius)| celsius.to_bits()).collect::<Vec<_>>()
        };
        let alone: Vec<_> = orders
            .iter()
            .map(|order| {
                let mut fork = simulation.clone();
                fork.deposit(1, order).unwrap();
                look(&fork)
            })
            .collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        assert_eq!(simulation.try_orders(1, &orders, Some(&pool), look).unwrap(), alone);
        assert_eq!(simulation.try_orders(1, &orders, None, look).unwrap(), alone);
        assert!(simulation.layer_spread(1).is_none());
        assert!(
            simulation.try_orders(1, &[orders[0].clone(), vec![0]], Some(&pool), look).is_err()
        );
    }
}
