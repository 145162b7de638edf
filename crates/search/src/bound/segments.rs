//! Bounds by counting segments.
//!
//! A *segment* is a maximal stretch of a path inside one zone component.
//! If p pieces have s segments, they have s - p crossings.
//!
//! Both bounds take for each zone component a lower bound on its segments: 1, or a higher one from
//! the maximum 2-matching inside it ([`min_segments`](super::flow::min_segments)), because a
//! component of n cells with s segments has n - s links inside.

use crate::matching::ComponentGraph;

/// Lower bound on the crossings by the number of segments: segments minus pieces.
pub(crate) fn count(min_segments: &[u32], pieces: u32) -> u32 {
    min_segments.iter().sum::<u32>().saturating_sub(pieces)
}

/// Lower bound on the crossings where the graph of zone components falls apart when some
/// components, the *hubs*, are removed.
///
/// ```text
///   +-------------+
///   | A    B    C |    Islands A, B and C touch only the sea H.
///   |      H      |    Without the hub H they are three groups, so a path has to cross to H and
///   +-------------+    back between them.
/// ```
///
/// Proof: let the pieces visit a group in v >= 1 maximal stretches outside of the hubs.
/// The group has at least S segments, the sum over its components, and within the v stretches these
/// are joined by at least S - v crossings.
/// Each stretch has two ends.
/// At an end the path either crosses to a hub, or the piece ends; at most two ends for each piece
/// are of the latter kind.
/// So each group accounts for at least S - v + 2 v = S + v >= S + 1 crossings.
/// From the sum over all groups, 2 have to be subtracted for each piece.
/// In graph theory, the same argument bounds path covers by the scattering number or the toughness
/// of a graph (Chvatal 1973).
///
/// Any choice of hubs gives a bound.
/// This function tries each component alone and, for each k, all components with at least k
/// neighbours.
/// O(components * pairs of neighbours).
pub(crate) fn scattering(zones: &ComponentGraph, min_segments: &[u32], pieces: u32) -> u32 {
    let components = zones.count() as usize;
    let degree = |component: usize| zones.neighbours[component].len();
    let mut is_hub = vec![false; components];
    let mut best = sum_over_groups(zones, min_segments, &is_hub);
    for hub in (0..components).filter(|&hub| degree(hub) > 1) {
        is_hub[hub] = true;
        best = best.max(sum_over_groups(zones, min_segments, &is_hub));
        is_hub[hub] = false;
    }
    let mut degrees: Vec<usize> =
        (0..components).map(degree).filter(|&degree| degree > 1).collect();
    degrees.sort_unstable();
    degrees.dedup();
    for min_degree in degrees {
        let is_hub: Vec<bool> =
            (0..components).map(|component| degree(component) >= min_degree).collect();
        best = best.max(sum_over_groups(zones, min_segments, &is_hub));
    }
    best.saturating_sub(2 * pieces)
}

/// Sum of S + 1 over the groups that remain without the hubs, where S is the sum of the minimum
/// numbers of segments in the group.
fn sum_over_groups(zones: &ComponentGraph, min_segments: &[u32], is_hub: &[bool]) -> u32 {
    let mut is_seen = is_hub.to_vec();
    let mut stack = Vec::new();
    let mut sum = 0;
    for first in 0..min_segments.len() {
        if is_seen[first] {
            continue;
        }
        is_seen[first] = true;
        stack.push(first);
        sum += 1;
        while let Some(component) = stack.pop() {
            sum += min_segments[component];
            for &other in &zones.neighbours[component] {
                if !std::mem::replace(&mut is_seen[other as usize], true) {
                    stack.push(other as usize);
                }
            }
        }
    }
    sum
}
