//! The cheapest order of the tools over the layers of a part.
//!
//! Within a layer this is a shortest Hamiltonian path over its tools.
//! It is found for each pair of a first and a last tool by the dynamic programme of Held and Karp,
//! "A dynamic programming approach to sequencing problems" (J. SIAM 10, 1962), in `within.rs`.
//! Over the layers it is a shortest path through those first and last tools, in `layered.rs`.
//!
//! The dynamic programme within a layer is too slow for many tools.
//! For those, `large.rs` finds good orders by local search (`local_search.rs`), and lower bounds by
//! Lagrangian relaxation (`ascent.rs`, `arborescence.rs`); `solve.rs` combines both to a plan and
//! its bound.
//!
//! `shared.rs` finds one permutation that all layers follow.

mod arborescence;
mod ascent;
mod check;
mod constraints;
mod large;
mod layered;
mod local_search;
mod minimum_travel;
mod outcome;
mod problem;
mod shared;
mod solve;
#[cfg(test)]
mod tests;
pub(in crate::plan) mod within;

use std::collections::HashMap;

use beadwork_base::Control;

pub use constraints::{Constraints, OrderError};
pub use outcome::{FixedOrder, ToolOrder};

use self::check::Layers;
use self::shared::shared;
use self::solve::{Solved, Solver};
use self::within::Within;
use crate::{CostMatrix, Stop};

/// Maximum number of tools of a layer that is solved exactly; each additional tool doubles the
/// time.
const MAX_EXACT: usize = 12;

/// Finds the cheapest order of the tools, where each layer uses each of its tools once.
///
/// `layers` holds the tools of each layer in any order; duplicates count once.
/// A layer may use no tool: the tool in the nozzle then stays for the next layer.
/// A change costs the same within a layer and between two layers.
/// A layer that begins with the tool that ended the layer below needs no change between them, nor
/// does a first layer that begins with [`Constraints::loaded`].
///
/// Of equally cheap plans, the result is the one whose orders come lexicographically first, layer
/// by layer from the first; with [`Constraints::same_order`] or in large layers, the result is only
/// guaranteed to be the same every time.
///
/// An interrupted call returns the best plan so far, with the reason in [`ToolOrder::stop`].
/// Progress counts different sets of tools.
/// It takes O(d 2^k k³ + l k²) steps for l layers of at most k <= 12 tools with d different sets
/// among them.
/// This doubles if a detour over another tool is cheaper than a direct change, because the bound
/// then needs tables of its own.
/// Works on `control.threads`; the result does not depend on them.
///
/// # Layers of more than 12 tools
/// Their orders come from a local search, and [`ToolOrder::once_bound`] from a relaxation, so
/// [`ToolOrder::is_optimal`] may be false even if the plan cannot be improved.
/// 30 tools take some seconds, 255 tools about a minute.
///
/// # One permutation
/// With [`Constraints::same_order`], the number of states of the search can grow exponentially with
/// the number of tools, though not if all layers use the same tools.
/// The search is abandoned beyond a million states, or fewer if there are many different sets, so
/// that it takes some seconds and a few hundred MB at most.
/// The result is then the best permutation of a local search that moves one tool at a time; it
/// obeys all constraints, but [`ToolOrder::is_optimal`] may be false, and [`ToolOrder::once_bound`]
/// is the bound for plans that need not follow one permutation.
pub fn order(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
    control: &Control<'_>,
) -> Result<ToolOrder, OrderError> {
    Ok(order_and_tables(layers, costs, constraints, control)?.order)
}

/// The result of [`order`], and what it was made from.
pub(super) struct Solution {
    pub(super) order: ToolOrder,
    /// For each different set of tools, the orders that were found.
    pub(super) tables: HashMap<Vec<u8>, Within>,
}

/// The order of [`order`], with its tables.
pub(super) fn order_and_tables(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
    control: &Control<'_>,
) -> Result<Solution, OrderError> {
    solve(layers, costs, constraints, MAX_EXACT, control)
}

/// [`order_and_tables`], with another limit of the size of the sets that are solved exactly.
fn solve(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
    max_exact: usize,
    control: &Control<'_>,
) -> Result<Solution, OrderError> {
    let layers = Layers::new(layers, costs, constraints)?;
    let solver = Solver { layers: &layers, costs, constraints, max_exact, control };
    let Solved { plan, bound: layered_bound, tables } = solver.solve()?;
    let with_detours = costs.with_detours();
    let bound = if with_detours == *costs {
        layered_bound
    } else {
        let control = control.without_progress();
        Solver { costs: &with_detours, control: &control, ..solver }.bound()?
    };
    let min_changes = solver.min_changes();
    // Both are lower bounds of these plans, and either relaxation may give the better one.
    let layered_bound = layered_bound.max(bound);

    let (orders, permutation, is_proven) = if constraints.same_order {
        let max_labels = shared::MAX_LABELS;
        let (permutation, is_proven) =
            shared(&layers, costs, constraints, &plan, layered_bound, max_labels, control)?;
        let follow =
            |set: &[u8]| permutation.iter().copied().filter(|tool| set.contains(tool)).collect();
        (layers.iter().map(follow).collect(), Some(permutation), is_proven)
    } else {
        (plan.orders, None, plan.cost == layered_bound)
    };
    let orders: Vec<Vec<u8>> = layers.with_empty(orders);
    let (cost, changes) = cost_and_changes(&orders, costs, constraints.loaded);
    let once_bound = if is_proven { cost } else { layered_bound };
    let stop = match control.interrupted() {
        _ if cost == once_bound => Stop::Optimal,
        Some(interrupted) => interrupted.into(),
        None => Stop::Done,
    };
    let order = ToolOrder {
        orders,
        permutation,
        cost: costs.unscaled(cost),
        changes,
        bound: costs.unscaled(bound),
        once_bound: costs.unscaled(once_bound),
        min_changes,
        stop,
    };
    Ok(Solution { order, tables: layers.kinds.into_iter().zip(tables).collect() })
}

/// Cost of printing the tools of each layer by ascending number, the same in every layer: for
/// comparison.
///
/// The layers are as for [`order`], and `loaded` is the tool in the nozzle before the print.
/// Infinite if a change is forbidden.
/// Linear in the number of tools of all layers.
pub fn fixed_order_cost(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    loaded: Option<u8>,
) -> Result<FixedOrder, OrderError> {
    let constraints = Constraints { loaded, ..Constraints::default() };
    let layers = Layers::new(layers, costs, &constraints)?;
    let orders: Vec<Vec<u8>> = layers.iter().map(<[u8]>::to_vec).collect();
    let (cost, changes) = cost_and_changes(&orders, costs, loaded);
    let cost = if cost == within::NEVER { f64::INFINITY } else { costs.unscaled(cost) };
    Ok(FixedOrder { cost, changes })
}

/// Scaled cost and number of changes of a plan.
fn cost_and_changes(orders: &[Vec<u8>], costs: &CostMatrix, loaded: Option<u8>) -> (u64, u32) {
    let mut uses: Vec<u8> = loaded.into_iter().collect();
    uses.extend(orders.iter().flatten());
    let changes = uses.windows(2).filter(|pair| pair[0] != pair[1]);
    let cost = uses.windows(2).map(|pair| costs.step(pair[0], pair[1]));
    (cost.fold(0, u64::saturating_add), changes.count() as u32)
}
