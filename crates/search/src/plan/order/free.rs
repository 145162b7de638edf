//! The cheapest plan where each layer has its own order.

use super::check::Layers;
use super::within::{NEVER, Within};
use super::{Constraints, ToolCosts};

/// A cheapest plan.
pub(super) struct Free {
    pub(super) orders: Vec<Vec<u8>>,
    pub(super) cost: u64,
}

/// From the last layer back to the first: what is to come depends on the layers so far by their
/// last tool only.
pub(super) fn free(layers: &Layers, costs: &ToolCosts, constraints: &Constraints) -> Free {
    let tables: Vec<Within> =
        layers.kinds.iter().map(|set| Within::new(set, costs, &constraints.before)).collect();
    let step = |from: u8, to: u8| u64::from(costs.cost(from, to));
    let count = layers.kind_of.len();
    // For each layer and each of its tools: the cost from there on if it begins with that tool; and
    // of all that comes after the layer if it ends with it.
    let mut begun: Vec<Vec<u64>> = vec![Vec::new(); count];
    let mut ended: Vec<Vec<u64>> = vec![Vec::new(); count];
    for (layer, &kind) in layers.kind_of.iter().enumerate().rev() {
        let set = &layers.kinds[kind];
        let after = |&last: &u8| {
            let Some(next) = layers.kind_of.get(layer + 1) else { return 0 };
            let starts = layers.kinds[*next].iter().zip(&begun[layer + 1]);
            starts
                .map(|(&first, cost)| cost.saturating_add(step(last, first)))
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
    let mut total = 0;
    for (layer, &kind) in layers.kind_of.iter().enumerate() {
        let set = &layers.kinds[kind];
        let before = orders.last().and_then(|order: &Vec<u8>| order.last().copied());
        let from = |place: &usize| match (before, constraints.first) {
            (Some(last), _) => begun[layer][*place].saturating_add(step(last, set[*place])),
            (None, Some(first)) if first != set[*place] => NEVER,
            (None, _) => begun[layer][*place],
        };
        // Of equal ones the first, which is the tool of the least number.
        let first = (0..set.len()).min_by_key(from).expect("a layer has a tool");
        if layer == 0 {
            total = from(&first);
        }
        let best = begun[layer][first];
        let lasts = (0..set.len()).filter(|&last| {
            tables[kind].cost(first, last).saturating_add(ended[layer][last]) == best
        });
        let order = lasts.map(|last| tables[kind].order(first, last)).min();
        orders.push(order.expect("pairs without a circle leave an order").to_vec());
    }
    Free { orders, cost: total }
}
