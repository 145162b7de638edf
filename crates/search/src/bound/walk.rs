//! The shortest walk through all zone components.

use std::collections::VecDeque;

use crate::matching::ZoneGraph;

/// Most components for which the walk is searched.
const MOST_COMPONENTS: u32 = 13;

const MOST_STATES: u64 = 1 << 18;

/// Crossings of p pieces are at least the steps of p walks in the graph of zone components that
/// visit all of them.
///
/// The components that a piece passes through, in order, are such a walk, a step for each crossing.
/// Breadth-first over (where, what was visited, walks begun): exact, in 2^components x components x
/// pieces states.
/// `None` for more components than [`MOST_COMPONENTS`] or more states than is worth while.
pub(crate) fn walk(graph: &ZoneGraph, pieces: u32) -> Option<u32> {
    let count = graph.count();
    let states = |count: u32| (u64::from(pieces) * u64::from(count)) << count;
    if count > MOST_COMPONENTS || states(count) > MOST_STATES {
        return None;
    }
    let all = (1_usize << count) - 1;
    let state = |walks: u32, visited: usize, at: u32| {
        ((walks - 1) as usize * (all + 1) + visited) * count as usize + at as usize
    };
    let mut seen = vec![false; state(pieces + 1, 0, 0)];
    let mut open: VecDeque<(u32, usize, u32, u32)> =
        (0..count).map(|at| (1, 1 << at, at, 0)).collect();
    while let Some((walks, visited, at, steps)) = open.pop_front() {
        if visited == all {
            return Some(steps);
        }
        if std::mem::replace(&mut seen[state(walks, visited, at)], true) {
            continue;
        }
        // A new walk takes no step, so it goes before what takes one.
        if walks < pieces {
            for next in 0..count {
                open.push_front((walks + 1, visited | 1 << next, next, steps));
            }
        }
        for &next in &graph.neighbours[at as usize] {
            open.push_back((walks, visited | 1 << next, next, steps + 1));
        }
    }
    None
}
