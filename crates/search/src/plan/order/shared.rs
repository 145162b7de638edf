//! One permutation of all tools that every layer follows.
//!
//! The permutation is built from its front, tool by tool.
//! Each layer uses the tools of the permutation that it needs, in that order, so placing a tool
//! adds costs to all layers that use it:
//!
//! - Within a layer: the change from the last placed tool of that layer.
//! - Between two layers: the change from the last tool of the lower one to the first tool of the
//!   upper one.
//!   It is known as soon as the lower layer is complete and the upper one has a tool.
//!
//! The costs of the remaining tools depend on little of the beginning of a permutation: which tools
//! are placed, the last one in each incomplete layer, and the first and last ones of layers whose
//! change to a neighbouring layer is not known yet.
//! These data are the **label** of the beginning.
//! Of all beginnings with the same label, only the cheapest can lead to the cheapest permutation.
//! So the search keeps one beginning for each label, and extends all of them by one tool at a time:
//! a dynamic programme whose states are the labels.
//!
//! Layers with the same set of tools make the same changes, so each different set, a **kind** of
//! layer, is handled once and its layers are counted.
//! The number of labels still grows exponentially in the worst case.
//! Beyond a limit the search is abandoned, and the result is the best permutation of a local search
//! that moves one tool at a time.

use std::collections::{BTreeMap, HashMap};

use beadwork_base::Control;

use super::check::Layers;
use super::constraints::{Constraints, OrderError};
use super::layered::Layered;
use crate::CostMatrix;

/// Maximum number of labels of a search, if there are few kinds of layers.
pub(super) const MAX_LABELS: usize = 1_000_000;

/// Maximum product of the number of labels and the number of kinds and pairs of kinds: the memory
/// and time for a label are proportional to the latter.
const MAX_WORK: usize = 16_000_000;

/// Maximum number of steps of a local search.
const MAX_STEPS: usize = 200_000_000;

/// No tool.
const NONE: u8 = u8::MAX;

/// The search was abandoned: it has too many labels, or was interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Abandoned;

/// Two kinds of layers, one of which lies directly on the other somewhere in the part.
struct Pair {
    lower: usize,
    upper: usize,
    /// Number of layers of the lower kind with one of the upper kind on top.
    times: u64,
}

/// What permutations need to know about the part.
/// Tools are addressed by their index among the used tools, sorted by number.
pub(super) struct Shared<'a> {
    costs: &'a CostMatrix,
    /// The number of each tool.
    pub(super) tools: Vec<u8>,
    /// The tools of each kind of layer.
    kinds: Vec<Vec<usize>>,
    /// The number of layers of each kind.
    times: Vec<u64>,
    pairs: Vec<Pair>,
    /// For each tool, the kinds of layers that use it.
    kinds_of: Vec<Vec<usize>>,
    /// For each tool, those that must come before it.
    earlier: Vec<Vec<usize>>,
    /// The kind of the first layer, and the cost of changing to each tool from the loaded one.
    begin: Option<(usize, Vec<u64>)>,
    /// Cost of a forbidden change: more than the sum of all others that a permutation can have.
    penalty: u64,
}

/// Finds a cheap permutation; returns it and whether it is proven to be the cheapest.
///
/// `layered` is the best plan found without one permutation, and `bound` a lower bound on its cost.
pub(super) fn shared(
    layers: &Layers,
    costs: &CostMatrix,
    constraints: &Constraints,
    layered: &Layered,
    bound: u64,
    max_labels: usize,
    control: &Control<'_>,
) -> Result<(Vec<u8>, bool), OrderError> {
    let part = Shared::new(layers, costs, constraints);
    let Some(rising) = part.sorted(&part.earlier, |tool| tool) else {
        return Err(part.contradiction(layers, constraints));
    };
    let numbers =
        |permutation: Vec<usize>| permutation.into_iter().map(|tool| part.tools[tool]).collect();
    // Often one permutation agrees with the best orders of all layers.
    if layered.cost == bound {
        let mut agreed = part.earlier.clone();
        for pair in layered.orders.iter().flat_map(|order| order.windows(2)) {
            agreed[part.index(pair[1])].push(part.index(pair[0]));
        }
        if let Some(permutation) = part.sorted(&agreed, |tool| tool) {
            return Ok((numbers(permutation), true));
        }
    }
    // Two starts for the local search: tools sorted by number, and by their mean positions in the
    // best orders.
    let means = part.mean_positions(layered);
    let by_means =
        part.sorted(&part.earlier, |tool| (means[tool], tool)).unwrap_or_else(|| rising.clone());
    let (cost, permutation) = [rising, by_means]
        .into_iter()
        .map(|start| part.improve(start, control))
        .min()
        .expect("there are two starts");
    if cost == bound {
        return Ok((numbers(permutation), true));
    }
    // A permutation with forbidden changes is not a result: the search must find a cheaper one.
    let is_feasible = cost < part.penalty;
    let max_labels = max_labels.min(MAX_WORK / (part.kinds.len() + part.pairs.len()));
    match part.search(cost.min(part.penalty), max_labels, control) {
        Ok(Some(cheaper)) => Ok((numbers(cheaper), true)),
        Ok(None) if is_feasible => Ok((numbers(permutation), true)),
        Err(Abandoned) if is_feasible => Ok((numbers(permutation), false)),
        Ok(None) | Err(Abandoned) => Err(OrderError::NoPermutation),
    }
}

