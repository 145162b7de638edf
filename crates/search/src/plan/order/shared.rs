//! One permutation of all tools that every layer follows.
//!
//! Built from the front, tool by tool.
//! What the tools placed so far mean for the rest is little: which they are, the last one of each
//! kind of layer that is not yet complete, and of those that follow each other the ends that still
//! wait for the other.
//! Of all beginnings that agree in that (a **label**) only the cheapest matters.

use std::collections::{BTreeMap, HashMap};

use super::check::Layers;
use super::free::Free;
use super::{Constraints, OrderError, ToolCosts};

/// The most labels of a search, where layers are of few kinds.
pub(super) const MOST_LABELS: usize = 1_000_000;

/// Labels times kinds of layers and pairs of them: longer labels take more memory and time each.
const MOST_WORK: usize = 16_000_000;

/// Steps of the search by moves: beyond, it keeps what it has.
const MOST_STEPS: usize = 200_000_000;

/// No tool.
const NONE: u8 = u8::MAX;

/// A search ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooManyLabels;

/// Two kinds of layers that follow each other.
struct Pair {
    before: usize,
    after: usize,
    times: u64,
}

/// The part as permutations see it.
/// Tools are numbered anew, by rising number, without those that no layer uses.
pub(super) struct Shared<'a> {
    costs: &'a ToolCosts,
    pub(super) tools: Vec<u8>,
    /// The tools of each kind of layer.
    kinds: Vec<Vec<usize>>,
    /// How many layers are of each kind.
    times: Vec<u64>,
    pairs: Vec<Pair>,
    /// For each tool, the kinds that use it.
    kinds_of: Vec<Vec<usize>>,
    /// For each tool, those that must come before it.
    earlier: Vec<Vec<usize>>,
}

/// The cheapest permutation found, and whether it is proven to be the cheapest.
/// `free` is the best plan without one.
pub(super) fn shared(
    layers: &Layers,
    costs: &ToolCosts,
    constraints: &Constraints,
    free: &Free,
    most_labels: usize,
) -> Result<(Vec<u8>, bool), OrderError> {
    let part = Shared::new(layers, costs, constraints);
    let Some(rising) = part.sorted(&part.earlier, |tool| tool) else {
        return Err(part.contradiction(layers, constraints));
    };
    let name =
        |permutation: Vec<usize>| permutation.into_iter().map(|tool| part.tools[tool]).collect();
    // Often the best orders of the layers already agree.
    let mut agreed = part.earlier.clone();
    for pair in free.orders.iter().flat_map(|order| order.windows(2)) {
        agreed[part.number(pair[1])].push(part.number(pair[0]));
    }
    if let Some(permutation) = part.sorted(&agreed, |tool| tool) {
        return Ok((name(permutation), true));
    }
    let means = part.mean_places(free);
    let alike =
        part.sorted(&part.earlier, |tool| (means[tool], tool)).unwrap_or_else(|| rising.clone());
    let (cost, permutation) = [rising, alike]
        .into_iter()
        .map(|start| part.improve(start))
        .min()
        .expect("there are two starts");
    if cost == free.cost {
        return Ok((name(permutation), true));
    }
    let most_labels = most_labels.min(MOST_WORK / (part.kinds.len() + part.pairs.len()));
    Ok(match part.search(cost, most_labels) {
        Ok(Some(cheaper)) => (name(cheaper), true),
        Ok(None) => (name(permutation), true),
        Err(TooManyLabels) => (name(permutation), false),
    })
}

impl<'a> Shared<'a> {
    pub(super) fn new(layers: &Layers, costs: &'a ToolCosts, constraints: &Constraints) -> Self {
        let mut tools = layers.kinds.concat();
        tools.sort_unstable();
        tools.dedup();
        let number = |tool: u8| tools.binary_search(&tool).ok();
        let kinds: Vec<Vec<usize>> = layers
            .kinds
            .iter()
            .map(|set| set.iter().filter_map(|&tool| number(tool)).collect())
            .collect();
        let mut times = vec![0; kinds.len()];
        layers.kind_of.iter().for_each(|&kind| times[kind] += 1);
        let mut pairs: BTreeMap<(usize, usize), u64> = BTreeMap::new();
        for pair in layers.kind_of.windows(2) {
            *pairs.entry((pair[0], pair[1])).or_default() += 1;
        }
        let pairs = pairs
            .into_iter()
            .map(|((before, after), times)| Pair { before, after, times })
            .collect();
        let mut kinds_of = vec![Vec::new(); tools.len()];
        for (kind, set) in kinds.iter().enumerate() {
            set.iter().for_each(|&tool| kinds_of[tool].push(kind));
        }
        let mut earlier = vec![Vec::new(); tools.len()];
        for &(a, b) in &constraints.before {
            let (Some(a), Some(b)) = (number(a), number(b)) else { continue };
            // Tools that never meet in a layer are free.
            if kinds.iter().any(|set| set.contains(&a) && set.contains(&b)) {
                earlier[b].push(a);
            }
        }
        if let Some(first) = constraints.first.and_then(number) {
            let others = kinds[layers.kind_of[0]].iter().filter(|&&tool| tool != first);
            others.for_each(|&tool| earlier[tool].push(first));
        }
        Self { costs, tools, kinds, times, pairs, kinds_of, earlier }
    }

    fn number(&self, tool: u8) -> usize {
        self.tools.binary_search(&tool).expect("a layer's tools are numbered")
    }

    fn step(&self, from: usize, to: usize) -> u64 {
        u64::from(self.costs.cost(self.tools[from], self.tools[to]))
    }

    /// All tools, each after those that must come earlier, otherwise by rising `key`; `None` if
    /// they go round in a circle.
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

