//! The nearest-neighbour tour, with which the search starts.

use super::item::Shape;
use super::kd_tree::KdTree;
use super::problem::{ARRIVAL, Problem, across, item_of};
use super::route::distance;

/// Maximum number of entries of a loop that spatial indices hold.
const SAMPLES: usize = 16;

/// Points of an item for a spatial index, with their ends: both ends of a bead, or evenly chosen
/// entries of a loop with its first end.
pub(super) fn samples(problem: &Problem<'_>, item: u32) -> Vec<([f64; 2], u32)> {
    let start = 2 * item;
    match problem.entries(item as usize) {
        None => problem.ends(item as usize).into_iter().zip([start, across(start)]).collect(),
        Some(entries) => {
            let count = entries.len().min(SAMPLES);
            let chosen = (0..count).map(|sample| sample * entries.len() / count);
            chosen.map(|entry| (entries[entry], start)).collect()
        }
    }
}

/// Points at which items can begin, which are removed key by key.
struct Pool {
    tree: KdTree<u32>,
    /// Indices of the points, sorted by key.
    indices: Vec<u32>,
    /// For each key the first of its indices, and at the end their number.
    offsets: Vec<u32>,
}

impl Pool {
    fn new(
        problem: &Problem<'_>,
        items: impl Iterator<Item = u32>,
        keys: usize,
        key: impl Fn(u32) -> usize,
    ) -> Self {
        let can_begin =
            |&(_, end): &([f64; 2], u32)| end % 2 == 0 || !problem.is_irreversible[item_of(end)];
        let points = items.flat_map(|item| samples(problem, item)).filter(can_begin);
        let tree = KdTree::new(points.collect());
        let key_of = |end: u32| key(end / 2);
        let mut offsets = vec![0; keys + 1];
        tree.iter().for_each(|(_, end)| offsets[key_of(end) + 1] += 1);
        for key in 0..keys {
            offsets[key + 1] += offsets[key];
        }
        let mut next = offsets.clone();
        let mut indices = vec![0; offsets[keys] as usize];
        for (index, end) in tree.iter() {
            let next = &mut next[key_of(end)];
            indices[*next as usize] = index as u32;
            *next += 1;
        }
        Self { tree, indices, offsets }
    }

    fn remove(&mut self, key: usize) {
        for &index in &self.indices[self.offsets[key] as usize..self.offsets[key + 1] as usize] {
            self.tree.remove(index as usize);
        }
    }
}

/// The tour that goes from each item to the nearest one that may follow.
pub(super) struct Nearest<'p> {
    problem: &'p Problem<'p>,
    position: [f64; 2],
    /// Ends by which the items are entered, in order.
    pub(super) sequence: Vec<u32>,
    /// Entry of each loop; 0 for other items.
    pub(super) entry: Vec<u32>,
}

impl<'p> Nearest<'p> {
    /// Finds the tour in O(n log n) expected steps for n items.
    pub(super) fn new(problem: &'p Problem<'p>) -> Self {
        let groups = problem.first_leaf.len() - 1;
        let first_items = problem.first_leaf[1..groups.max(1)].iter().flat_map(|&leaf| {
            let members = &problem.members[leaf as usize];
            members.iter().copied()
        });
        let mut pool =
            Pool::new(problem, first_items, groups, |item| problem.group[item as usize] as usize);
        let start = problem.first_leaf.get(1).and_then(|&leaf| problem.members.get(leaf as usize));
        let start = start.map(|members| problem.ends(members[0] as usize)[0]);
        let mut tour = Self {
            problem,
            position: problem.from.or(start).unwrap_or_default(),
            sequence: vec![ARRIVAL],
            entry: vec![0; problem.count()],
        };
        while let Some((_, end)) = pool.tree.nearest(tour.position) {
            let group = problem.group[item_of(end)] as usize;
            pool.remove(group);
            for leaf in problem.first_leaf[group]..problem.first_leaf[group + 1] {
                tour.add_leaf(leaf as usize);
            }
        }
        tour
    }

    fn add_leaf(&mut self, leaf: usize) {
        let members = &self.problem.members[leaf];
        let mut pool = Pool::new(self.problem, members.iter().copied(), members.len(), |item| {
            members.binary_search(&item).expect("the pool holds members")
        });
        while let Some((_, end)) = pool.tree.nearest(self.position) {
            pool.remove(members.binary_search(&(end / 2)).expect("the pool holds members"));
            self.add(end);
        }
    }

    fn add(&mut self, end: u32) {
        let item = item_of(end);
        self.sequence.push(end);
        self.position = match self.problem.items[item - 1].shape {
            Shape::Bead { .. } => self.problem.ends(item)[usize::from(end.is_multiple_of(2))],
            Shape::Loop { entries } => {
                let lengths = entries.iter().map(|&entry| distance(self.position, entry));
                let nearest = lengths.enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b));
                let entry = nearest.map_or(0, |(entry, _)| entry);
                self.entry[item] = entry as u32;
                entries[entry]
            }
        };
    }
}
