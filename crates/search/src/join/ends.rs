//! Which loops and chains are joined end to end, and in which order.

use super::bead::Position;
use super::candidates::{
    Attachment, Candidate, attachment_candidates, chain_candidates, keep_nearest, loop_candidates,
};
use super::matching::maximum_matching;
use super::merge::merge;
use super::sequence::{Part, Sequence};
use super::surroundings::Surroundings;

/// The loops of an island, joined to each other where they are within reach all along.
pub(super) struct JoinedLoops {
    /// All joins that are possible for two loops alone.
    candidates: Vec<Candidate>,
    /// Together they contain every loop once.
    sequences: Vec<Sequence>,
}

/// What is joined first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    /// Loops that no chain reaches to others: joining them is not always better, because it may use
    /// up the ends that chains need.
    Loops,
    /// Ends of chains to sequences of loops, as many as possible.
    Ends,
    /// Chains to chains, directly or by a single loop in between.
    /// Other loops are left over, so this is better only if they are spliced.
    Chains,
}

impl JoinedLoops {
    pub(super) fn new(near: &Surroundings<'_>) -> Self {
        let mut candidates = loop_candidates(near);
        keep_nearest(&mut candidates);
        let loops = (0..near.loop_count()).map(|number| free_loop(number, near));
        let mut joiner = Joiner::new(near, &[], loops);
        for candidate in candidates.iter().filter(|candidate| candidate.is_everywhere) {
            joiner.join(candidate.elements);
        }
        let sequences = joiner.into_sequences();
        Self { candidates, sequences }
    }

    /// All joins of two loops, and of chains with these ends.
    pub(super) fn candidates(
        &self,
        chains: &[[[f64; 2]; 2]],
        attachments: &[Attachment],
        near: &Surroundings<'_>,
    ) -> Vec<Candidate> {
        let mut candidates = self.candidates.clone();
        candidates.extend(attachment_candidates(attachments, near.loop_count()));
        candidates.extend(chain_candidates(chains, near));
        keep_nearest(&mut candidates);
        candidates
    }

    /// Joins the loops and chains with these ends; `candidates` as returned by
    /// [`candidates`](Self::candidates).
    pub(super) fn join(
        &self,
        chains: &[[[f64; 2]; 2]],
        candidates: &[Candidate],
        first: First,
        near: &Surroundings<'_>,
    ) -> Vec<Sequence> {
        let loops = near.loop_count();
        let mut is_reached = vec![false; loops];
        for candidate in candidates.iter().filter(|candidate| candidate.elements[1] >= loops) {
            if let Some(is_reached) = is_reached.get_mut(candidate.elements[0]) {
                *is_reached = true;
            }
        }
        let is_spare = |candidate: &&Candidate| {
            let [a, b] = candidate.elements.map(|element| is_reached.get(element));
            matches!((a, b), (Some(a), Some(b)) if !(*a && *b))
        };
        let singles = (0..chains.len()).map(single_chain);
        let mut joiner = if first == First::Chains {
            let free = (0..loops).map(|number| free_loop(number, near));
            Joiner::new(near, chains, free.chain(singles))
        } else {
            let sequences = self.sequences.iter().flat_map(|sequence| clear(sequence, near));
            Joiner::new(near, chains, sequences.chain(singles))
        };
        match first {
            First::Loops => {
                candidates.iter().filter(is_spare).for_each(|spare| joiner.join(spare.elements));
                joiner.attach_chains(candidates);
            }
            First::Ends => joiner.attach_chains(candidates),
            First::Chains => {
                let with_chains = |count: usize| {
                    let is_chain = move |element: &&usize| **element >= loops;
                    candidates.iter().filter(move |candidate| {
                        candidate.elements.iter().filter(is_chain).count() == count
                    })
                };
                with_chains(2).for_each(|candidate| joiner.join(candidate.elements));
                with_chains(1).for_each(|candidate| joiner.join(candidate.elements));
            }
        }
        for candidate in candidates {
            joiner.join(candidate.elements);
        }
        joiner.into_sequences()
    }
}

/// A sequence of loops with the ways that are clear of chains too, or its loops if there are none.
fn clear(sequence: &Sequence, near: &Surroundings<'_>) -> Vec<Sequence> {
    let is_clear = |way: &&Vec<Position>| {
        way.windows(2).all(|pair| near.is_step(pair[0].point_mm, pair[1].point_mm))
    };
    let ways: Vec<_> = sequence.ways.iter().filter(is_clear).cloned().collect();
    if ways.is_empty() {
        let loops = sequence.parts.iter().filter_map(|part| match *part {
            Part::Loop(number) => Some(free_loop(number, near)),
            Part::Chain { .. } => None,
        });
        return loops.collect();
    }
    vec![Sequence { parts: sequence.parts.clone(), ways }]
}

/// A chain as a sequence.
fn single_chain(number: usize) -> Sequence {
    Sequence { parts: vec![Part::Chain { number, is_reversed: false }], ways: vec![Vec::new()] }
}

/// A loop as a sequence that can begin anywhere.
fn free_loop(number: usize, near: &Surroundings<'_>) -> Sequence {
    let ways = near.samples(number).iter().map(|&sample| vec![sample]).collect();
    Sequence { parts: vec![Part::Loop(number)], ways }
}

