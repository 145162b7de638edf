//! Joins two sequences at their ends.

use super::bead::Position;
use super::sequence::{Part, Sequence};
use super::surroundings::Surroundings;

/// Maximum number of ways of a sequence.
pub(super) const MAX_WAYS: usize = 64;

/// Joins the end of `first` to the beginning of `second` by a step, if there is one.
///
/// The ways of the result are those in which the step is possible.
/// A sequence of loops alone can begin anywhere, not only in the ways listed for it, so new ways
/// are computed for it.
pub(super) fn merge(
    first: &Sequence,
    second: &Sequence,
    chains: &[[[f64; 2]; 2]],
    near: &Surroundings<'_>,
) -> Option<Sequence> {
    let ways = match (first.has_only_loops(), second.has_only_loops()) {
        (false, false) => meet(first, second, chains, near),
        (false, true) => continue_into(first, second, chains, near),
        (true, false) => {
            let reversed = continue_into(&second.reversed(), &first.reversed(), chains, near);
            reversed.into_iter().map(|way| way.into_iter().rev().collect()).collect()
        }
        (true, true) => begin_anywhere(first, second, near),
    };
    if ways.is_empty() {
        return None;
    }
    let parts = first.parts.iter().chain(&second.parts).copied().collect();
    Some(Sequence { parts, ways })
}

/// Ways in which two sequences meet that have fixed ways.
fn meet(
    first: &Sequence,
    second: &Sequence,
    chains: &[[[f64; 2]; 2]],
    near: &Surroundings<'_>,
) -> Vec<Vec<Position>> {
    let mut ways = Vec::new();
    for from in 0..first.ways.len() {
        for to in 0..second.ways.len() {
            let [end, start] = [first.end_mm(from, chains), second.start_mm(to, chains)];
            if ways.len() < MAX_WAYS && near.is_step(end, start) {
                ways.push([&first.ways[from][..], &second.ways[to]].concat());
            }
        }
    }
    ways
}

/// Ways in which a sequence with fixed ways continues into a sequence of loops.
fn continue_into(
    first: &Sequence,
    loops: &Sequence,
    chains: &[[[f64; 2]; 2]],
    near: &Surroundings<'_>,
) -> Vec<Vec<Position>> {
    let continued = |way: usize| {
        let mut positions = first.ways[way].clone();
        positions.extend(along(first.end_mm(way, chains), &loops.parts, near)?);
        Some(positions)
    };
    (0..first.ways.len()).filter_map(continued).collect()
}

/// Ways of two sequences of loops that are joined anywhere.
fn begin_anywhere(
    first: &Sequence,
    second: &Sequence,
    near: &Surroundings<'_>,
) -> Vec<Vec<Position>> {
    let Some(&Part::Loop(last)) = first.parts.last() else { return Vec::new() };
    let samples = near.samples(last);
    let before: Vec<Part> = first.parts[..first.parts.len() - 1].iter().rev().copied().collect();
    let way = |&sample: &Position| {
        let mut positions = along(sample.point_mm, &before, near)?;
        positions.reverse();
        positions.push(sample);
        positions.extend(along(sample.point_mm, &second.parts, near)?);
        Some(positions)
    };
    let ways: Vec<Vec<Position>> = samples.iter().filter_map(way).collect();
    // Few are enough, spread along the loop.
    let every = ways.len().div_ceil(MAX_WAYS).max(1);
    ways.into_iter().step_by(every).collect()
}

/// Where each of the loops begins if the first is entered from a point, and each other one from the
/// loop before: always at the nearest point.
fn along(from_mm: [f64; 2], loops: &[Part], near: &Surroundings<'_>) -> Option<Vec<Position>> {
    let mut here = from_mm;
    loops
        .iter()
        .map(|part| {
            let &Part::Loop(number) = part else { return None };
            let on_loop = near.nearest(number, here)?;
            here = on_loop.point_mm;
            Some(on_loop)
        })
        .collect()
}
