//! The method: which beads are joined, and in which order.

use super::bead::{Bead, Part};
use super::geometry::distance2;
use super::matching::maximum_matching;
use super::merge::merge;
use super::surroundings::Surroundings;
use crate::disjoint_sets::DisjointSets;

/// Loops and chains of one island; coordinates are mm.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The corners of each closed loop; the last is joined to the first.
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
}

impl Default for Settings {
    /// 1 mm: two beads of 0.5 mm.
    fn default() -> Self {
        Self { max_step_mm: 1.0 }
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
    let count = input.loops.len() + input.chains.len();
    let is_valid = settings.max_step_mm > 0.0 && settings.max_step_mm.is_finite();
    if !is_valid || input.loops.iter().any(|ring| ring.is_empty()) {
        let beads = (0..count).map(|element| single(element, input)).collect();
        return Outcome { beads, bound: count };
    }
    let near = Surroundings::new(input, settings.max_step_mm);
    let candidates = candidates(input, settings.max_step_mm, &near);
    let mut components = DisjointSets::new(count);
    let steps = candidates.iter().map(|candidate| candidate.elements);
    let bound = count - steps.filter(|&[a, b]| components.union(a as u32, b as u32)).count();

    let mut beads = Beads::new(input, near);
    for candidate in candidates.iter().filter(|candidate| candidate.is_everywhere) {
        beads.join(candidate.elements);
    }
    beads.attach_chains(&candidates);
    for candidate in &candidates {
        beads.join(candidate.elements);
    }
    Outcome { beads: beads.into_beads(), bound }
}

/// All joins that are possible for two elements alone, nearest first.
fn candidates(input: &Input<'_>, reach_mm: f64, near: &Surroundings<'_>) -> Vec<Candidate> {
    let loops = input.loops.len();
    let mut found: Vec<Candidate> = Vec::new();
    for from in 0..loops {
        // For each loop within reach, how often and how near.
        let mut within: Vec<(usize, f64)> = Vec::new();
        let samples = near.samples(from);
        for sample in &samples {
            for (to, on_loop) in near.loops_near(sample.point_mm) {
                if to != from && near.is_step(sample.point_mm, on_loop.point_mm) {
                    within.push((to, distance2(sample.point_mm, on_loop.point_mm)));
                }
            }
        }
        within.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        found.extend(within.chunk_by(|a, b| a.0 == b.0).map(|near| Candidate {
            elements: [from.min(near[0].0), from.max(near[0].0)],
            length2: near[0].1,
            is_everywhere: near.len() == samples.len(),
        }));
    }
    let ends = || {
        let chains = input.chains.iter().enumerate();
        chains.flat_map(|(number, ends)| ends.iter().map(move |&end| (number, end)))
    };
    for (number, end) in ends() {
        for (to, on_loop) in near.loops_near(end) {
            if near.is_step(end, on_loop.point_mm) {
                let length2 = distance2(end, on_loop.point_mm);
                let elements = [to, loops + number];
                found.push(Candidate { elements, length2, is_everywhere: false });
            }
        }
    }
    let mut by_x: Vec<(usize, [f64; 2])> = ends().collect();
    by_x.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]).then(a.0.cmp(&b.0)));
    for (at, &(number, end)) in by_x.iter().enumerate() {
        let after = by_x[at + 1..].iter().take_while(|(_, other)| other[0] - end[0] <= reach_mm);
        for &(other, other_end) in after {
            if other != number && near.is_step(end, other_end) {
                let elements = [loops + number.min(other), loops + number.max(other)];
                let length2 = distance2(end, other_end);
                found.push(Candidate { elements, length2, is_everywhere: false });
            }
        }
    }
    // Of several joins of the same elements, one is enough: `merge` finds where.
    found.sort_by(|a, b| {
        let by_elements = a.elements.cmp(&b.elements);
        by_elements
            .then(b.is_everywhere.cmp(&a.is_everywhere))
            .then(a.length2.total_cmp(&b.length2))
    });
    found.dedup_by_key(|candidate| candidate.elements);
    found.sort_by(|a, b| a.length2.total_cmp(&b.length2).then(a.elements.cmp(&b.elements)));
    found
}

/// The bead of a single loop or chain.
fn single(element: usize, input: &Input<'_>) -> Bead {
    let (part, way) = match element.checked_sub(input.loops.len()) {
        None => (Part::Loop(element), Vec::new()),
        Some(number) => (Part::Chain { number, is_reversed: false }, Vec::new()),
    };
    Bead { parts: vec![part], ways: vec![way] }
}

/// Beads under construction.
struct Beads<'a> {
    input: &'a Input<'a>,
    near: Surroundings<'a>,
    /// Beads by number; `None` for those that became part of another.
    slots: Vec<Option<Bead>>,
    /// The bead of each element, loops before chains.
    bead_of: Vec<usize>,
}

impl<'a> Beads<'a> {
    fn new(input: &'a Input<'a>, near: Surroundings<'a>) -> Self {
        let count = input.loops.len() + input.chains.len();
        let mut slots: Vec<Option<Bead>> =
            (0..count).map(|element| Some(single(element, input))).collect();
        for (number, bead) in slots.iter_mut().take(input.loops.len()).enumerate() {
            let samples = near.samples(number);
            let ways = samples.into_iter().map(|sample| vec![sample]).collect();
            *bead = Some(Bead { parts: vec![Part::Loop(number)], ways });
        }
        Self { input, near, slots, bead_of: (0..count).collect() }
    }

    fn element(&self, part: Part) -> usize {
        match part {
            Part::Loop(number) => number,
            Part::Chain { number, .. } => self.input.loops.len() + number,
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
                let merged = is_joint.then(|| merge(first, second, self.input, &self.near));
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
        let (loops, chains) = (self.input.loops.len(), self.input.chains.len());
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
                            && merge(&chain, bead, self.input, &self.near).is_some()
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
            .find_map(|loops| merge(&chain, loops, self.input, &self.near));
        if let Some(merged) = merged {
            self.replace([chain_bead, loop_bead], merged);
        }
    }

    fn into_beads(self) -> Vec<Bead> {
        self.slots.into_iter().flatten().collect()
    }
}
