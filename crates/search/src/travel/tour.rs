//! A tour over all items, its reversals, and how to undo them.

use super::item::{Shape, Way};
use super::problem::{ARRIVAL, DEPARTURE, Problem, across, item_of};
use super::route::Visit;

/// A closed sequence of all items with the anchor, and the entry of each loop.
///
/// Positions are counted modulo the number of items.
pub(super) struct Tour<'p> {
    pub(super) problem: &'p Problem<'p>,
    /// For each position the end by which its item is entered.
    sequence: Vec<u32>,
    /// Position of each item.
    position: Vec<u32>,
    /// Point of each end.
    points: Vec<[f64; 2]>,
    /// Index of the entry of each loop; 0 for other items.
    entry: Vec<u32>,
    /// Position of the first item of each leaf; empty if each group has one item.
    starts: Vec<u32>,
    /// Changes since [`Tour::commit`].
    journal: Vec<Change>,
}

#[derive(Clone, Copy)]
enum Change {
    /// The items at `count` positions from `start` were reversed.
    Reversed { start: u32, count: u32 },
    /// A loop had this entry.
    Entered { item: u32, entry: u32 },
}

impl<'p> Tour<'p> {
    /// The tour that enters its items by these ends, one after the other, the loops at these
    /// entries.
    pub(super) fn new(problem: &'p Problem<'p>, sequence: Vec<u32>, entry: Vec<u32>) -> Self {
        debug_assert_eq!(sequence.len(), problem.count());
        let points = (0..problem.count()).flat_map(|item| {
            let entries = problem.entries(item);
            entries.map_or(problem.ends(item), |entries| [entries[entry[item] as usize]; 2])
        });
        let mut position = vec![0; problem.count()];
        for (index, &end) in sequence.iter().enumerate() {
            position[item_of(end)] = index as u32;
        }
        let mut tour = Self {
            problem,
            points: points.collect(),
            position,
            entry,
            starts: if problem.has_blocks { vec![0; problem.members.len()] } else { Vec::new() },
            journal: Vec::new(),
            sequence,
        };
        if problem.has_blocks {
            tour.find_starts(0, tour.count());
        }
        tour
    }

    /// Number of items with the anchor.
    #[inline]
    pub(super) fn count(&self) -> usize {
        self.sequence.len()
    }

    /// The position `steps` after another; `steps` is at most the number of items.
    #[inline]
    pub(super) fn after(&self, position: usize, steps: usize) -> usize {
        let sum = position + steps;
        if sum >= self.count() { sum - self.count() } else { sum }
    }

    /// Number of steps from one position forward to another.
    #[inline]
    pub(super) fn steps(&self, from: usize, to: usize) -> usize {
        if to >= from { to - from } else { to + self.count() - from }
    }

    /// The end by which the item at a position is entered.
    #[inline]
    pub(super) fn enters(&self, position: usize) -> u32 {
        self.sequence[position]
    }

    /// The end by which the item at a position is left.
    #[inline]
    pub(super) fn leaves(&self, position: usize) -> u32 {
        across(self.sequence[position])
    }

    #[inline]
    pub(super) fn position(&self, end: u32) -> usize {
        self.position[item_of(end)] as usize
    }

    /// Whether an item is entered by this end.
    #[inline]
    pub(super) fn is_entered(&self, end: u32) -> bool {
        self.sequence[self.position(end)] == end
    }

    /// The end that travel joins to this one.
    #[inline]
    pub(super) fn link(&self, end: u32) -> u32 {
        let position = self.position(end);
        if self.sequence[position] == end {
            self.leaves(if position == 0 { self.count() - 1 } else { position - 1 })
        } else {
            self.enters(self.after(position, 1))
        }
    }

    /// The **cut** at an end: the position before the travel that joins the end to another.
    #[inline]
    pub(super) fn cut(&self, end: u32) -> usize {
        let position = self.position(end);
        match (self.sequence[position] == end, position) {
            (false, _) => position,
            (true, 0) => self.count() - 1,
            (true, _) => position - 1,
        }
    }

    #[inline]
    pub(super) fn point(&self, end: u32) -> [f64; 2] {
        self.points[end as usize]
    }

