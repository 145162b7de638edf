//! Exchanges of two or three links of a tour, and whether the order of the items allows them.
//!
//! Cutting a tour at two or three positions leaves as many segments.
//! One of them, the longest or the one with the anchor, stays; the others are reversed, exchanged,
//! or both.

use super::problem::{Problem, item_of};
use super::tour::Tour;

/// Two or three links that are replaced by others.
///
/// Ends 0 and 1 are linked, as are 2 and 3, and 4 and 5 if `count` is 6. The exchange links ends 1
/// and 2, 3 and 4, and the last to the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange {
    pub(super) ends: [u32; 6],
    pub(super) count: usize,
}

/// Reversals of positions: first position and number of positions each.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reversals {
    pub(super) steps: [(u32, u32); 3],
    pub(super) count: usize,
}

impl Reversals {
    fn push(&mut self, start: usize, count: usize) {
        self.steps[self.count] = (start as u32, count as u32);
        self.count += 1;
    }

    /// The reversals in order.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.steps[..self.count].iter().map(|&(start, count)| (start as usize, count as usize))
    }
}

/// What may be moved between some cuts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    /// Whole groups.
    Groups,
    /// Items of this leaf.
    Leaf(u32),
    /// The leaves of one group may be reversed in place.
    Stages,
}

impl Exchange {
    pub(super) fn two(ends: [u32; 4]) -> Self {
        let [a, b, c, d] = ends;
        Self { ends: [a, b, c, d, 0, 0], count: 4 }
    }

    pub(super) fn three(ends: [u32; 6]) -> Self {
        Self { ends, count: 6 }
    }

    /// The ends that are linked in other ways afterwards.
    pub(super) fn ends(&self) -> &[u32] {
        &self.ends[..self.count]
    }

    /// The reversals that make this exchange; `None` if it does not result in a single tour, or in
    /// one that the order of the items forbids.
    pub(super) fn reversals(&self, tour: &Tour<'_>) -> Option<Reversals> {
        if self.count == 4 { self.reversals_of_two(tour) } else { self.reversals_of_three(tour) }
    }

    fn reversals_of_two(&self, tour: &Tour<'_>) -> Option<Reversals> {
        let cuts = [tour.cut(self.ends[0]), tour.cut(self.ends[2])];
        // A new link joins two ends by which items are left, or two by which they are entered.
        if cuts[0] == cuts[1] || tour.is_entered(self.ends[1]) != tour.is_entered(self.ends[2]) {
            return None;
        }
        let scope = scope(tour, &cuts)?;
        let [first, last] = in_order(tour, scope, cuts);
        let mut reversals = Reversals::default();
        reversals.push(tour.after(first, 1), tour.steps(first, last));
        keeps_directions(tour, scope, &reversals.steps[..1]).then_some(reversals)
    }

    fn reversals_of_three(&self, tour: &Tour<'_>) -> Option<Reversals> {
        let cuts = [tour.cut(self.ends[0]), tour.cut(self.ends[2]), tour.cut(self.ends[4])];
        if cuts[0] == cuts[1] || cuts[0] == cuts[2] || cuts[1] == cuts[2] {
            return None;
        }
        let scope = scope(tour, &cuts)?;
        let [first, middle, last] = in_order(tour, scope, cuts);
        // The tour consists of A, which stays, then B and C; A ends at the first cut.
        let partner = |end: u32| match self.ends.iter().position(|&other| other == end) {
            Some(index @ (0 | 5)) => self.ends[5 - index],
            Some(index) if index % 2 == 1 => self.ends[index + 1],
            Some(index) => self.ends[index - 1],
            None => unreachable!("the end is at a cut"),
        };
        let leaves = |cut: usize| tour.leaves(cut);
        let enters = |cut: usize| tour.enters(tour.after(cut, 1));
        let (b, c) = (tour.after(first, 1), tour.after(middle, 1));
        let (b_count, c_count) = (tour.steps(first, middle), tour.steps(middle, last));
        let c_moved = tour.after(first, 1);
        let b_moved = tour.after(c_moved, c_count);
        let mut reversals = Reversals::default();
        let both = b_count + c_count;
        let is_reversed: &[(u32, u32)];
        let segments = [(b as u32, b_count as u32), (c as u32, c_count as u32)];
        let after_a = partner(leaves(first));
        let before_a = partner(enters(last));
        if after_a == leaves(middle) && before_a == enters(middle) {
            // A, B reversed, C reversed.
            reversals.push(b, b_count);
            reversals.push(c, c_count);
            is_reversed = &segments;
        } else if scope == Scope::Stages {
            return None;
        } else if after_a == enters(middle) && before_a == leaves(middle) {
            // A, C, B.
            reversals.push(b, both);
            reversals.push(c_moved, c_count);
            reversals.push(b_moved, b_count);
            is_reversed = &[];
        } else if after_a == enters(middle) && before_a == enters(first) {
            // A, C, B reversed.
            reversals.push(b, both);
            reversals.push(c_moved, c_count);
            is_reversed = &segments[..1];
        } else if after_a == leaves(last) && before_a == leaves(middle) {
            // A, C reversed, B.
            reversals.push(b, both);
            reversals.push(b_moved, b_count);
            is_reversed = &segments[1..];
        } else {
            return None;
        }
        keeps_directions(tour, scope, is_reversed).then_some(reversals)
    }
}

