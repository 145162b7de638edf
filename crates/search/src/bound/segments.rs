//! Bounds from counting segments: the stretches of a path inside one zone component.

use crate::matching::ZoneGraph;

/// Segments of all components minus pieces: p pieces with s segments have s - p crossings.
///
/// `need` is a lower bound of the segments in each component: 1, or what a maximum 2-matching
/// inside it says, for a component of n cells with s segments has n - s links inside.
pub(crate) fn cover(need: &[u32], pieces: u32) -> u32 {
    need.iter().sum::<u32>().saturating_sub(pieces)
}

/// Takes some components, hubs, away and counts the groups into which the others fall.
///
/// Let the pieces visit a group in s stretches, at least 1. Its segments, at least the sum P of
/// their need, are joined by P - s crossings inside the group or more.
/// Every stretch has two ends; of all these, all but two for each piece go to a hub by a crossing.
/// So the crossings are at least the sum over the groups of P + s, hence of P + 1, minus twice the
/// pieces.
/// This is how toughness bounds path covers (Chvatal 1973).
///
/// Tried as hubs: each component alone, and all components that touch at least so many others, for
/// every such number; any choice gives a bound.
/// O(components x touching pairs).
pub(crate) fn scattering(graph: &ZoneGraph, need: &[u32], pieces: u32) -> u32 {
    let count = graph.count() as usize;
    let degree = |component: usize| graph.neighbours[component].len();
    let mut is_hub = vec![false; count];
    let mut best = groups(graph, need, &is_hub);
    for hub in (0..count).filter(|&hub| degree(hub) > 1) {
        is_hub[hub] = true;
        best = best.max(groups(graph, need, &is_hub));
        is_hub[hub] = false;
    }
    let mut degrees: Vec<usize> = (0..count).map(degree).filter(|&degree| degree > 1).collect();
    degrees.sort_unstable();
    degrees.dedup();
    for least in degrees {
        let is_hub: Vec<bool> = (0..count).map(|component| degree(component) >= least).collect();
        best = best.max(groups(graph, need, &is_hub));
    }
    best.saturating_sub(2 * pieces)
}

/// Sum of the need and 1 over the groups that are left without the hubs.
fn groups(graph: &ZoneGraph, need: &[u32], is_hub: &[bool]) -> u32 {
    let mut seen = is_hub.to_vec();
    let mut open = Vec::new();
    let mut sum = 0;
    for first in 0..need.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        open.push(first);
        sum += 1;
        while let Some(component) = open.pop() {
            sum += need[component];
            for &other in &graph.neighbours[component] {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    open.push(other as usize);
                }
            }
        }
    }
    sum
}
