//! Finds plans in which each layer has its own order, and proven lower bounds on their cost.
//!
//! Small sets of tools have exact tables, so that the dynamic programme over the layers is exact.
//! For large sets it runs once on lower bounds, which gives a bound, and once on the orders that
//! were found, which gives a plan.
//! Bounds and orders are computed lazily, only for the pairs of a first and a last tool that
//! matter:
//!
//! - **Bound**: the plan on lower bounds is itself a lower bound.
//!   The bounds of the pairs that it uses are raised, and the plan is computed again, until it uses
//!   only raised bounds.
//! - **Plan**: pairs without an order count with their lower bound.
//!   Orders of the pairs that the plan uses are searched for, and the plan is computed again, until
//!   it uses only pairs with an order.
//!   Then no other choice of pairs gives a better plan: searched pairs count with their orders, the
//!   others with lower bounds.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::Control;

use super::check::Layers;
use super::constraints::{Constraints, OrderError};
use super::large::Large;
use super::layered::{Layered, layered};
use super::problem::Problem;
use super::within::{NEVER, Within};
use crate::CostMatrix;

/// Maximum number of steps to raise a bound, of some nanoseconds each.
const MAX_BOUND_STEPS: usize = 1_000_000_000;

/// Maximum number of steps to search for orders, of some nanoseconds each.
const MAX_SEARCH_STEPS: usize = 2_000_000_000;

/// The costs and orders of one set of tools.
enum Table {
    Exact(Within),
    Large(Box<Large>),
}

/// The best plan that was found, with the tables that it was made from.
pub(super) struct Solved {
    pub(super) plan: Layered,
    /// Proven lower bound on the scaled cost of a plan.
    pub(super) bound: u64,
    /// For each kind of layer, the orders that were found.
    pub(super) tables: Vec<Within>,
}

/// The inputs of all steps of a solution.
pub(super) struct Solver<'a> {
    pub(super) layers: &'a Layers,
    pub(super) costs: &'a CostMatrix,
    pub(super) constraints: &'a Constraints,
    /// Maximum number of tools of a set that is solved exactly.
    pub(super) max_exact: usize,
    pub(super) control: &'a Control<'a>,
}

