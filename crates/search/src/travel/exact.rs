//! The cheapest route over few items, by the dynamic programme of Held and Karp, "A dynamic
//! programming approach to sequencing problems" (J. SIAM 10, 1962).

use super::item::{Shape, Way};
use super::problem::Problem;
use super::route::Visit;

/// Maximum number of items; each additional item doubles the time.
const MAX_ITEMS: usize = 8;
/// Maximum number of ways in which the items can be printed, in all; the time grows with its
/// square.
const MAX_WAYS: usize = 48;

/// A way of printing an item.
struct Choice {
    visit: Visit,
    ends: [[f64; 2]; 2],
    /// The items of the same group, as a set of bits.
    group: usize,
    /// The items that must come before this one.
    earlier: usize,
}

/// The cheapest route; `None` if the items are too many.
/// O(2^n w²) steps for n items that can be printed in w ways in all.
pub(super) fn cheapest(problem: &Problem<'_>) -> Option<Vec<Visit>> {
    let count = problem.items.len();
    if count > MAX_ITEMS {
        return None;
    }
    let choices = choices(problem)?;
    let all = (1 << count) - 1;
    let width = choices.len();
    // For each set of items and each last way: the cost of travel, and the way before the last.
    let mut best = vec![(f64::INFINITY, usize::MAX); (all + 1) * width];
    for (index, choice) in choices.iter().enumerate().filter(|(_, choice)| choice.earlier == 0) {
        let travel = problem.from.map_or(0.0, |from| problem.step(from, choice.ends[0]));
        best[(1 << choice.visit.item) * width + index] = (travel, usize::MAX);
    }
    for set in 1..all {
        for (last, choice) in choices.iter().enumerate() {
            let (travel, _) = best[set * width + last];
            if travel.is_infinite() {
                continue;
            }
            let is_complete = choice.group & !set == 0;
            for (index, next) in choices.iter().enumerate() {
                let bit = 1 << next.visit.item;
                let follows = set & bit == 0
                    && next.earlier & !set == 0
                    && (is_complete || choice.group == next.group);
                if follows {
                    let travel = travel + problem.step(choice.ends[1], next.ends[0]);
                    let known = &mut best[(set | bit) * width + index];
                    if travel < known.0 {
                        *known = (travel, last);
                    }
                }
            }
        }
    }
    let mut visits = Vec::with_capacity(count);
    let mut set = all;
    let ends =
        (0..width).min_by(|&a, &b| best[set * width + a].0.total_cmp(&best[set * width + b].0));
    let mut last = ends.unwrap_or(usize::MAX);
    while set != 0 {
        let visit = choices[last].visit;
        visits.push(visit);
        last = best[set * width + last].1;
        set &= !(1 << visit.item);
    }
    visits.reverse();
    Some(visits)
}

/// All ways of printing all items; `None` if there are too many.
fn choices(problem: &Problem<'_>) -> Option<Vec<Choice>> {
    let mut choices = Vec::new();
    let set = |holds: &dyn Fn(usize) -> bool| -> usize {
        (1..problem.count()).filter(|&item| holds(item)).map(|item| 1 << (item - 1)).sum()
    };
    for (index, item) in problem.items.iter().enumerate() {
        let (group, leaf) = (problem.group[index + 1], problem.leaf[index + 1]);
        let ways: Vec<Way> = match item.shape {
            Shape::Bead { reversible: true, .. } => vec![Way::Forward, Way::Backward],
            Shape::Bead { .. } => vec![Way::Forward],
            Shape::Loop { entries } if entries.len() <= MAX_WAYS => {
                (0..entries.len()).map(Way::Entry).collect()
            }
            Shape::Loop { .. } => return None,
        };
        for way in ways {
            let visit = Visit { item: index, way };
            choices.push(Choice {
                visit,
                ends: visit.ends(problem.items),
                group: set(&|other| problem.group[other] == group),
                earlier: set(&|other| problem.group[other] == group && problem.leaf[other] < leaf),
            });
        }
    }
    (choices.len() <= MAX_WAYS).then_some(choices)
}