impl<'a> Shared<'a> {
    pub(super) fn new(layers: &Layers, costs: &'a CostMatrix, constraints: &Constraints) -> Self {
        let mut tools = layers.kinds.concat();
        tools.sort_unstable();
        tools.dedup();
        let index = |tool: u8| tools.binary_search(&tool).ok();
        let kinds: Vec<Vec<usize>> = layers
            .kinds
            .iter()
            .map(|set| set.iter().filter_map(|&tool| index(tool)).collect())
            .collect();
        let mut times = vec![0; kinds.len()];
        layers.kind_of.iter().for_each(|&kind| times[kind] += 1);
        let mut pairs: BTreeMap<(usize, usize), u64> = BTreeMap::new();
        for pair in layers.kind_of.windows(2) {
            *pairs.entry((pair[0], pair[1])).or_default() += 1;
        }
        let pairs =
            pairs.into_iter().map(|((lower, upper), times)| Pair { lower, upper, times }).collect();
        let mut kinds_of = vec![Vec::new(); tools.len()];
        for (kind, set) in kinds.iter().enumerate() {
            set.iter().for_each(|&tool| kinds_of[tool].push(kind));
        }
        let mut earlier = vec![Vec::new(); tools.len()];
        for &(a, b) in &constraints.before {
            let (Some(a), Some(b)) = (index(a), index(b)) else { continue };
            // A pair of tools that no layer uses together imposes nothing.
            if kinds.iter().any(|set| set.contains(&a) && set.contains(&b)) {
                earlier[b].push(a);
            }
        }
        if let Some(first) = constraints.first.and_then(index) {
            let others = kinds[layers.kind_of[0]].iter().filter(|&&tool| tool != first);
            others.for_each(|&tool| earlier[tool].push(first));
        }
        let steps: u64 = layers.iter().map(|set| set.len() as u64).sum();
        let penalty = u64::from(costs.max_scaled()) * (steps + 1) + 1;
        let begin = layers.kind_of.first().zip(constraints.loaded);
        let begin = begin.map(|(&kind, loaded)| {
            let step = |&tool: &u8| costs.step(loaded, tool).min(penalty);
            (kind, tools.iter().map(step).collect())
        });
        Self { costs, tools, kinds, times, pairs, kinds_of, earlier, begin, penalty }
    }

    fn index(&self, tool: u8) -> usize {
        self.tools.binary_search(&tool).expect("a layer's tools have indices")
    }

    fn step(&self, from: usize, to: usize) -> u64 {
        self.costs.step(self.tools[from], self.tools[to]).min(self.penalty)
    }

    /// Cost of changing from the loaded tool, if `tool` is the first one of this kind of layer.
    fn begin(&self, kind: usize, tool: usize) -> u64 {
        match &self.begin {
            Some((first, steps)) if *first == kind => steps[tool],
            _ => 0,
        }
    }

