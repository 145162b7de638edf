//! The best plans by trying all of them, and checks of plans.

use std::collections::BTreeMap;

use super::super::within::NEVER;
use super::super::{Constraints, cost_and_changes};
use crate::CostMatrix;

/// All orders of some tools, in lexicographic order.
pub(super) fn permutations(tools: &[u8]) -> Vec<Vec<u8>> {
    if tools.is_empty() {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (at, &tool) in tools.iter().enumerate() {
        let mut others = tools.to_vec();
        others.remove(at);
        for rest in permutations(&others) {
            all.push([&[tool], rest.as_slice()].concat());
        }
    }
    all
}

pub(super) fn set(tools: &[u8]) -> Vec<u8> {
    let mut set = tools.to_vec();
    set.sort_unstable();
    set.dedup();
    set
}

/// Whether orders obey the constraints and avoid forbidden changes.
pub(super) fn is_allowed(
    orders: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> bool {
    let obeys = |order: &Vec<u8>| {
        let position = |tool: u8| order.iter().position(|&one| one == tool);
        constraints.before.iter().all(|&(a, b)| match (position(a), position(b)) {
            (Some(a), Some(b)) => a < b,
            _ => true,
        })
    };
    let first = orders.iter().flatten().next();
    orders.iter().all(obeys)
        && constraints.first.is_none_or(|tool| first == Some(&tool))
        && cost_of(orders, costs, constraints) != NEVER
}

pub(super) fn cost_of(orders: &[Vec<u8>], costs: &CostMatrix, constraints: &Constraints) -> u64 {
    cost_and_changes(orders, costs, constraints.loaded).0
}

/// The cheapest plan, of equally cheap ones the lexicographically first, by trying all.
pub(super) fn slow_layered(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> Option<(u64, Vec<Vec<u8>>)> {
    let mut plans: Vec<Vec<Vec<u8>>> = vec![Vec::new()];
    for layer in layers {
        let orders = permutations(&set(layer));
        plans = plans
            .into_iter()
            .flat_map(|plan| {
                orders
                    .iter()
                    .map(move |order| [plan.as_slice(), std::slice::from_ref(order)].concat())
            })
            .collect();
    }
    plans.retain(|plan| is_allowed(plan, costs, constraints));
    plans.into_iter().map(|plan| (cost_of(&plan, costs, constraints), plan)).min()
}

/// The cheapest permutation for all layers, by trying all.
pub(super) fn slow_shared(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> Option<(u64, Vec<u8>)> {
    let tried = permutations(&set(&layers.concat())).into_iter().filter_map(|permutation| {
        let orders = followed(layers, &permutation);
        is_allowed(&orders, costs, constraints)
            .then(|| (cost_of(&orders, costs, constraints), permutation))
    });
    tried.min()
}

pub(super) fn followed(layers: &[Vec<u8>], permutation: &[u8]) -> Vec<Vec<u8>> {
    let follow = |layer: &Vec<u8>| {
        permutation.iter().copied().filter(|tool| layer.contains(tool)).collect::<Vec<u8>>()
    };
    layers.iter().map(follow).collect()
}

/// The minimum cost of a plan that may use tools repeatedly, by Dijkstra's algorithm.
/// A state is a layer, the set of the tools used in it, and the current tool; `before` holds for
/// first uses.
pub(super) fn slow_bound(
    layers: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
) -> Option<u64> {
    let tools = costs.size() as u8;
    let layers: Vec<&Vec<u8>> = layers.iter().filter(|layer| !layer.is_empty()).collect();
    if layers.is_empty() {
        return Some(0);
    }
    let detours = costs.with_detours();
    let visit = |layer: usize, used: u16, tool: u8| -> Option<u16> {
        let is_new = layers[layer].contains(&tool) && used & 1 << tool == 0;
        let blocked = constraints
            .before
            .iter()
            .any(|&(a, b)| b == tool && layers[layer].contains(&a) && used & 1 << a == 0);
        match (is_new, blocked) {
            (true, true) => None,
            (true, false) => Some(used | 1 << tool),
            (false, _) => Some(used),
        }
    };
    let mut open: BTreeMap<(usize, u16, u8), u64> = BTreeMap::new();
    for tool in (0..tools).filter(|&tool| constraints.first.is_none_or(|first| first == tool)) {
        if let Some(used) = visit(0, 0, tool) {
            let cost = constraints.loaded.map_or(0, |loaded| detours.step(loaded, tool));
            if cost != NEVER {
                open.insert((0, used, tool), cost);
            }
        }
    }
    let mut done = BTreeMap::new();
    while let Some((&state, &cost)) = open.iter().min_by_key(|&(_, cost)| cost) {
        open.remove(&state);
        done.insert(state, cost);
        let (layer, used, now) = state;
        let mut next = Vec::new();
        if layers[layer].iter().all(|&tool| used & 1 << tool != 0) {
            if layer + 1 == layers.len() {
                return Some(cost);
            }
            // The current tool need not print in the next layer at once.
            next.push(((layer + 1, 0, now), cost));
            next.extend(visit(layer + 1, 0, now).map(|used| ((layer + 1, used, now), cost)));
        }
        for tool in 0..tools {
            let step = cost.saturating_add(costs.step(now, tool));
            if step == NEVER {
                continue;
            }
            next.extend(visit(layer, used, tool).map(|used| ((layer, used, tool), step)));
        }
        for (state, cost) in next {
            if !done.contains_key(&state) {
                let known = open.entry(state).or_insert(cost);
                *known = cost.min(*known);
            }
        }
    }
    None
}