/// Sequences under construction.
struct Joiner<'a> {
    near: &'a Surroundings<'a>,
    /// Both ends of each chain.
    chains: &'a [[[f64; 2]; 2]],
    /// Sequences by number; `None` for those that became part of another.
    slots: Vec<Option<Sequence>>,
    /// The sequence of each element, loops before chains.
    sequence_of: Vec<usize>,
}

impl<'a> Joiner<'a> {
    /// These sequences, which contain every loop and chain once.
    fn new(
        near: &'a Surroundings<'a>,
        chains: &'a [[[f64; 2]; 2]],
        sequences: impl Iterator<Item = Sequence>,
    ) -> Self {
        let count = near.loop_count() + chains.len();
        let mut all = Self { near, chains, slots: Vec::new(), sequence_of: vec![0; count] };
        for sequence in sequences {
            for &part in &sequence.parts {
                let element = all.element(part);
                all.sequence_of[element] = all.slots.len();
            }
            all.slots.push(Some(sequence));
        }
        all
    }

    fn element(&self, part: Part) -> usize {
        match part {
            Part::Loop(number) => number,
            Part::Chain { number, .. } => self.near.loop_count() + number,
        }
    }

    fn sequence(&self, number: usize) -> &Sequence {
        self.slots[number].as_ref().expect("elements point to sequences that exist")
    }

    /// Joins the sequences of two elements at these elements, if possible.
    fn join(&mut self, elements: [usize; 2]) {
        let numbers = elements.map(|element| self.sequence_of[element]);
        if numbers[0] == numbers[1] {
            return;
        }
        if let Some(merged) = self.merged(elements) {
            self.replace(numbers, merged);
        }
    }

    /// The sequence that joins those of two elements; both elements must be at an end of their
    /// sequence.
    fn merged(&self, elements: [usize; 2]) -> Option<Sequence> {
        let [first, second] = elements.map(|element| self.sequence(self.sequence_of[element]));
        let is_at =
            |sequence: &Sequence, at: usize, element| self.element(sequence.parts[at]) == element;
        // A sequence of one element can be joined at both ends.
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

    fn replace(&mut self, numbers: [usize; 2], merged: Sequence) {
        for &part in &merged.parts {
            let element = self.element(part);
            self.sequence_of[element] = numbers[0];
        }
        self.slots[numbers[1]] = None;
        self.slots[numbers[0]] = Some(merged);
    }

    /// Joins as many ends of chains as possible to sequences of loops, one end to each sequence.
    fn attach_chains(&mut self, candidates: &[Candidate]) {
        let (loops, chains) = (self.near.loop_count(), self.chains.len());
        // One left vertex for each end of a chain, so a chain may be joined to two sequences.
        let mut edges: Vec<Vec<usize>> = vec![Vec::new(); 2 * chains];
        for candidate in candidates {
            let [ring, chain] = candidate.elements;
            if ring < loops && chain >= loops {
                for (end, is_reversed) in [(0, true), (1, false)] {
                    let number = chain - loops;
                    let chain = Sequence {
                        parts: vec![Part::Chain { number, is_reversed }],
                        ways: vec![Vec::new()],
                    };
                    let sequence = self.sequence(self.sequence_of[ring]);
                    let fits = |sequence: &Sequence| {
                        self.element(sequence.parts[0]) == ring
                            && merge(&chain, sequence, self.chains, self.near).is_some()
                    };
                    if fits(sequence) || fits(&sequence.reversed()) {
                        edges[2 * number + end].push(self.sequence_of[ring]);
                    }
                }
            }
        }
        let chosen = maximum_matching(&edges, self.slots.len());
        for (end, chosen) in chosen.into_iter().enumerate() {
            let Some(at) = chosen else { continue };
            let sequence = edges[end][at];
            let number = end / 2;
            // Joiner are still where they were: each is joined once, and keeps the chain's number.
            let chain = self.sequence_of[loops + number];
            self.attach(chain, number, end % 2 == 1, sequence);
        }
    }

    /// Joins a sequence of loops to one end of a chain.
    fn attach(
        &mut self,
        chain_sequence: usize,
        number: usize,
        is_last: bool,
        loop_sequence: usize,
    ) {
        let mut chain = self.sequence(chain_sequence).clone();
        // Turn it such that the chosen end of the chain is the end of its sequence.
        let is_turned = |sequence: &Sequence| {
            sequence.parts.last() == Some(&Part::Chain { number, is_reversed: !is_last })
        };
        if !is_turned(&chain) {
            chain = chain.reversed();
        }
        if !is_turned(&chain) {
            return;
        }
        let loops = self.sequence(loop_sequence);
        let merged = [loops.clone(), loops.reversed()]
            .iter()
            .find_map(|loops| merge(&chain, loops, self.chains, self.near));
        if let Some(merged) = merged {
            self.replace([chain_sequence, loop_sequence], merged);
        }
    }

    fn into_sequences(self) -> Vec<Sequence> {
        self.slots.into_iter().flatten().collect()
    }
}
