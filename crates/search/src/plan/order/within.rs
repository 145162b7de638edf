//! The cheapest order of one set of tools for each pair of ends.

use crate::plan::ToolCosts;

/// No order: more than any sum of costs.
pub(in crate::plan) const NEVER: u64 = u64::MAX;

/// For each first and each last tool of a set, the cheapest order between them.
pub(in crate::plan) struct Within {
    /// Number of tools.
    count: usize,
    /// At `first * count + last`, by places in the set; [`NEVER`] where there is none.
    costs: Vec<u64>,
    /// The orders themselves, of equally cheap ones the first in the alphabet; empty where there is
    /// none.
    orders: Vec<Vec<u8>>,
}

impl Within {
    /// Of a sorted set, under the pairs of `before` that lie in it.
    /// O(2^k k³) steps for k tools.
    pub(in crate::plan) fn new(set: &[u8], costs: &ToolCosts, before: &[(u8, u8)]) -> Self {
        let count = set.len();
        let place = |tool: u8| set.iter().position(|&one| one == tool);
        // For each tool, the set of those that must come before it, a bit each.
        let mut earlier = vec![0_usize; count];
        for &(a, b) in before {
            if let (Some(a), Some(b)) = (place(a), place(b)) {
                earlier[b] |= 1 << a;
            }
        }
        let step = |from: usize, to: usize| u64::from(costs.cost(set[from], set[to]));
        let all = (1_usize << count) - 1;
        let mut within = Self {
            count,
            costs: vec![NEVER; count * count],
            orders: vec![Vec::new(); count * count],
        };
        // At `left * count + now`: the cheapest way to use the tools of `left`, from `now` in it to
        // the last tool.
        // Backwards, so that orders can be read off from the front.
        let mut to_go = vec![NEVER; (all + 1) * count];
        for last in 0..count {
            to_go.fill(NEVER);
            to_go[(1 << last) * count + last] = 0;
            for left in (1..=all).filter(|left| left & 1 << last != 0) {
                for now in (0..count).filter(|&now| now != last && left & 1 << now != 0) {
                    if earlier[now] & left != 0 {
                        continue;
                    }
                    let rest = left & !(1 << now);
                    let next = (0..count).filter(|next| rest & 1 << next != 0);
                    let ways =
                        next.map(|next| to_go[rest * count + next].saturating_add(step(now, next)));
                    to_go[left * count + now] = ways.min().unwrap_or(NEVER);
                }
            }
            for first in (0..count).filter(|first| to_go[all * count + first] != NEVER) {
                within.costs[first * count + last] = to_go[all * count + first];
                let (mut now, mut left) = (first, all);
                let mut order = vec![set[first]];
                while now != last {
                    let rest = left & !(1 << now);
                    let cost = to_go[left * count + now];
                    now = (0..count)
                        .find(|&next| {
                            rest & 1 << next != 0
                                && to_go[rest * count + next].saturating_add(step(now, next))
                                    == cost
                        })
                        .expect("the least way goes on over one of the tools left");
                    left = rest;
                    order.push(set[now]);
                }
                within.orders[first * count + last] = order;
            }
        }
        within
    }

    /// The least cost from the `first` tool to the `last`, by their places in the set; [`NEVER`]
    /// where there is no order.
    pub(in crate::plan) fn cost(&self, first: usize, last: usize) -> u64 {
        self.costs[first * self.count + last]
    }

    /// The order of that cost.
    pub(in crate::plan) fn order(&self, first: usize, last: usize) -> &[u8] {
        &self.orders[first * self.count + last]
    }
}
