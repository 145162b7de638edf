//! Proven lower bound on the number of beads.

use super::candidates::Candidate;
use super::matching::maximum_matching;
use super::surroundings::Surroundings;
use crate::disjoint_sets::DisjointSets;

/// Lower bound on the number of beads of all loops and chains.
///
/// `candidates` has all joins of two chains, among others; `splices` says whether loops may be
/// spliced into chains.
pub(super) fn bound(
    chains: &[[[f64; 2]; 2]],
    candidates: &[Candidate],
    near_loops: &[[usize; 2]],
    splices: bool,
    near: &Surroundings<'_>,
) -> usize {
    let loops = near.loop_count();
    let mut components = DisjointSets::new(loops + chains.len());
    let mut unite = |a: usize, b: usize| _ = components.union(a as u32, b as u32);
    // Not only the steps found: two loops may come within reach of each other between samples, and
    // the nearest point of a loop may lie behind an outline when another one does not.
    near_loops.iter().for_each(|&[a, b]| unite(a, b));
    candidates.iter().for_each(|candidate| unite(candidate.elements[0], candidate.elements[1]));
    if splices {
        near.near_chains().iter().for_each(|&[ring, chain]| unite(ring, loops + chain));
    }
    let ends: Vec<[f64; 2]> = chains.as_flattened().to_vec();
    let near_ends: Vec<Vec<usize>> = ends.iter().map(|&end| near.loops_within(end)).collect();
    for (end, rings) in near_ends.iter().enumerate() {
        rings.iter().for_each(|&ring| unite(ring, loops + end / 2));
    }

    let mut meets_chain = vec![false; chains.len()];
    for [a, b] in candidates.iter().map(|candidate| candidate.elements) {
        if a >= loops {
            meets_chain[a - loops] = true;
            meets_chain[b - loops] = true;
        }
    }
    // An end of a chain that is joined to nothing is an end of a bead.
    // A loop has two sides, so at most two ends are joined to it.
    let sides = |end: usize| {
        let mut sides: Vec<usize> =
            near_ends[end].iter().flat_map(|&ring| [2 * ring, 2 * ring + 1]).collect();
        sides.sort_unstable();
        sides.dedup();
        sides
    };
    let edges: Vec<Vec<usize>> = (0..ends.len())
        .map(|end| if meets_chain[end / 2] { Vec::new() } else { sides(end) })
        .collect();
    let chosen = maximum_matching(&edges, 2 * loops);
    let mut free_ends = vec![0_usize; loops + chains.len()];
    for (end, chosen) in chosen.iter().enumerate() {
        if chosen.is_none() && !meets_chain[end / 2] {
            free_ends[components.find((loops + end / 2) as u32) as usize] += 1;
        }
    }
    let roots = (0..loops + chains.len())
        .filter(|&element| components.find(element as u32) as usize == element);
    roots.map(|root| free_ends[root].div_ceil(2).max(1)).sum()
}
