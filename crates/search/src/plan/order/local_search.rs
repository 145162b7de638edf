//! Good orders of many tools: a nearest-neighbour path, improved by local search.
//!
//! The moves keep both ends of the path and the constraints on which tools come before others.
//! They are evaluated in O(1):
//!
//! - **Exchange** of two neighbouring segments.
//!   It changes three steps and keeps the direction of all others, so it suits costs that depend on
//!   the direction.
//!   Moving one tool elsewhere (Or-opt) is a special case.
//! - **Reversal** of a segment (2-opt).
//!   It changes two steps and the direction of those inside, whose costs are known from prefix
//!   sums.
//!
//! When no move improves the path, random exchanges perturb it and the search starts again: an
//! iterated local search.

use beadwork_base::Control;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::problem::{Members, Problem};
use crate::random::below;

/// The path that always continues with the tool that is cheapest to change to; the constraints must
/// allow its ends.
pub(super) fn nearest_neighbours(problem: &Problem, [first, last]: [usize; 2]) -> Vec<usize> {
    let mut order = vec![first];
    // The tools that are placed, and those that are not.
    let mut is_placed = vec![false; problem.count];
    is_placed[first] = true;
    while order.len() + 1 < problem.count {
        let here = order[order.len() - 1];
        let is_ready = |&tool: &usize| {
            !is_placed[tool]
                && tool != last
                && (0..problem.count)
                    .all(|other| is_placed[other] || !problem.earlier[tool].contains(other))
        };
        let next = (0..problem.count).filter(is_ready).min_by_key(|&tool| problem.step(here, tool));
        let next = next.expect("constraints without a cycle leave a tool");
        is_placed[next] = true;
        order.push(next);
    }
    if problem.count > 1 {
        order.push(last);
    }
    order
}

/// Applies moves that improve the path until there is none, or the search is interrupted.
pub(super) fn improve(problem: &Problem, order: &mut [usize], control: &Control<'_>) {
    let mut sums = Sums::new(problem, order);
    loop {
        let exchanged = exchange_segments(problem, order);
        sums.update(problem, order);
        let reversed = reverse_segments(problem, order, &mut sums);
        if !(exchanged || reversed) || control.interrupted().is_some() {
            return;
        }
    }
}

/// Perturbs and improves the path this number of times, keeping the best, until it costs `bound`.
pub(super) fn perturb(
    problem: &Problem,
    order: &mut Vec<usize>,
    times: usize,
    bound: u64,
    rng: &mut Xoshiro256PlusPlus,
    control: &Control<'_>,
) {
    let mut best = problem.cost(order);
    for _ in 0..times {
        if best <= bound || problem.count < 4 || control.interrupted().is_some() {
            return;
        }
        let mut other = order.clone();
        for _ in 0..2 {
            exchange_at_random(problem, &mut other, rng);
        }
        improve(problem, &mut other, control);
        let cost = problem.cost(&other);
        if cost <= best {
            best = cost;
            *order = other;
        }
    }
}

/// Whether no tool of the first segment must come before one of the second.
pub(super) fn can_exchange(problem: &Problem, first: &[usize], second: &[usize]) -> bool {
    let mut members = Members::default();
    first.iter().for_each(|&tool| members.insert(tool));
    second.iter().all(|&tool| !problem.earlier[tool].intersects(members))
}

/// Change of the cost if the segments `i..j` and `j..l` are exchanged, neither of which contains an
/// end of the path.
#[inline]
fn exchange_change(problem: &Problem, order: &[usize], [i, j, l]: [usize; 3]) -> i64 {
    let step = |from: usize, to: usize| problem.step(order[from], order[to]) as i64;
    step(i - 1, j) + step(l - 1, i) + step(j - 1, l)
        - step(i - 1, i)
        - step(j - 1, j)
        - step(l - 1, l)
}

/// Exchanges segments wherever that improves the path; returns whether it did.
fn exchange_segments(problem: &Problem, order: &mut [usize]) -> bool {
    let end = order.len().saturating_sub(1);
    let mut has_improved = false;
    for i in 1..end {
        let mut first = Members::default();
        let mut j = i;
        while j + 1 < end {
            first.insert(order[j]);
            j += 1;
            for l in j + 1..=end {
                if problem.earlier[order[l - 1]].intersects(first) {
                    break;
                }
                if exchange_change(problem, order, [i, j, l]) < 0 {
                    order[i..l].rotate_left(j - i);
                    has_improved = true;
                    // The exchange has put other tools into the first segment.
                    first = Members::default();
                    order[i..j].iter().for_each(|&tool| first.insert(tool));
                    break;
                }
            }
        }
    }
    has_improved
}