    /// Sorts all tools topologically: each comes after those in `earlier`, and of several possible
    /// ones the one with the lowest `key` comes next.
    /// `None` if the constraints form a cycle.
    fn sorted<K: Ord>(
        &self,
        earlier: &[Vec<usize>],
        key: impl Fn(usize) -> K,
    ) -> Option<Vec<usize>> {
        let mut placed = vec![false; self.tools.len()];
        let mut order = Vec::with_capacity(self.tools.len());
        while order.len() < self.tools.len() {
            let ready = (0..self.tools.len())
                .filter(|&tool| !placed[tool] && earlier[tool].iter().all(|&other| placed[other]));
            let next = ready.min_by_key(|&tool| key(tool))?;
            placed[next] = true;
            order.push(next);
        }
        Some(order)
    }

    /// Why no permutation obeys all constraints, although the pairs alone form no cycle: some tool
    /// of the first layer must come before the one with which that layer must begin.
    fn contradiction(&self, layers: &Layers, constraints: &Constraints) -> OrderError {
        let first = constraints.first.expect("without a first tool there is no cycle");
        let start = self.index(first);
        let set = &self.kinds[layers.kind_of[0]];
        let mut seen = vec![start];
        let mut at = 0;
        while at < seen.len() {
            for &tool in &self.earlier[seen[at]] {
                if set.contains(&tool) && tool != start {
                    return OrderError::FirstContradicted { first, other: self.tools[tool] };
                }
                if !seen.contains(&tool) {
                    seen.push(tool);
                }
            }
            at += 1;
        }
        unreachable!("a cycle that the first tool closes contains another tool of its layer")
    }

    /// For each tool its mean position in the orders of the layers, in thousandths of an order.
    fn mean_positions(&self, layered: &Layered) -> Vec<usize> {
        let mut sums = vec![(0, 0); self.tools.len()];
        for order in &layered.orders {
            for (position, &tool) in order.iter().enumerate() {
                let (sum, count) = &mut sums[self.index(tool)];
                *sum += (2 * position + 1) * 500 / order.len();
                *count += 1;
            }
        }
        sums.into_iter().map(|(sum, count): (usize, usize)| sum / count.max(1)).collect()
    }

    /// Cost of a permutation; `None` if it breaks a constraint.
    fn cost(&self, permutation: &[usize]) -> Option<u64> {
        let mut placed = vec![false; self.tools.len()];
        // The first tool and the last one so far of each kind of layer.
        let mut ends: Vec<Option<(usize, usize)>> = vec![None; self.kinds.len()];
        let mut cost = 0_u64;
        for &tool in permutation {
            if !self.earlier[tool].iter().all(|&other| placed[other]) {
                return None;
            }
            placed[tool] = true;
            for &kind in &self.kinds_of[tool] {
                let added = match ends[kind] {
                    None => self.begin(kind, tool),
                    Some((_, last)) => self.times[kind].saturating_mul(self.step(last, tool)),
                };
                cost = cost.saturating_add(added);
                ends[kind] = Some((ends[kind].map_or(tool, |(first, _)| first), tool));
            }
        }
        for pair in &self.pairs {
            if let (Some((_, last)), Some((first, _))) = (ends[pair.lower], ends[pair.upper]) {
                cost = cost.saturating_add(pair.times.saturating_mul(self.step(last, first)));
            }
        }
        Some(cost)
    }

    /// Moves one tool at a time to a position where the permutation is cheaper, until there is no
    /// such move, or the limit of steps is reached.
    fn improve(&self, mut permutation: Vec<usize>, control: &Control<'_>) -> (u64, Vec<usize>) {
        let count = permutation.len();
        let size = count + self.pairs.len() + self.kinds.iter().map(Vec::len).sum::<usize>();
        let mut trials = MAX_STEPS / size.max(1);
        let mut best = self
            .cost(&permutation)
            .expect("a search starts from a permutation that obeys the constraints");
        // The number of successive moves that did not lower the cost.
        // The search ends when it reaches the number of all moves: the permutation is a local
        // optimum.
        let mut failed = 0;
        let mut number = 0;
        let moves = count * count;
        while failed < moves && trials > 0 {
            let (from, to) = (number / count, number % count);
            number = (number + 1) % moves;
            failed += 1;
            if from == to {
                continue;
            }
            trials -= 1;
            if trials.is_multiple_of(256) && control.interrupted().is_some() {
                break;
            }
            let tool = permutation.remove(from);
            permutation.insert(to, tool);
            match self.cost(&permutation) {
                Some(cost) if cost < best => {
                    best = cost;
                    failed = 0;
                }
                _ => {
                    let tool = permutation.remove(to);
                    permutation.insert(from, tool);
                }
            }
        }
        (best, permutation)
    }

