//! The cheapest plan in which each layer has its own order.
//!
//! Tables give the cost of each layer for each pair of its first and last tool.
//! What comes after a layer depends only on its last tool, so dynamic programming from the last
//! layer back to the first finds the cheapest sequence of first and last tools.

use super::check::Layers;
use super::constraints::Constraints;
use super::within::{NEVER, Within};
use crate::CostMatrix;

/// A plan in which each layer has its own order.
pub(super) struct Layered {
    /// For each layer that uses tools.
    pub(super) orders: Vec<Vec<u8>>,
    /// The indices of the first and the last tool of each of these layers in its set.
    pub(super) ends: Vec<[usize; 2]>,
    /// Scaled cost.
    pub(super) cost: u64,
}

/// The cheapest plan, given a table for each kind of layer.
/// Of equally cheap plans, the one whose orders come lexicographically first, layer by layer.
/// Where a table has no order for a cost, the order is empty.
/// The error is the number of the first layer that has no order without forbidden changes.
///
/// O(l k²) steps for l layers of k tools.
pub(super) fn layered(
    layers: &Layers,
    tables: &[&Within],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> Result<Layered, usize> {
    let count = layers.kind_of.len();
    // The minimum costs to go, for each layer and each of its tools.
    // `begun`: of this layer and all later ones, if the layer begins with the tool.
    // `ended`: of all later layers, if the layer ends with the tool.
    let mut begun: Vec<Vec<u64>> = vec![Vec::new(); count];
    let mut ended: Vec<Vec<u64>> = vec![Vec::new(); count];
    for (layer, &kind) in layers.kind_of.iter().enumerate().rev() {
        let set = &layers.kinds[kind];
        let after = |&last: &u8| {
            let Some(&next) = layers.kind_of.get(layer + 1) else { return 0 };
            let starts = layers.kinds[next].iter().zip(&begun[layer + 1]);
            starts
                .map(|(&first, cost)| cost.saturating_add(costs.step(last, first)))
                .min()
                .unwrap_or(NEVER)
        };
        let after: Vec<u64> = set.iter().map(after).collect();
        let from = |first: usize| {
            let ways = (0..set.len())
                .map(|last| tables[kind].cost(first, last).saturating_add(after[last]));
            ways.min().unwrap_or(NEVER)
        };
        begun[layer] = (0..set.len()).map(from).collect();
        ended[layer] = after;
    }
    let mut orders: Vec<Vec<u8>> = Vec::with_capacity(count);
    let mut ends = Vec::with_capacity(count);
    let mut total = 0;
    for (layer, &kind) in layers.kind_of.iter().enumerate() {
        let set = &layers.kinds[kind];
        let before = ends.last().map_or(constraints.loaded, |&[_, last]: &[usize; 2]| {
            Some(layers.kinds[layers.kind_of[layer - 1]][last])
        });
        let from = |index: &usize| {
            let is_allowed =
                layer > 0 || constraints.first.is_none_or(|first| first == set[*index]);
            let change = before.map_or(0, |before| costs.step(before, set[*index]));
            if is_allowed { begun[layer][*index].saturating_add(change) } else { NEVER }
        };
        // Of equally good tools, the one with the smallest number.
        let first = (0..set.len()).min_by_key(from).expect("a layer has a tool");
        if layer == 0 {
            total = from(&first);
            if total == NEVER {
                return Err(layers.number[first_blocked(layers, tables, costs, constraints)]);
            }
        }
        let best = begun[layer][first];
        let lasts = (0..set.len()).filter(|&last| {
            tables[kind].cost(first, last).saturating_add(ended[layer][last]) == best
        });
        let last = lasts.min_by_key(|&last| tables[kind].order(first, last));
        let last = last.expect("the minimum is attained by a last tool");
        orders.push(tables[kind].order(first, last).to_vec());
        ends.push([first, last]);
    }
    Ok(Layered { orders, ends, cost: total })
}

/// The first layer that cannot be reached without forbidden changes, where there is no plan for all
/// layers.
fn first_blocked(
    layers: &Layers,
    tables: &[&Within],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> usize {
    // The tools with which the layers so far can end.
    let mut ends: Vec<u8> = constraints.loaded.into_iter().collect();
    for (layer, &kind) in layers.kind_of.iter().enumerate() {
        let set = &layers.kinds[kind];
        let can_begin = |&first: &usize| {
            (layer > 0 || constraints.first.is_none_or(|tool| tool == set[first]))
                && (ends.is_empty() || ends.iter().any(|&end| !costs.is_forbidden(end, set[first])))
        };
        let firsts: Vec<usize> = (0..set.len()).filter(can_begin).collect();
        let can_end =
            |&last: &usize| firsts.iter().any(|&first| tables[kind].cost(first, last) != NEVER);
        ends = (0..set.len()).filter(can_end).map(|last| set[last]).collect();
        if ends.is_empty() {
            return layer;
        }
    }
    unreachable!("all layers can be reached, so there is a plan")
}
