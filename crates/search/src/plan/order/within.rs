//! Orders of one set of tools, for each pair of a first and a last tool.

use crate::CostMatrix;

/// Cost of an order that does not exist: more than any sum of costs.
pub(in crate::plan) const NEVER: u64 = u64::MAX;

/// For each first and each last tool of a set, the cost of the best known order between them, and
/// the order.
///
/// Tools are addressed by their index in the sorted set.
pub(in crate::plan) struct Within {
    /// Number of tools.
    count: usize,
    /// Scaled costs, at `first * count + last`; [`NEVER`] if there is no order.
    costs: Vec<u64>,
    /// The orders; empty if there is none, or only its cost is known.
    orders: Vec<Vec<u8>>,
}

impl Within {
    /// The cheapest orders of a sorted set of tools, of equally cheap ones the lexicographically
    /// first, under the constraints of `before` between tools of the set.
    /// They are found by the dynamic programme of Held and Karp.
    ///
    /// O(2^k k³) steps for k tools.
    pub(in crate::plan) fn exact(set: &[u8], costs: &CostMatrix, before: &[(u8, u8)]) -> Self {
        let count = set.len();
        let earlier = earlier_tools(set, before);
        let step = |from: usize, to: usize| costs.step(set[from], set[to]);
        let all = (1_usize << count) - 1;
        let mut within = Self {
            count,
            costs: vec![NEVER; count * count],
            orders: vec![Vec::new(); count * count],
        };
        // For one last tool, at `remaining * count + now`: the minimum cost of using all tools of
        // the set `remaining`, beginning with `now`, which is one of them, and ending with `last`.
        // Solving backwards lets the orders be read off from their front.
        let mut to_go = vec![NEVER; (all + 1) * count];
        for last in 0..count {
            to_go.fill(NEVER);
            to_go[(1 << last) * count + last] = 0;
            for remaining in (1..=all).filter(|remaining| remaining & 1 << last != 0) {
                for now in (0..count).filter(|&now| now != last && remaining & 1 << now != 0) {
                    if earlier[now] & remaining != 0 {
                        continue;
                    }
                    let rest = remaining & !(1 << now);
                    let next = (0..count).filter(|next| rest & 1 << next != 0);
                    let ways =
                        next.map(|next| to_go[rest * count + next].saturating_add(step(now, next)));
                    to_go[remaining * count + now] = ways.min().unwrap_or(NEVER);
                }
            }
            for first in (0..count).filter(|first| to_go[all * count + first] != NEVER) {
                within.costs[first * count + last] = to_go[all * count + first];
                let (mut now, mut remaining) = (first, all);
                let mut order = vec![set[first]];
                while now != last {
                    let rest = remaining & !(1 << now);
                    let cost = to_go[remaining * count + now];
                    now = (0..count)
                        .find(|&next| {
                            rest & 1 << next != 0
                                && to_go[rest * count + next].saturating_add(step(now, next))
                                    == cost
                        })
                        .expect("the minimum is attained by one of the remaining tools");
                    remaining = rest;
                    order.push(set[now]);
                }
                within.orders[first * count + last] = order;
            }
        }
        within
    }

    /// Costs only, without orders, at `first * count + last`.
    pub(in crate::plan) fn with_costs(count: usize, costs: Vec<u64>) -> Self {
        Self { count, costs, orders: vec![Vec::new(); count * count] }
    }

    /// Sets the cost and the order of a pair; the order is empty if only the cost is known.
    pub(in crate::plan) fn set(&mut self, [first, last]: [usize; 2], cost: u64, order: Vec<u8>) {
        let pair = first * self.count + last;
        self.costs[pair] = cost;
        self.orders[pair] = order;
    }

    /// Cost from the `first` tool to the `last`, given by their indices; [`NEVER`] if there is no
    /// order.
    pub(in crate::plan) fn cost(&self, first: usize, last: usize) -> u64 {
        self.costs[first * self.count + last]
    }

    /// The order of that cost; empty if it is not known.
    pub(in crate::plan) fn order(&self, first: usize, last: usize) -> &[u8] {
        &self.orders[first * self.count + last]
    }

    /// The known orders and their costs, sorted by first and then by last tool.
    pub(in crate::plan) fn iter(&self) -> impl Iterator<Item = (&[u8], u64)> {
        let orders = self.orders.iter().zip(&self.costs);
        orders.filter(|(order, _)| !order.is_empty()).map(|(order, &cost)| (order.as_slice(), cost))
    }
}

/// For each tool of a set, the tools that must come before it, one bit each.
pub(super) fn earlier_tools(set: &[u8], before: &[(u8, u8)]) -> Vec<usize> {
    let index = |tool: u8| set.iter().position(|&one| one == tool);
    let mut earlier = vec![0_usize; set.len()];
    for &(a, b) in before {
        if let (Some(a), Some(b)) = (index(a), index(b)) {
            earlier[b] |= 1 << a;
        }
    }
    earlier
}