/// Reverses segments wherever that improves the path; returns whether it did.
fn reverse_segments(problem: &Problem, order: &mut [usize], sums: &mut Sums) -> bool {
    let end = order.len().saturating_sub(1);
    let mut has_improved = false;
    for i in 1..end {
        let mut members = Members::default();
        for l in i + 1..=end {
            // Constraints within the segment forbid reversing it and every longer one.
            if problem.earlier[order[l - 1]].intersects(members) {
                break;
            }
            members.insert(order[l - 1]);
            if sums.reversal_change(problem, order, i, l) < 0 {
                order[i..l].reverse();
                sums.update(problem, order);
                has_improved = true;
            }
        }
    }
    has_improved
}

/// Exchanges two random segments, if the constraints allow it.
fn exchange_at_random(problem: &Problem, order: &mut [usize], rng: &mut Xoshiro256PlusPlus) {
    let mut cuts = [0; 3].map(|_| 1 + below(rng, order.len() - 1));
    cuts.sort_unstable();
    let [i, j, l] = cuts;
    if i < j && j < l && can_exchange(problem, &order[i..j], &order[j..l]) {
        order[i..l].rotate_left(j - i);
    }
}

/// Prefix sums of the costs of a path's steps, forwards and backwards.
struct Sums {
    forwards: Vec<i64>,
    backwards: Vec<i64>,
}

impl Sums {
    fn new(problem: &Problem, order: &[usize]) -> Self {
        let mut sums = Self { forwards: Vec::new(), backwards: Vec::new() };
        sums.update(problem, order);
        sums
    }

    fn update(&mut self, problem: &Problem, order: &[usize]) {
        let sum = |sums: &mut Vec<i64>, step: &dyn Fn(usize, usize) -> u64| {
            sums.clear();
            sums.push(0);
            let mut sum = 0;
            for pair in order.windows(2) {
                sum += step(pair[0], pair[1]) as i64;
                sums.push(sum);
            }
        };
        sum(&mut self.forwards, &|from, to| problem.step(from, to));
        sum(&mut self.backwards, &|from, to| problem.step(to, from));
    }

    /// Change of the cost if the segment `i..l`, which contains no end of the path, is reversed.
    #[inline]
    fn reversal_change(&self, problem: &Problem, order: &[usize], i: usize, l: usize) -> i64 {
        let step = |from: usize, to: usize| problem.step(order[from], order[to]) as i64;
        let inside = |sums: &[i64]| sums[l - 1] - sums[i];
        step(i - 1, l - 1) + step(i, l) + inside(&self.backwards)
            - step(i - 1, i)
            - step(l - 1, l)
            - inside(&self.forwards)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::CostMatrix;

    #[test]
    fn changes_are_those_of_the_cost_and_constraints_hold() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..500 {
            let count = rng.random_range(4..12_usize);
            let costs: Vec<f64> = (0..144).map(|_| rng.random_range(0..50).into()).collect();
            let costs = CostMatrix::from_fn(count, |from, to| costs[12 * from + to]).unwrap();
            let set: Vec<u8> = (0..count as u8).collect();
            let before: Vec<(u8, u8)> = (0..rng.random_range(0..4))
                .map(|_| (rng.random_range(0..count as u8), rng.random_range(0..count as u8)))
                .filter(|(a, b)| a < b)
                .collect();
            let problem = Problem::new(&set, &costs, &before);
            let pairs = (0..count * count).map(|pair| [pair / count, pair % count]);
            let allowed: Vec<_> =
                pairs.filter(|&[first, last]| problem.allows(first, last)).collect();
            let [first, last] = allowed[below(&mut rng, allowed.len())];
            let mut order = nearest_neighbours(&problem, [first, last]);

            let mut cuts = [0; 3].map(|_| rng.random_range(1..count));
            cuts.sort_unstable();
            let [i, j, l] = cuts;
            if i < j && j < l {
                let mut exchanged = order.clone();
                exchanged[i..l].rotate_left(j - i);
                let change = problem.cost(&exchanged) as i64 - problem.cost(&order) as i64;
                assert_eq!(exchange_change(&problem, &order, cuts), change);
            }
            if i < l {
                let mut reversed = order.clone();
                reversed[i..l].reverse();
                let change = problem.cost(&reversed) as i64 - problem.cost(&order) as i64;
                let sums = Sums::new(&problem, &order);
                assert_eq!(sums.reversal_change(&problem, &order, i, l), change);
            }

            let mut costs = vec![problem.cost(&order)];
            let control = Control::default();
            improve(&problem, &mut order, &control);
            costs.push(problem.cost(&order));
            perturb(&problem, &mut order, 10, 0, &mut rng, &control);
            costs.push(problem.cost(&order));
            assert!(costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
            assert_eq!((order[0], order[count - 1]), (first, last));
            let position = |tool: u8| order.iter().position(|&one| one == usize::from(tool));
            assert!(before.iter().all(|&(a, b)| position(a) < position(b)));
            order.sort_unstable();
            assert!(order.into_iter().eq(0..count));
        }
    }
}
