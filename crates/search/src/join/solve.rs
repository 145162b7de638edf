//! The method: which beads are joined, and in which order.

use super::bead::{Bead, OnLoop, Part};
use super::geometry::distance2;
use super::matching::maximum_matching;
use super::merge::merge;
use super::surroundings::Surroundings;
use crate::disjoint_sets::DisjointSets;

/// Loops and chains of one island; coordinates are mm.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The corners of each closed loop, at least one; the last is joined to the first.
    pub loops: &'a [&'a [[f64; 2]]],
    /// Both ends of each open chain.
    pub chains: &'a [[[f64; 2]; 2]],
    /// The rings of the outline, which steps do not cross.
    pub outline: &'a [&'a [[f64; 2]]],
}

/// Settings of [`solve`].
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Maximum length in mm of a step between two loops or chains.
    /// More than the distance between two insets; if it is not more than 0, nothing is joined.
    pub max_step_mm: f64,
    /// Distance in mm that steps keep from the outline, about half the width of a bead.
    /// A step whose ends are nearer to the outline must not come nearer than its ends.
    pub clearance_mm: f64,
}

impl Default for Settings {
    /// Steps of 1 mm, two beads of 0.5 mm, which may touch the outline.
    fn default() -> Self {
        Self { max_step_mm: 1.0, clearance_mm: 0.0 }
    }
}

/// Joined beads.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The beads; together they contain every loop and chain once.
    pub beads: Vec<Bead>,
    /// Proven lower bound on the number of beads.
    pub bound: usize,
}

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
struct Candidate {
    elements: [usize; 2],
    length2: f64,
    /// Whether two loops are within reach of each other all along one of them.
    is_everywhere: bool,
}

/// Joins the loops and chains of an island into few beads.
///
/// Takes about O(n log n) for n corners, as long as few of them lie within a step of each other.
pub fn solve(input: &Input<'_>, settings: &Settings) -> Outcome {
    Loops::new(input.loops, input.outline, settings).join(input.chains)
}

/// The loops of an island, prepared to be joined with different chains.
pub struct Loops<'a> {
    /// `None` if nothing is joined.
    near: Option<Surroundings<'a>>,
    rings: &'a [&'a [[f64; 2]]],
    /// All joins that are possible for two loops alone.
    candidates: Vec<Candidate>,
    /// Sequences of loops that are within reach of each other all along.
    sequences: Vec<Bead>,
    /// Pairs of loops with points within reach of each other, whatever lies between.
    near_pairs: Vec<[usize; 2]>,
}

