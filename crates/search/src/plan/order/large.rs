//! Orders of a set of tools that is too large to be solved exactly.
//!
//! Each pair of a first and a last tool has a proven lower bound, and an order from a local search.
//! There are many pairs, and a plan uses few of them, so both are computed only where they are
//! needed: cheap bounds for all pairs come first, and the dynamic programme over the layers
//! (`layered.rs`) decides which pairs matter.

use beadwork_base::Control;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::ascent::Ascent;
use super::local_search::{can_exchange, improve, nearest_neighbours, perturb};
use super::problem::{PENALTY, Problem};
use super::within::{NEVER, Within};
use crate::CostMatrix;

/// A large set of tools.
pub(super) struct Large {
    set: Vec<u8>,
    problem: Problem,
    ascent: Ascent,
    /// Lower bounds, without orders.
    pub(super) bounds: Within,
    /// The orders that were found; for pairs that were not searched, their lower bounds.
    pub(super) orders: Within,
    /// Pairs whose bound was raised.
    is_raised: Vec<bool>,
    /// Pairs whose order was searched for.
    is_searched: Vec<bool>,
}

impl Large {
    /// A set with cheap bounds, and no orders yet.
    pub(super) fn new(set: &[u8], costs: &CostMatrix, before: &[(u8, u8)]) -> Self {
        let problem = Problem::new(set, costs, before);
        let ascent = Ascent::new(&problem);
        let bounds = ascent.bounds_of_all(&problem);
        let pairs = bounds.len();
        Self {
            set: set.to_vec(),
            ascent,
            bounds: Within::with_costs(set.len(), bounds.clone()),
            orders: Within::with_costs(set.len(), bounds),
            is_raised: vec![false; pairs],
            is_searched: vec![false; pairs],
            problem,
        }
    }

    fn pair(&self, [first, last]: [usize; 2]) -> usize {
        first * self.problem.count + last
    }

    /// Whether the bound of a pair was raised.
    pub(super) fn is_raised(&self, ends: [usize; 2]) -> bool {
        self.is_raised[self.pair(ends)]
    }

    /// Raises the bound of a pair; the new multipliers may raise those of the others too.
    pub(super) fn raise_bound(&mut self, ends: [usize; 2]) {
        /// Iterations of the first ascent for each tool, and of later ones, which start from its
        /// multipliers.
        const FIRST_PER_TOOL: usize = 10;
        const LATER: usize = 40;

        let is_first = !self.is_raised.contains(&true);
        let iterations = if is_first { FIRST_PER_TOOL * self.problem.count } else { LATER };
        let known = self.problem.cost(&nearest_neighbours(&self.problem, ends));
        let raised = self.ascent.bound(&self.problem, ends, known, iterations);
        let pair = self.pair(ends);
        self.is_raised[pair] = true;
        let mut others = self.ascent.bounds_of_all(&self.problem);
        others[pair] = others[pair].max(raised);
        for (pair, &bound) in others.iter().enumerate() {
            let ends = [pair / self.problem.count, pair % self.problem.count];
            if bound > self.bounds.cost(ends[0], ends[1]) {
                self.bounds.set(ends, bound, Vec::new());
                if !self.is_searched[pair] {
                    self.orders.set(ends, bound, Vec::new());
                }
            }
        }
    }

    /// Whether an order of a pair was searched for.
    pub(super) fn is_searched(&self, ends: [usize; 2]) -> bool {
        self.is_searched[self.pair(ends)]
    }

    /// Searches for an order of a pair, and returns the approximate number of steps it took.
    /// An interrupted call only finds the path of nearest neighbours.
    pub(super) fn search(&mut self, ends: [usize; 2], control: &Control<'_>) -> usize {
        let perturbations = self.perturbations(2_000_000, 10);
        let mut order = nearest_neighbours(&self.problem, ends);
        if control.interrupted().is_none() {
            improve(&self.problem, &mut order, control);
            self.perturb(ends, &mut order, perturbations, control);
        }
        self.keep(ends, &order);
        (perturbations + 2) * self.problem.count.pow(3)
    }

    /// Searches for a better order of a pair that was searched before, with many more
    /// perturbations.
    /// Returns whether it found better orders, of this pair or of others.
    pub(super) fn search_more(&mut self, ends: [usize; 2], control: &Control<'_>) -> bool {
        let [first, last] = ends;
        let cost = self.orders.cost(first, last);
        if cost == NEVER || cost <= self.bounds.cost(first, last) {
            return false;
        }
        let index = |tool: &u8| self.set.binary_search(tool).expect("the order is one of the set");
        let mut order: Vec<usize> = self.orders.order(first, last).iter().map(index).collect();
        self.perturb(ends, &mut order, self.perturbations(200_000_000, 1000), control);
        self.keep(ends, &order)
    }

    /// Number of perturbations that about `steps` steps allow: each local search takes about cubic
    /// time.
    fn perturbations(&self, steps: usize, max: usize) -> usize {
        (steps / self.problem.count.pow(3)).min(max)
    }

    fn perturb(
        &self,
        ends: [usize; 2],
        order: &mut Vec<usize>,
        times: usize,
        control: &Control<'_>,
    ) {
        // Each search has its own random stream, so that it does not depend on earlier ones.
        let seed = (self.pair(ends) + times) as u64;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let bound = self.bounds.cost(ends[0], ends[1]);
        perturb(&self.problem, order, times, bound, &mut rng, control);
    }

    /// Keeps an order if it is the best one of its pair and has no forbidden changes.
    /// Does the same with the orders of other pairs that result from it by exchanging two segments
    /// of which one contains an end.
    /// Returns whether any order was kept.
    fn keep(&mut self, ends: [usize; 2], order: &[usize]) -> bool {
        let pair = self.pair(ends);
        if !self.is_searched[pair] {
            self.is_searched[pair] = true;
            self.orders.set(ends, NEVER, Vec::new());
        }
        let mut is_kept = self.keep_if_better(order);
        let count = order.len();
        for (i, j) in (1..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))) {
            // The first two of the segments 0..i, i..j and j..count, or the last two.
            for [begin, cut, end] in [[0, i, j], [i, j, count]] {
                if can_exchange(&self.problem, &order[begin..cut], &order[cut..end]) {
                    let mut exchanged = order.to_vec();
                    exchanged[begin..end].rotate_left(cut - begin);
                    is_kept |= self.keep_if_better(&exchanged);
                }
            }
        }
        is_kept
    }

    fn keep_if_better(&mut self, order: &[usize]) -> bool {
        let ends = [order[0], order[order.len() - 1]];
        let cost = self.problem.cost(order);
        let is_searched = self.is_searched[self.pair(ends)];
        let is_better = is_searched && cost < PENALTY && cost < self.orders.cost(ends[0], ends[1]);
        if is_better {
            let order = order.iter().map(|&index| self.set[index]).collect();
            self.orders.set(ends, cost, order);
        }
        is_better
    }
}
