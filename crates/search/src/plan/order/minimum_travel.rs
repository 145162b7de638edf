//! Of all orders of the tools with the same cost, one with the minimum travel.
//!
//! Many orders cost the same: with equal costs, every permutation of the tools between the first
//! and the last one of a layer.
//! The dynamic programme of Held and Karp runs through all layers at once: a state is a layer, the
//! set of tools that it has used so far, and the last of them.
//! Its values are pairs of cost and travel, compared by cost first, so a state's best value can be
//! extended without regard to how it was reached.

use super::constraints::Constraints;

use super::outcome::ToolOrder;
use super::within::{NEVER, earlier_tools};
use super::{MAX_EXACT, cost_and_changes};
use crate::CostMatrix;

/// Maximum number of steps, of some nanoseconds each.
const MAX_STEPS: usize = 200_000_000;

/// What leads to a state, at best.
#[derive(Clone, Copy)]
struct Value {
    /// Scaled cost of the changes.
    cost: u64,
    /// Travel in the caller's unit.
    travel: f64,
}

impl Value {
    const UNREACHED: Self = Self { cost: NEVER, travel: f64::INFINITY };

    fn plus(self, cost: u64, travel: f64) -> Self {
        Self { cost: self.cost.saturating_add(cost), travel: self.travel + travel }
    }

    fn is_less(self, other: Self) -> bool {
        self.cost < other.cost || (self.cost == other.cost && self.travel < other.travel)
    }
}

/// The states of a layer, each at `used * tools + last`, where `used` has a bit for each tool.
struct LayerStates<'a> {
    set: &'a [u8],
    values: Vec<Value>,
    /// The last tool of the state before, by its index in its layer's set.
    before: Vec<u8>,
}

impl ToolOrder {
    /// Takes, of all orders that cost as little and obey the constraints, one with the minimum
    /// travel; of those, always the same one.
    ///
    /// `travel` is the travel from a tool of one layer to a tool of the same layer or of the next
    /// one that uses any, for their numbers and the tools; it is finite and not negative.
    /// A tool that stays does not travel.
    /// `costs` and `constraints` are those that the order was made for.
    ///
    /// Nothing changes if the cost is not proven minimal, if all layers follow one permutation, if
    /// a layer has more than 12 tools, or if it would take more than some seconds.
    /// It takes O(2^k k²) steps for each layer of k tools.
    #[must_use]
    pub fn with_minimum_travel(
        mut self,
        costs: &CostMatrix,
        constraints: &Constraints,
        travel: impl Fn([usize; 2], [u8; 2]) -> f64,
    ) -> Self {
        let sets: Vec<Vec<u8>> = self.orders.iter().map(|order| sorted(order)).collect();
        let steps = sets.iter().map(|set| (set.len() * set.len()) << set.len().min(MAX_EXACT));
        let is_small = sets.iter().all(|set| set.len() <= MAX_EXACT)
            && steps.fold(0, usize::saturating_add) <= MAX_STEPS;
        if !self.is_optimal() || self.permutation.is_some() || !is_small {
            return self;
        }
        let Some(orders) = minimum_travel(&sets, costs, constraints, travel) else { return self };
        let (cost, changes) = cost_and_changes(&orders, costs, constraints.loaded);
        if cost != NEVER && costs.unscaled(cost) <= self.cost {
            self.orders = orders;
            self.changes = changes;
        }
        self
    }
}

fn sorted(order: &[u8]) -> Vec<u8> {
    let mut set = order.to_vec();
    set.sort_unstable();
    set
}