impl<'a> Loops<'a> {
    /// Prepares the loops and the outline of an island; see [`Input`].
    pub fn new(loops: &'a [&'a [[f64; 2]]], outline: &[&[[f64; 2]]], settings: &Settings) -> Self {
        let is_valid = settings.max_step_mm > 0.0
            && settings.max_step_mm.is_finite()
            && settings.clearance_mm >= 0.0
            && settings.clearance_mm.is_finite()
            && loops.iter().all(|ring| !ring.is_empty());
        if !is_valid {
            return Self {
                near: None,
                rings: loops,
                candidates: Vec::new(),
                sequences: Vec::new(),
                near_pairs: Vec::new(),
            };
        }
        let near = Surroundings::new(loops, outline, settings.max_step_mm, settings.clearance_mm);
        let mut candidates = loop_candidates(&near);
        keep_nearest(&mut candidates);
        let mut beads =
            Beads::new(&near, &[], (0..loops.len()).map(|number| free_loop(number, &near)));
        for candidate in candidates.iter().filter(|candidate| candidate.is_everywhere) {
            beads.join(candidate.elements);
        }
        let sequences = beads.into_beads();
        let near_pairs = near.near_pairs();
        Self { near: Some(near), rings: loops, candidates, sequences, near_pairs }
    }

    /// All ends of chains that can be joined to the nearest point of a loop, for callers who choose
    /// the ends of their chains accordingly.
    ///
    /// Sorted by chain, end and loop.
    /// O(n) for n ends, as long as few edges lie within a step of each.
    pub fn attachments(&self, chains: &[[[f64; 2]; 2]]) -> Vec<Attachment> {
        let Some(near) = &self.near else { return Vec::new() };
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

    /// Joins the loops and these chains into few beads; see [`solve`].
    pub fn join(&self, chains: &[[[f64; 2]; 2]]) -> Outcome {
        let count = self.rings.len() + chains.len();
        let Some(near) = &self.near else {
            let beads = (0..self.rings.len()).map(|number| Bead {
                parts: vec![Part::Loop(number)],
                ways: vec![self.rings[number].iter().enumerate().take(1).map(on_corner).collect()],
            });
            let beads = beads.chain((0..chains.len()).map(single_chain)).collect();
            return Outcome { beads, bound: count };
        };
        let mut candidates = self.candidates.clone();
        let attachments = self.attachments(chains);
        candidates.extend(attachments.iter().map(|attachment| Candidate {
            elements: [attachment.ring, self.rings.len() + attachment.chain],
            length2: attachment.length_mm * attachment.length_mm,
            is_everywhere: false,
        }));
        candidates.extend(chain_candidates(chains, near));
        keep_nearest(&mut candidates);

        // Not only the steps found: two loops may come within reach of each other between samples,
        // and the nearest point of a loop may lie behind an outline when another one does not.
        let mut components = DisjointSets::new(count);
        let near_chains = chains.iter().enumerate().flat_map(|(chain, ends)| {
            let chain = self.rings.len() + chain;
            let near = ends.iter().flat_map(|&end| near.loops_within(end));
            near.map(move |ring| [ring, chain])
        });
        let steps = candidates.iter().map(|candidate| candidate.elements);
        let steps = steps.chain(self.near_pairs.iter().copied()).chain(near_chains);
        let united = steps.filter(|&[a, b]| components.union(a as u32, b as u32)).count();

        // Joining loops first is not always better: it may use up the ends that chains need.
        let mut is_reached = vec![false; self.rings.len()];
        attachments.iter().for_each(|attachment| is_reached[attachment.ring] = true);
        let is_spare = |candidate: &&Candidate| {
            let [a, b] = candidate.elements.map(|element| is_reached.get(element));
            matches!((a, b), (Some(a), Some(b)) if !(*a && *b))
        };
        let join = |loops_first: bool| {
            let singles = (0..chains.len()).map(single_chain);
            let all = self.sequences.iter().cloned().chain(singles);
            let mut beads = Beads::new(near, chains, all);
            if loops_first {
                for candidate in candidates.iter().filter(is_spare) {
                    beads.join(candidate.elements);
                }
            }
            beads.attach_chains(&candidates);
            for candidate in &candidates {
                beads.join(candidate.elements);
            }
            beads.into_beads()
        };
        let bound = count - united;
        let mut beads = join(true);
        if beads.len() > bound {
            let other = join(false);
            if other.len() < beads.len() {
                beads = other;
            }
        }
        Outcome { beads, bound }
    }
}

/// A corner of a loop.
fn on_corner((edge, &point_mm): (usize, &[f64; 2])) -> OnLoop {
    OnLoop { edge, point_mm }
}

/// A chain as a bead.
fn single_chain(number: usize) -> Bead {
    Bead { parts: vec![Part::Chain { number, is_reversed: false }], ways: vec![Vec::new()] }
}

/// A loop as a bead that can begin anywhere.
fn free_loop(number: usize, near: &Surroundings<'_>) -> Bead {
    let ways = near.samples(number).iter().map(|&sample| vec![sample]).collect();
    Bead { parts: vec![Part::Loop(number)], ways }
}

