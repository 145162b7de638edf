//! Which loops and chains can be joined end to end.

use super::geometry::distance2;
use super::surroundings::Surroundings;

/// An end of a chain within a step of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// Number of the chain.
    pub chain: usize,
    /// Whether it is the last end of the chain.
    pub is_last: bool,
    /// Number of the loop.
    pub ring: usize,
    /// Length of the step to the loop in mm.
    pub length_mm: f64,
}

/// A possible join of two elements, loops before chains, with the square of its length.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub(super) elements: [usize; 2],
    pub(super) length2: f64,
    /// Whether two loops are within reach of each other all along one of them.
    pub(super) is_everywhere: bool,
}

/// All ends of chains that can be joined to the nearest point of a loop, sorted by chain, end and
/// loop.
pub(super) fn attachments(chains: &[[[f64; 2]; 2]], near: &Surroundings<'_>) -> Vec<Attachment> {
    let mut found = Vec::new();
    for (chain, ends) in chains.iter().enumerate() {
        for (&end, is_last) in ends.iter().zip([false, true]) {
            for (ring, on_loop) in near.loops_near(end) {
                let length_mm = distance2(end, on_loop.point_mm).sqrt();
                found.push(Attachment { chain, is_last, ring, length_mm });
            }
        }
    }
    found
}

/// The joins of chains and loops.
pub(super) fn attachment_candidates(
    attachments: &[Attachment],
    loop_count: usize,
) -> impl Iterator<Item = Candidate> {
    attachments.iter().map(move |attachment| Candidate {
        elements: [attachment.ring, loop_count + attachment.chain],
        length2: attachment.length_mm * attachment.length_mm,
        is_everywhere: false,
    })
}

/// All joins that are possible for two loops alone.
pub(super) fn loop_candidates(near: &Surroundings<'_>) -> Vec<Candidate> {
    let mut found = Vec::new();
    for from in 0..near.loop_count() {
        // For each loop within reach, at which distances.
        let mut within: Vec<(usize, f64)> = Vec::new();
        let samples = near.samples(from);
        for sample in samples {
            let others = near.loops_near(sample.point_mm);
            within.extend(
                others
                    .into_iter()
                    .filter(|other| other.0 != from)
                    .map(|(to, on_loop)| (to, distance2(sample.point_mm, on_loop.point_mm))),
            );
        }
        within.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        found.extend(within.chunk_by(|a, b| a.0 == b.0).map(|near| Candidate {
            elements: [from.min(near[0].0), from.max(near[0].0)],
            length2: near[0].1,
            is_everywhere: near.len() == samples.len(),
        }));
    }
    found
}

/// All joins that are possible for two chains alone.
pub(super) fn chain_candidates(
    chains: &[[[f64; 2]; 2]],
    near: &Surroundings<'_>,
) -> Vec<Candidate> {
    let numbered = chains.iter().enumerate();
    let ends = numbered.flat_map(|(number, ends)| ends.iter().map(move |&end| (number, end)));
    let mut by_x: Vec<(usize, [f64; 2])> = ends.collect();
    by_x.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]).then(a.0.cmp(&b.0)));
    let mut found = Vec::new();
    for (at, &(number, end)) in by_x.iter().enumerate() {
        let after = by_x[at + 1..].iter();
        for &(other, other_end) in
            after.take_while(|(_, other)| other[0] - end[0] <= near.reach_mm())
        {
            if other != number && near.is_step(end, other_end) {
                let loops = near.loop_count();
                let elements = [loops + number.min(other), loops + number.max(other)];
                let length2 = distance2(end, other_end);
                found.push(Candidate { elements, length2, is_everywhere: false });
            }
        }
    }
    found
}

/// Keeps the best join of each two elements, because [`merge`] finds where they can be joined, and
/// sorts them by length.
pub(super) fn keep_nearest(candidates: &mut Vec<Candidate>) {
    candidates.sort_by(|a, b| {
        let by_kind = a.elements.cmp(&b.elements).then(b.is_everywhere.cmp(&a.is_everywhere));
        by_kind.then(a.length2.total_cmp(&b.length2))
    });
    candidates.dedup_by_key(|candidate| candidate.elements);
    candidates.sort_by(|a, b| a.length2.total_cmp(&b.length2).then(a.elements.cmp(&b.elements)));
}
