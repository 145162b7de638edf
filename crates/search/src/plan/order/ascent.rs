//! Lower bounds on Hamiltonian paths by Lagrangian relaxation, after Held and Karp, "The
//! traveling-salesman problem and minimum spanning trees" (Operations Research 18, 1970).
//!
//! A path from its first tool to its last one is a spanning arborescence in which every tool but
//! the last has exactly one outgoing arc.
//! Without the condition on outgoing arcs, the cheapest arborescence is a lower bound, but often a
//! weak one, since it branches at tools that are cheap to change from.
//!
//! So a **multiplier** is added to all arcs that leave a tool, and subtracted again once.
//! A path uses each of these tools once and costs the same as before, so the minimum is a lower
//! bound for any multipliers.
//! Raising the multipliers of tools with several outgoing arcs, and lowering those of tools with
//! none, makes the arborescence more like a path, and the bound better: a subgradient method.
//!
//! Weights and multipliers are integers, in fractions of a unit, so the bounds are exact.

use super::arborescence::{self, NO_ARC};
use super::problem::Problem;
use super::within::NEVER;

/// Number of parts into which a unit of cost is divided.
const PARTS: i64 = 64;

/// Lower bounds on the paths of one set of tools.
pub(super) struct Ascent {
    /// Added to the arcs that leave each tool; those of the last bound that was computed.
    multipliers: Vec<i64>,
}

impl Ascent {
    pub(super) fn new(problem: &Problem) -> Self {
        Self { multipliers: vec![0; problem.count] }
    }

    /// A lower bound on the cost of all paths from `first` to `last`, from at most `iterations`
    /// arborescences; [`NEVER`] if there is no path without forbidden changes.
    ///
    /// `known` is the cost of some path, which limits the length of the steps.
    /// The multipliers start from those of the previous call, so that similar problems take few
    /// iterations.
    pub(super) fn bound(
        &mut self,
        problem: &Problem,
        [first, last]: [usize; 2],
        known: u64,
        iterations: usize,
    ) -> u64 {
        if problem.count == 1 {
            return 0;
        }
        let known = known as i64 * PARTS;
        let mut best = i64::MIN;
        let mut best_multipliers = self.multipliers.clone();
        let mut length = 1.0;
        let mut failed = 0;
        for _ in 0..iterations {
            let weight = |from, to| arc(problem, [first, last], &self.multipliers, from, to);
            let tree = arborescence::minimum(problem.count, first, weight);
            let constant: i64 = sum_without(&self.multipliers, last);
            let bound = tree.weight - constant;
            if bound > best {
                best = bound;
                best_multipliers.clone_from(&self.multipliers);
                failed = 0;
            } else {
                failed += 1;
                if failed == 5 {
                    failed = 0;
                    length /= 2.0;
                }
            }
            // The number of outgoing arcs of each tool minus the 1 that a path has; 0 for the last
            // tool.
            let mut excess = vec![-1_i64; problem.count];
            excess[last] = 0;
            for to in (0..problem.count).filter(|&to| to != first) {
                excess[tree.parent[to]] += 1;
            }
            let norm: i64 = excess.iter().map(|excess| excess * excess).sum();
            if norm == 0 || best >= known {
                break;
            }
            // If the known path has forbidden changes, its cost is far above the optimum, so the
            // distance is also limited by the size of the bound and of the costs.
            let distance =
                (known - bound).min(bound.abs() / 10 + PARTS * problem.max_step() as i64);
            let step = length * distance as f64 / norm as f64;
            for (multiplier, excess) in self.multipliers.iter_mut().zip(&excess) {
                *multiplier += (step * *excess as f64).round() as i64;
            }
        }
        self.multipliers = best_multipliers;
        round_up(problem, best)
    }

    /// Lower bounds for all pairs of a first and a last tool, at `first * count + last`, from the
    /// present multipliers: each tool but the first takes its cheapest incoming arc.
    /// O(k³) steps for k tools.
    pub(super) fn bounds_of_all(&self, problem: &Problem) -> Vec<u64> {
        let count = problem.count;
        // The two cheapest arcs into each tool, regardless of the ends of the path.
        // Two are enough, because the choice of ends excludes at most one arc into a tool that is
        // not the first.
        let cheapest = |to: usize| {
            let mut best = [(NO_ARC, usize::MAX); 2];
            let from = (0..count).filter(|&from| is_possible(problem, from, to));
            for from in from {
                let arc = (weight(problem, &self.multipliers, from, to), from);
                if arc < best[0] {
                    best = [arc, best[0]];
                } else if arc < best[1] {
                    best[1] = arc;
                }
            }
            best
        };
        let cheapest: Vec<_> = (0..count).map(cheapest).collect();
        let bound = |pair: usize| {
            let (first, last) = (pair / count, pair % count);
            if !problem.allows(first, last) {
                return NEVER;
            }
            if count == 1 {
                return 0;
            }
            let into = |to: usize| {
                // No arc leaves the last tool, and the first leads to the last only in a path of
                // two tools.
                let excluded = if to != last {
                    last
                } else if count > 2 {
                    first
                } else {
                    last
                };
                let [best, second] = cheapest[to];
                if best.1 == excluded { second.0 } else { best.0 }
            };
            let sum = (0..count).filter(|&to| to != first).map(into).fold(0, i64::saturating_add);
            round_up(problem, sum.saturating_sub(sum_without(&self.multipliers, last)))
        };
        (0..count * count).map(bound).collect()
    }
}

/// Whether a path can have the arc between its ends.
#[inline]
fn is_possible(problem: &Problem, from: usize, to: usize) -> bool {
    from != to && !problem.earlier[from].contains(to)
}

/// Weight of an arc, in parts.
#[inline]
fn weight(problem: &Problem, multipliers: &[i64], from: usize, to: usize) -> i64 {
    PARTS * problem.step(from, to) as i64 + multipliers[from]
}

/// Weight of an arc of a path with these ends, in parts; [`NO_ARC`] where no such path has it.
#[inline]
fn arc(
    problem: &Problem,
    [first, last]: [usize; 2],
    multipliers: &[i64],
    from: usize,
    to: usize,
) -> i64 {
    let fits_ends =
        from != last && to != first && (from != first || to != last || problem.count == 2);
    if fits_ends && is_possible(problem, from, to) {
        weight(problem, multipliers, from, to)
    } else {
        NO_ARC
    }
}

fn sum_without(multipliers: &[i64], last: usize) -> i64 {
    multipliers.iter().sum::<i64>() - multipliers[last]
}

/// The smallest cost that is not below a bound in parts; [`NEVER`] if no path costs as much.
fn round_up(problem: &Problem, bound: i64) -> u64 {
    let cost = bound.max(0) as u64;
    let cost = cost.div_ceil(PARTS as u64);
    let max_cost = (problem.count as u64 - 1) * problem.max_step();
    if cost > max_cost { NEVER } else { cost }
}