    /// The cheapest permutation, if one costs less than `limit`; of equally cheap ones the
    /// lexicographically first.
    pub(super) fn search(
        &self,
        limit: u64,
        max_labels: usize,
        control: &Control<'_>,
    ) -> Result<Option<Vec<usize>>, Abandoned> {
        // The order of iteration over the map does not matter: of two beginnings with the same
        // label, the one with the smaller (cost, beginning) stays.
        let mut labels: HashMap<Label, (u64, Vec<u8>)> = HashMap::new();
        labels.insert(Label::new(self), (0, Vec::new()));
        let mut count = 0;
        for _ in 0..self.tools.len() {
            let mut longer: HashMap<Label, (u64, Vec<u8>)> = HashMap::new();
            for (label, (cost, beginning)) in &labels {
                if control.interrupted().is_some() {
                    return Err(Abandoned);
                }
                for tool in (0..self.tools.len()).filter(|&tool| !label.placed[tool]) {
                    if !self.earlier[tool].iter().all(|&other| label.placed[other]) {
                        continue;
                    }
                    let (next, step) = label.with(self, tool);
                    let cost = cost.saturating_add(step);
                    if cost >= limit {
                        continue;
                    }
                    let mut beginning = beginning.clone();
                    beginning.push(tool as u8);
                    let found = (cost, beginning);
                    let kept = longer.entry(next).or_insert_with(|| {
                        count += 1;
                        found.clone()
                    });
                    if found < *kept {
                        *kept = found;
                    }
                    if count > max_labels {
                        return Err(Abandoned);
                    }
                }
            }
            labels = longer;
        }
        let best = labels.into_values().min();
        Ok(best.map(|(_, permutation)| permutation.into_iter().map(usize::from).collect()))
    }
}

/// The state of a beginning of a permutation: everything that the costs of the remaining tools
/// depend on.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Label {
    placed: Vec<bool>,
    /// For each kind of layer: how many of its tools are placed, and the first and the last of
    /// them.
    /// The first or last is [`NONE`] once no cost depends on it any more, so that more beginnings
    /// have the same label.
    kinds: Vec<(u8, u8, u8)>,
}

impl Label {
    fn new(part: &Shared<'_>) -> Self {
        Self {
            placed: vec![false; part.tools.len()],
            kinds: vec![(0, NONE, NONE); part.kinds.len()],
        }
    }

    /// The label after placing one more tool, and the cost that this adds.
    fn with(&self, part: &Shared<'_>, tool: usize) -> (Self, u64) {
        let mut next = self.clone();
        next.placed[tool] = true;
        let mut cost = 0_u64;
        for &kind in &part.kinds_of[tool] {
            let (count, first, last) = &mut next.kinds[kind];
            if *count == 0 {
                *first = tool as u8;
                cost = cost.saturating_add(part.begin(kind, tool));
            } else {
                let step = part.step(usize::from(*last), tool);
                cost = cost.saturating_add(part.times[kind].saturating_mul(step));
            }
            *last = tool as u8;
            *count += 1;
        }
        let is_complete =
            |label: &Self, kind: usize| usize::from(label.kinds[kind].0) == part.kinds[kind].len();
        // The change between two layers is known once the last tool of the lower one and the first
        // tool of the upper one are.
        let is_known = |label: &Self, pair: &Pair| {
            is_complete(label, pair.lower) && label.kinds[pair.upper].0 > 0
        };
        // Whether the first and the last tool of each kind still matter.
        let mut matters = vec![(false, false); part.kinds.len()];
        for (kind, (_, last)) in matters.iter_mut().enumerate() {
            *last = !is_complete(&next, kind);
        }
        for pair in &part.pairs {
            if !is_known(&next, pair) {
                matters[pair.lower].1 = true;
                matters[pair.upper].0 = true;
            } else if !is_known(self, pair) {
                let (last, first) = (next.kinds[pair.lower].2, next.kinds[pair.upper].1);
                let step = part.step(usize::from(last), usize::from(first));
                cost = cost.saturating_add(pair.times.saturating_mul(step));
            }
        }
        for ((_, first, last), (first_matters, last_matters)) in next.kinds.iter_mut().zip(matters)
        {
            if !first_matters {
                *first = NONE;
            }
            if !last_matters {
                *last = NONE;
            }
        }
        (next, cost)
    }
}