    /// Cost of the travel between two ends, in mm.
    #[inline]
    pub(super) fn step(&self, end: u32, other: u32) -> f64 {
        self.problem.step(self.points[end as usize], self.points[other as usize])
    }

    /// Entry of a loop.
    #[inline]
    pub(super) fn entry(&self, item: usize) -> usize {
        self.entry[item] as usize
    }

    /// First position of a leaf; only if groups have several items.
    #[inline]
    pub(super) fn start(&self, leaf: usize) -> usize {
        self.starts[leaf] as usize
    }

    /// Cost of all travel, in mm.
    pub(super) fn length(&self) -> f64 {
        let step =
            |position| self.step(self.leaves(position), self.enters(self.after(position, 1)));
        (0..self.count()).map(step).sum()
    }

    /// Reverses the items at `count` positions from `start`.
    pub(super) fn reverse(&mut self, start: usize, count: usize) {
        self.journal.push(Change::Reversed { start: start as u32, count: count as u32 });
        self.apply_reversal(start, count);
    }

    fn apply_reversal(&mut self, start: usize, count: usize) {
        let (mut low, mut high) = (start, self.after(start, count - 1));
        for _ in 0..count / 2 {
            let (first, last) = (across(self.sequence[low]), across(self.sequence[high]));
            self.put(low, last);
            self.put(high, first);
            low = self.after(low, 1);
            high = if high == 0 { self.count() - 1 } else { high - 1 };
        }
        if count % 2 == 1 {
            self.sequence[low] ^= 1;
        }
        if self.problem.has_blocks {
            let leaf = |position: usize| self.problem.leaf[item_of(self.sequence[position])];
            if leaf(start) != leaf(self.after(start, count - 1)) {
                self.find_starts(start, count);
            }
        }
    }

    #[inline]
    fn put(&mut self, position: usize, end: u32) {
        self.sequence[position] = end;
        self.position[item_of(end)] = position as u32;
    }

    /// Finds where leaves start, among `count` positions from `start`, which hold whole leaves.
    fn find_starts(&mut self, start: usize, count: usize) {
        let leaf = &self.problem.leaf;
        let before = if start == 0 { self.count() - 1 } else { start - 1 };
        let mut previous = leaf[item_of(self.sequence[before])];
        let mut position = start;
        for _ in 0..count {
            let here = leaf[item_of(self.sequence[position])];
            if here != previous {
                self.starts[here as usize] = position as u32;
            }
            previous = here;
            position = self.after(position, 1);
        }
    }

    /// Chooses another entry of a loop.
    pub(super) fn enter(&mut self, item: usize, entry: usize) {
        self.journal.push(Change::Entered { item: item as u32, entry: self.entry[item] });
        self.apply_entry(item, entry as u32);
    }

    fn apply_entry(&mut self, item: usize, entry: u32) {
        let entries = self.problem.entries(item).expect("only loops have entries");
        self.entry[item] = entry;
        self.points[2 * item] = entries[entry as usize];
        self.points[2 * item + 1] = entries[entry as usize];
    }

    /// Keeps all changes so far.
    pub(super) fn commit(&mut self) {
        self.journal.clear();
    }

    /// Undoes all changes since the last commit.
    pub(super) fn undo(&mut self) {
        while let Some(change) = self.journal.pop() {
            match change {
                Change::Reversed { start, count } => {
                    self.apply_reversal(start as usize, count as usize);
                }
                Change::Entered { item, entry } => self.apply_entry(item as usize, entry),
            }
        }
    }

    /// The route from the anchor to itself.
    pub(super) fn visits(&self) -> Vec<Visit> {
        // If the tour enters the anchor where the route departs, the route follows the tour
        // backwards.
        let anchor = self.position(ARRIVAL);
        let is_backward = self.is_entered(DEPARTURE);
        let visit = |steps: usize| {
            let position =
                self.after(anchor, if is_backward { self.count() - steps } else { steps });
            let end = self.enters(position);
            let item = item_of(end) - 1;
            let way = match self.problem.items[item].shape {
                Shape::Loop { .. } => Way::Entry(self.entry(item + 1)),
                Shape::Bead { .. } if end.is_multiple_of(2) != is_backward => Way::Forward,
                Shape::Bead { .. } => Way::Backward,
            };
            Visit { item, way }
        };
        (1..self.count()).map(visit).collect()
    }
}