/// All joins that are possible for two loops alone.
fn loop_candidates(near: &Surroundings<'_>) -> Vec<Candidate> {
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
fn chain_candidates(chains: &[[[f64; 2]; 2]], near: &Surroundings<'_>) -> Vec<Candidate> {
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
fn keep_nearest(candidates: &mut Vec<Candidate>) {
    candidates.sort_by(|a, b| {
        let by_kind = a.elements.cmp(&b.elements).then(b.is_everywhere.cmp(&a.is_everywhere));
        by_kind.then(a.length2.total_cmp(&b.length2))
    });
    candidates.dedup_by_key(|candidate| candidate.elements);
    candidates.sort_by(|a, b| a.length2.total_cmp(&b.length2).then(a.elements.cmp(&b.elements)));
}

/// Beads under construction.
struct Beads<'a> {
    near: &'a Surroundings<'a>,
    /// Both ends of each chain.
    chains: &'a [[[f64; 2]; 2]],
    /// Beads by number; `None` for those that became part of another.
    slots: Vec<Option<Bead>>,
    /// The bead of each element, loops before chains.
    bead_of: Vec<usize>,
}

impl<'a> Beads<'a> {
    /// These beads, which contain every loop and chain once.
    fn new(
        near: &'a Surroundings<'a>,
        chains: &'a [[[f64; 2]; 2]],
        beads: impl Iterator<Item = Bead>,
    ) -> Self {
        let count = near.loop_count() + chains.len();
        let mut all = Self { near, chains, slots: Vec::new(), bead_of: vec![0; count] };
        for bead in beads {
            for &part in &bead.parts {
                let element = all.element(part);
                all.bead_of[element] = all.slots.len();
            }
            all.slots.push(Some(bead));
        }
        all
    }

    fn element(&self, part: Part) -> usize {
        match part {
            Part::Loop(number) => number,
            Part::Chain { number, .. } => self.near.loop_count() + number,
        }
    }

    fn bead(&self, number: usize) -> &Bead {
        self.slots[number].as_ref().expect("elements point to beads that exist")
    }

    /// Joins the beads of two elements at these elements, if possible.
    fn join(&mut self, elements: [usize; 2]) {
        let numbers = elements.map(|element| self.bead_of[element]);
        if numbers[0] == numbers[1] {
            return;
        }
        if let Some(merged) = self.merged(elements) {
            self.replace(numbers, merged);
        }
    }

    /// The bead that joins those of two elements; both elements must be at an end of their bead.
    fn merged(&self, elements: [usize; 2]) -> Option<Bead> {
        let [first, second] = elements.map(|element| self.bead(self.bead_of[element]));
        let is_at = |bead: &Bead, at: usize, element| self.element(bead.parts[at]) == element;
        // A bead of one element can be joined at both ends.
        let firsts = [first.clone(), first.reversed()];
        let seconds = [second.clone(), second.reversed()];
        for first in &firsts {
            for second in &seconds {
                let is_joint = is_at(first, first.parts.len() - 1, elements[0])
                    && is_at(second, 0, elements[1]);
                let merged = is_joint.then(|| merge(first, second, self.chains, self.near));
                if let Some(merged) = merged.flatten() {
                    return Some(merged);
                }
            }
        }
        None
    }

    fn replace(&mut self, numbers: [usize; 2], merged: Bead) {
        for &part in &merged.parts {
            let element = self.element(part);
            self.bead_of[element] = numbers[0];
        }
        self.slots[numbers[1]] = None;
        self.slots[numbers[0]] = Some(merged);
    }

    /// Joins as many ends of chains as possible to beads of loops, one end to each bead.
    fn attach_chains(&mut self, candidates: &[Candidate]) {
        let (loops, chains) = (self.near.loop_count(), self.chains.len());
        // One left vertex for each end of a chain, so a chain may be joined to two beads.
        let mut edges: Vec<Vec<usize>> = vec![Vec::new(); 2 * chains];
        for candidate in candidates {
            let [ring, chain] = candidate.elements;
            if ring < loops && chain >= loops {
                for (end, is_reversed) in [(0, true), (1, false)] {
                    let number = chain - loops;
                    let chain = Bead {
                        parts: vec![Part::Chain { number, is_reversed }],
                        ways: vec![Vec::new()],
                    };
                    let bead = self.bead(self.bead_of[ring]);
                    let fits = |bead: &Bead| {
                        self.element(bead.parts[0]) == ring
                            && merge(&chain, bead, self.chains, self.near).is_some()
                    };
                    if fits(bead) || fits(&bead.reversed()) {
                        edges[2 * number + end].push(self.bead_of[ring]);
                    }
                }
            }
        }
        let chosen = maximum_matching(&edges, self.slots.len());
        for (end, chosen) in chosen.into_iter().enumerate() {
            let Some(at) = chosen else { continue };
            let bead = edges[end][at];
            let number = end / 2;
            // Beads are still where they were: each is joined once, and keeps the chain's number.
            let chain = self.bead_of[loops + number];
            self.attach(chain, number, end % 2 == 1, bead);
        }
    }

    /// Joins a bead of loops to one end of a chain.
    fn attach(&mut self, chain_bead: usize, number: usize, is_last: bool, loop_bead: usize) {
        let mut chain = self.bead(chain_bead).clone();
        // Turn it such that the chosen end of the chain is the end of its bead.
        let is_turned =
            |bead: &Bead| bead.parts.last() == Some(&Part::Chain { number, is_reversed: !is_last });
        if !is_turned(&chain) {
            chain = chain.reversed();
        }
        if !is_turned(&chain) {
            return;
        }
        let loops = self.bead(loop_bead);
        let merged = [loops.clone(), loops.reversed()]
            .iter()
            .find_map(|loops| merge(&chain, loops, self.chains, self.near));
        if let Some(merged) = merged {
            self.replace([chain_bead, loop_bead], merged);
        }
    }

    fn into_beads(self) -> Vec<Bead> {
        self.slots.into_iter().flatten().collect()
    }
}