impl Solver<'_> {
    /// The best plan, and a lower bound.
    pub(super) fn solve(&self) -> Result<Solved, OrderError> {
        let mut tables = self.tables();
        let bound = self.bound_of(&mut tables)?;
        let plan = self.plan_of(&mut tables, bound)?;
        self.control.report(tables.len(), tables.len());
        let orders = |table| match table {
            Table::Exact(within) => within,
            Table::Large(large) => large.orders,
        };
        Ok(Solved { plan, bound, tables: tables.into_iter().map(orders).collect() })
    }

    /// A lower bound of the scaled cost of a plan.
    pub(super) fn bound(&self) -> Result<u64, OrderError> {
        self.bound_of(&mut self.tables())
    }

    /// The minimum number of changes of a plan, if none were forbidden.
    ///
    /// Within a layer of k tools it is k - 1, if the layer can begin with the first and end with
    /// the last tool: the tools between can be ordered in any way that obeys the constraints.
    pub(super) fn min_changes(&self) -> u32 {
        let uniform = CostMatrix::uniform(self.costs.size());
        let table = |set: &Vec<u8>| {
            let problem = Problem::new(set, &uniform, &self.constraints.before);
            let count = set.len();
            let changes = |pair: usize| {
                let is_allowed = problem.allows(pair / count, pair % count);
                if is_allowed { count as u64 - 1 } else { NEVER }
            };
            Within::with_costs(count, (0..count * count).map(changes).collect())
        };
        let tables: Vec<Within> = self.layers.kinds.iter().map(table).collect();
        let tables: Vec<&Within> = tables.iter().collect();
        let plan = layered(self.layers, &tables, &uniform, self.constraints);
        plan.map_or(0, |plan| plan.cost as u32)
    }

    /// Makes a table for each set: exact for small sets, lazy for large ones.
    /// After an interruption, the remaining small sets are treated as large.
    fn tables(&self) -> Vec<Table> {
        let kinds = &self.layers.kinds;
        let done = AtomicUsize::new(0);
        self.control.threads.map(kinds, |set| {
            let before = &self.constraints.before;
            let is_exact = set.len() <= self.max_exact && self.control.interrupted().is_none();
            if !is_exact {
                return Table::Large(Box::new(Large::new(set, self.costs, before)));
            }
            let table = Table::Exact(Within::exact(set, self.costs, before));
            self.control.report(done.fetch_add(1, Ordering::Relaxed) + 1, kinds.len());
            table
        })
    }

    /// The best plan on some of the tables' costs.
    fn layered<'t>(
        &self,
        tables: &'t [Table],
        choose: impl Fn(&'t Large) -> &'t Within,
    ) -> Result<Layered, usize> {
        let chosen = |table: &'t Table| match table {
            Table::Exact(within) => within,
            Table::Large(large) => choose(large),
        };
        let tables: Vec<&Within> = tables.iter().map(chosen).collect();
        layered(self.layers, &tables, self.costs, self.constraints)
    }

    /// The pairs of large sets that a plan uses: the number of the kind, and the ends.
    fn used(&self, tables: &[Table], plan: &Layered) -> BTreeSet<(usize, [usize; 2])> {
        let used = self.layers.kind_of.iter().copied().zip(plan.ends.iter().copied());
        used.filter(|&(kind, _)| matches!(tables[kind], Table::Large(_))).collect()
    }

    /// A lower bound on the cost of a plan; raises the bounds of the pairs that matter.
    fn bound_of(&self, tables: &mut [Table]) -> Result<u64, OrderError> {
        let round_steps: usize = self.layers.iter().map(|set| set.len().pow(2)).sum();
        let mut steps = 0;
        loop {
            let plan = self.layered(tables, |large| &large.bounds);
            let plan = plan.map_err(|layer| OrderError::Forbidden { layer })?;
            steps += round_steps;
            let mut has_raised = false;
            for (kind, ends) in self.used(tables, &plan) {
                let Table::Large(large) = &mut tables[kind] else { continue };
                let is_enough = steps > MAX_BOUND_STEPS || self.control.interrupted().is_some();
                if is_enough || large.is_raised(ends) {
                    continue;
                }
                large.raise_bound(ends);
                has_raised = true;
                steps += self.layers.kinds[kind].len().pow(3) * 20;
            }
            if !has_raised {
                return Ok(plan.cost);
            }
        }
    }

    /// The best plan that was found; searches for orders of the pairs that matter.
    ///
    /// Once the plan uses only pairs with an order, more time is spent on these pairs, until that
    /// improves none of them or the cost reaches `bound`.
    fn plan_of(&self, tables: &mut [Table], bound: u64) -> Result<Layered, OrderError> {
        let mut best: Option<Layered> = None;
        // The pairs for which better orders were searched for.
        let mut searched_more = BTreeSet::new();
        let round_steps: usize = self.layers.iter().map(|set| set.len().pow(2)).sum();
        let mut steps = 0;
        loop {
            let plan = match self.layered(tables, |large| &large.orders) {
                Ok(plan) => plan,
                Err(_) if best.is_some() => break,
                Err(layer) => return Err(OrderError::NotFound { layer }),
            };
            steps += round_steps;
            let used = self.used(tables, &plan);
            let mut has_new = false;
            for &(kind, ends) in &used {
                let Table::Large(large) = &mut tables[kind] else { continue };
                if !large.is_searched(ends) {
                    steps += large.search(ends, self.control);
                    has_new = true;
                }
            }
            let plan = self.with_orders(tables, plan);
            if plan.cost != NEVER && best.as_ref().is_none_or(|best| plan.cost < best.cost) {
                best = Some(plan);
            }
            let is_over = steps > MAX_SEARCH_STEPS || self.control.interrupted().is_some();
            if best.as_ref().is_some_and(|best| best.cost <= bound || is_over) {
                break;
            }
            if has_new {
                continue;
            }
            let mut has_improved = false;
            for (kind, ends) in used {
                let Table::Large(large) = &mut tables[kind] else { continue };
                if searched_more.insert((kind, ends)) {
                    has_improved |= large.search_more(ends, self.control);
                }
            }
            if !has_improved {
                break;
            }
        }
        Ok(best.expect("a plan was found"))
    }

    /// The plan with the orders that are known now, and its cost, or [`NEVER`] if a pair that it
    /// uses has no order.
    fn with_orders(&self, tables: &[Table], mut plan: Layered) -> Layered {
        let kinds = &self.layers.kind_of;
        let mut cost = 0_u64;
        let mut before = self.constraints.loaded;
        for ((&kind, &[first, last]), order) in kinds.iter().zip(&plan.ends).zip(&mut plan.orders) {
            let table = match &tables[kind] {
                Table::Exact(within) => within,
                Table::Large(large) => &large.orders,
            };
            order.clear();
            order.extend(table.order(first, last));
            let set = &self.layers.kinds[kind];
            let change = before.map_or(0, |before| self.costs.step(before, set[first]));
            cost = cost.saturating_add(change).saturating_add(table.cost(first, last));
            before = Some(set[last]);
        }
        Layered { cost, ..plan }
    }
}