/// The cheapest orders of sorted sets of tools, and of those one with the minimum travel; `None` if
/// every order has a forbidden change.
fn minimum_travel(
    sets: &[Vec<u8>],
    costs: &CostMatrix,
    constraints: &Constraints,
    travel: impl Fn([usize; 2], [u8; 2]) -> f64,
) -> Option<Vec<Vec<u8>>> {
    let used: Vec<usize> = (0..sets.len()).filter(|&layer| !sets[layer].is_empty()).collect();
    let mut all: Vec<LayerStates<'_>> = Vec::with_capacity(used.len());
    for (at, &layer) in used.iter().enumerate() {
        let mut states = LayerStates::new(&sets[layer]);
        for (index, &tool) in sets[layer].iter().enumerate() {
            let begin = match (at.checked_sub(1), constraints.loaded) {
                (Some(below), _) => {
                    let step = |from: u8| {
                        let layers = [used[below], layer];
                        let way = if from == tool { 0.0 } else { travel(layers, [from, tool]) };
                        (costs.step(from, tool), way)
                    };
                    all[below].best_to(step)
                }
                (None, loaded) => {
                    let cost = loaded.map_or(0, |loaded| costs.step(loaded, tool));
                    let is_allowed = constraints.first.is_none_or(|first| first == tool);
                    (if is_allowed { Value { cost, travel: 0.0 } } else { Value::UNREACHED }, 0)
                }
            };
            states.reach(1 << index, index, begin);
        }
        states.fill(costs, &constraints.before, |pair| travel([layer; 2], pair));
        all.push(states);
    }

    let mut orders = vec![Vec::new(); sets.len()];
    let (end, mut last) = all.last()?.best_to(|_| (0, 0.0));
    if end.cost == NEVER {
        return None;
    }
    for (&layer, states) in used.iter().zip(&all).rev() {
        let order: &mut Vec<u8> = &mut orders[layer];
        let mut used = states.all();
        while used != 0 {
            let state = used * states.set.len() + usize::from(last);
            order.push(states.set[usize::from(last)]);
            used &= !(1 << last);
            last = states.before[state];
        }
        order.reverse();
    }
    Some(orders)
}

impl<'a> LayerStates<'a> {
    fn new(set: &'a [u8]) -> Self {
        let count = set.len() << set.len();
        Self { set, values: vec![Value::UNREACHED; count], before: vec![0; count] }
    }

    /// All tools, one bit each.
    fn all(&self) -> usize {
        (1 << self.set.len()) - 1
    }

    /// Enters a way to a state, and the last tool before it, if it is better than those so far.
    fn reach(&mut self, used: usize, last: usize, (value, before): (Value, u8)) {
        let state = used * self.set.len() + last;
        if value.cost != NEVER && value.is_less(self.values[state]) {
            self.values[state] = value;
            self.before[state] = before;
        }
    }

    /// Extends the states of one tool to those of all tools.
    fn fill(&mut self, costs: &CostMatrix, before: &[(u8, u8)], travel: impl Fn([u8; 2]) -> f64) {
        let count = self.set.len();
        let earlier = earlier_tools(self.set, before);
        let steps: Vec<(u64, f64)> = (0..count * count)
            .map(|pair| [self.set[pair / count], self.set[pair % count]])
            .map(|pair| {
                let way = if pair[0] == pair[1] { 0.0 } else { travel(pair) };
                (costs.step(pair[0], pair[1]), way)
            })
            .collect();
        for used in 1..=self.all() {
            for last in (0..count).filter(|last| used & 1 << last != 0) {
                let value = self.values[used * count + last];
                // A tool that should have waited for one that is not used yet.
                if value.cost == NEVER || earlier[last] & !used != 0 {
                    continue;
                }
                for next in (0..count).filter(|next| used & 1 << next == 0) {
                    let (cost, way) = steps[last * count + next];
                    self.reach(used | 1 << next, next, (value.plus(cost, way), last as u8));
                }
            }
        }
    }

    /// The best value behind a step from the last tool of this layer, and the index of that tool.
    fn best_to(&self, step: impl Fn(u8) -> (u64, f64)) -> (Value, u8) {
        let ends = &self.values[self.all() * self.set.len()..];
        let mut best = (Value::UNREACHED, 0);
        for (index, (&value, &tool)) in (0..).zip(ends.iter().zip(self.set)) {
            let (cost, way) = step(tool);
            let value = value.plus(cost, way);
            if value.cost != NEVER && value.is_less(best.0) {
                best = (value, index);
            }
        }
        best
    }
}