/// What may be moved between the cuts; `None` if nothing.
fn scope(tour: &Tour<'_>, cuts: &[usize]) -> Option<Scope> {
    let problem = tour.problem;
    if !problem.has_blocks {
        return Some(Scope::Groups);
    }
    let leaves = |cut: usize| leaves_at(tour, cut);
    let group = |leaf: u32| problem.group[problem.members[leaf as usize][0] as usize];
    let is_between_groups = |cut: usize| {
        let [left, right] = leaves(cut);
        group(left) != group(right)
    };
    if cuts.iter().all(|&cut| is_between_groups(cut)) {
        return Some(Scope::Groups);
    }
    let shared = |leaf: &u32| cuts.iter().all(|&cut| leaves(cut).contains(leaf));
    if let Some(leaf) = leaves(cuts[0]).into_iter().find(shared) {
        return Some(Scope::Leaf(leaf));
    }
    are_stages(tour, cuts).then_some(Scope::Stages)
}

/// Leaves before and after a cut.
fn leaves_at(tour: &Tour<'_>, cut: usize) -> [u32; 2] {
    let leaf = |end: u32| tour.problem.leaf[item_of(end)];
    [leaf(tour.leaves(cut)), leaf(tour.enters(tour.after(cut, 1)))]
}

/// Whether three cuts are those around and between two successive leaves of a group.
fn are_stages(tour: &Tour<'_>, cuts: &[usize]) -> bool {
    let problem = tour.problem;
    // The cut between the leaves is that with a leaf in common with both others.
    let is_middle = |middle: usize| {
        let [left, right] = leaves_at(tour, cuts[middle]);
        let others = [cuts[(middle + 1) % 3], cuts[(middle + 2) % 3]];
        left != right
            && (others.map(|cut| leaves_at(tour, cut)) != [[left, right]; 2])
            && problem.group[problem.members[left as usize][0] as usize]
                == problem.group[problem.members[right as usize][0] as usize]
            && [[0, 1], [1, 0]].iter().any(|&[before, after]| {
                let before = leaves_at(tour, others[before]);
                let after = leaves_at(tour, others[after]);
                before[0] != left && before[1] == left && after[0] == right && after[1] != right
            })
    };
    cuts.len() == 3 && (0..3).any(is_middle)
}

/// The cuts in the order of the tour, so that the segment that stays is the one after the last.
fn in_order<const N: usize>(tour: &Tour<'_>, scope: Scope, mut cuts: [usize; N]) -> [usize; N] {
    if let Scope::Leaf(leaf) = scope {
        let before = tour.after(tour.start(leaf as usize), tour.count() - 1);
        cuts.sort_unstable_by_key(|&cut| tour.steps(before, cut));
        return cuts;
    }
    cuts.sort_unstable();
    // In the scope of stages, the segment with the anchor stays.
    let anchor = tour.position(0);
    let length = |index: usize| {
        let steps = tour.steps(cuts[(index + N - 1) % N], cuts[index]);
        let holds_anchor = tour.steps(tour.after(cuts[(index + N - 1) % N], 1), anchor) < steps;
        if scope == Scope::Stages && holds_anchor { usize::MAX } else { steps }
    };
    let longest = (0..N).max_by_key(|&index| (length(index), N - index)).unwrap_or(0);
    cuts.rotate_left(longest);
    cuts
}

/// Whether items that must keep their direction do so if these segments are reversed.
fn keeps_directions(tour: &Tour<'_>, scope: Scope, reversed: &[(u32, u32)]) -> bool {
    let problem: &Problem<'_> = tour.problem;
    if problem.is_directed.is_empty() {
        return true;
    }
    let within_leaf = scope != Scope::Groups;
    let fixed = if within_leaf { &problem.is_irreversible } else { &problem.is_directed };
    let mut count = 0;
    for &(start, length) in reversed {
        let mut position = start as usize;
        for _ in 0..length {
            count += usize::from(fixed[item_of(tour.enters(position))]);
            position = tour.after(position, 1);
        }
    }
    count == 0 || (!within_leaf && count == problem.directed)
}
