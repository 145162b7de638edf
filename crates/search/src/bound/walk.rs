//! The bound by shortest walks through all zone components.
//!
//! The zone components that a piece passes through, in order, form a walk in the graph of zone
//! components, with a step for each crossing.
//! So the crossings of p pieces are at least the minimum total number of steps of p walks that
//! together visit all components.

use std::collections::VecDeque;

use crate::matching::ComponentGraph;

/// Maximum number of components for which walks are searched.
const MAX_COMPONENTS: u32 = 13;

/// Maximum number of states of the search.
const MAX_STATES: u64 = 1 << 18;

/// The minimum total number of steps of `pieces` walks that together visit all components.
/// `None` if there are more than [`MAX_COMPONENTS`] components or [`MAX_STATES`] states.
///
/// A breadth-first search over states of three parts: the number of walks begun, the set of
/// components visited, and the component where the present walk stands.
/// There are pieces * 2^components * components states.
pub(crate) fn min_steps(zones: &ComponentGraph, pieces: u32) -> Option<u32> {
    let count = zones.count();
    let states = |count: u32| (u64::from(pieces) * u64::from(count)) << count;
    if count > MAX_COMPONENTS || states(count) > MAX_STATES {
        return None;
    }
    let all = (1_usize << count) - 1;
    let index = |walks: u32, visited: usize, at: u32| {
        ((walks - 1) as usize * (all + 1) + visited) * count as usize + at as usize
    };
    let mut is_seen = vec![false; index(pieces + 1, 0, 0)];
    let mut queue: VecDeque<(u32, usize, u32, u32)> =
        (0..count).map(|at| (1, 1 << at, at, 0)).collect();
    while let Some((walks, visited, at, steps)) = queue.pop_front() {
        if visited == all {
            return Some(steps);
        }
        if std::mem::replace(&mut is_seen[index(walks, visited, at)], true) {
            continue;
        }
        // Beginning a walk takes no step, so it goes to the front: the queue stays sorted.
        if walks < pieces {
            for next in 0..count {
                queue.push_front((walks + 1, visited | 1 << next, next, steps));
            }
        }
        for &next in &zones.neighbours[at as usize] {
            queue.push_back((walks, visited | 1 << next, next, steps + 1));
        }
    }
    None
}