    /// Why no permutation obeys all pairs, which alone make no circle: one of the first layer's
    /// tools must come before its first.
    fn contradiction(&self, layers: &Layers, constraints: &Constraints) -> OrderError {
        let first = constraints.first.expect("without a first tool there is no circle");
        let start = self.number(first);
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
        unreachable!("a circle that the first tool closes goes through its layer's others")
    }

    /// For each tool its mean place in the orders of the layers, in thousandths of a layer.
    fn mean_places(&self, free: &Free) -> Vec<usize> {
        let mut sums = vec![(0, 0); self.tools.len()];
        for order in &free.orders {
            for (place, &tool) in order.iter().enumerate() {
                let (sum, count) = &mut sums[self.number(tool)];
                *sum += (2 * place + 1) * 500 / order.len();
                *count += 1;
            }
        }
        sums.into_iter().map(|(sum, count): (usize, usize)| sum / count.max(1)).collect()
    }

    /// Cost of a permutation; `None` if it breaks a constraint.
    fn cost(&self, permutation: &[usize]) -> Option<u64> {
        let mut placed = vec![false; self.tools.len()];
        let mut ends: Vec<Option<(usize, usize)>> = vec![None; self.kinds.len()];
        let mut cost = 0;
        for &tool in permutation {
            if !self.earlier[tool].iter().all(|&other| placed[other]) {
                return None;
            }
            placed[tool] = true;
            for &kind in &self.kinds_of[tool] {
                let (first, last) = ends[kind].unwrap_or((tool, tool));
                cost += self.times[kind] * self.step(last, tool);
                ends[kind] = Some((first, tool));
            }
        }
        for pair in &self.pairs {
            if let (Some((_, last)), Some((first, _))) = (ends[pair.before], ends[pair.after]) {
                cost += pair.times * self.step(last, first);
            }
        }
        Some(cost)
    }

    /// Moves one tool at a time to where it is cheaper, until no such move is left.
    fn improve(&self, mut permutation: Vec<usize>) -> (u64, Vec<usize>) {
        let count = permutation.len();
        let size = count + self.pairs.len() + self.kinds.iter().map(Vec::len).sum::<usize>();
        let mut trials = MOST_STEPS / size.max(1);
        let mut best = self.cost(&permutation).expect("a search starts from what is allowed");
        // How many moves in turn were no better: with all of them tried, there is none.
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

    /// The cheapest permutation, if one costs less than `limit`.
    pub(super) fn search(
        &self,
        limit: u64,
        most_labels: usize,
    ) -> Result<Option<Vec<usize>>, TooManyLabels> {
        // The map's own order never matters: of two beginnings with one label the lesser (cost,
        // beginning) stays.
        let mut labels: HashMap<Label, (u64, Vec<u8>)> = HashMap::new();
        labels.insert(Label::new(self), (0, Vec::new()));
        let mut count = 0;
        for _ in 0..self.tools.len() {
            let mut longer: HashMap<Label, (u64, Vec<u8>)> = HashMap::new();
            for (label, (cost, beginning)) in &labels {
                for tool in (0..self.tools.len()).filter(|&tool| !label.placed[tool]) {
                    if !self.earlier[tool].iter().all(|&other| label.placed[other]) {
                        continue;
                    }
                    let (next, step) = label.with(self, tool);
                    let cost = cost + step;
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
                    if count > most_labels {
                        return Err(TooManyLabels);
                    }
                }
            }
            labels = longer;
        }
        let best = labels.into_values().min();
        Ok(best.map(|(_, permutation)| permutation.into_iter().map(usize::from).collect()))
    }
}

/// What a beginning of a permutation means for the rest of it.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Label {
    placed: Vec<bool>,
    /// For each kind of layer: how many of its tools are placed, the first and the last of them.
    /// Ends that nothing waits for are forgotten, so that more beginnings agree.
    kinds: Vec<(u8, u8, u8)>,
}

impl Label {
    fn new(part: &Shared<'_>) -> Self {
        Self {
            placed: vec![false; part.tools.len()],
            kinds: vec![(0, NONE, NONE); part.kinds.len()],
        }
    }

    /// With one more tool, and what that adds to the cost.
    fn with(&self, part: &Shared<'_>, tool: usize) -> (Self, u64) {
        let mut next = self.clone();
        next.placed[tool] = true;
        let mut cost = 0;
        for &kind in &part.kinds_of[tool] {
            let (count, first, last) = &mut next.kinds[kind];
            if *count == 0 {
                *first = tool as u8;
            } else {
                cost += part.times[kind] * part.step(usize::from(*last), tool);
            }
            *last = tool as u8;
            *count += 1;
        }
        let is_complete =
            |label: &Self, kind: usize| usize::from(label.kinds[kind].0) == part.kinds[kind].len();
        let is_due = |label: &Self, pair: &Pair| {
            is_complete(label, pair.before) && label.kinds[pair.after].0 > 0
        };
        // Which ends something still waits for.
        let mut wanted = vec![(false, false); part.kinds.len()];
        for (kind, (_, last)) in wanted.iter_mut().enumerate() {
            *last = !is_complete(&next, kind);
        }
        for pair in &part.pairs {
            if !is_due(&next, pair) {
                wanted[pair.before].1 = true;
                wanted[pair.after].0 = true;
            } else if !is_due(self, pair) {
                let (last, first) = (next.kinds[pair.before].2, next.kinds[pair.after].1);
                cost += pair.times * part.step(usize::from(last), usize::from(first));
            }
        }
        for ((_, first, last), (first_wanted, last_wanted)) in next.kinds.iter_mut().zip(wanted) {
            if !first_wanted {
                *first = NONE;
            }
            if !last_wanted {
                *last = NONE;
            }
        }
        (next, cost)
    }
}
