//! Local search: exchanges of two and three links, and other entries of loops.
//!
//! An exchange cuts a link, joins one of its ends to a near end, cuts the link there, and so on; it
//! is continued only while the cut links are longer than the new ones, after Lin and Kernighan, "An
//! effective heuristic algorithm for the traveling-salesman problem" (Operations Research 21,
//! 1973).
//! Three links include all that is known as 2-opt and Or-opt, with segments of any length.
//!
//! Only ends whose surroundings have changed are examined ("don't look bits", Bentley, "Fast
//! algorithms for geometric traveling salesman problems", ORSA Journal on Computing 4, 1992).

use std::collections::VecDeque;

use super::exchange::{Exchange, Reversals};
use super::neighbours::Neighbours;
use super::problem::{ARRIVAL, DEPARTURE, across, item_of};
use super::tour::Tour;

/// Maximum number of ends of an adjacent leaf that are tried at its border.
const ACROSS_BORDER: usize = 8;

/// A tour that is being shortened.
pub(super) struct LocalSearch<'p> {
    pub(super) tour: Tour<'p>,
    neighbours: &'p Neighbours,
    /// Ends to examine.
    queue: VecDeque<u32>,
    is_queued: Vec<bool>,
    /// Candidates of a first and a second new link, if they have to be collected.
    buffers: [Vec<u32>; 2],
}

impl<'p> LocalSearch<'p> {
    pub(super) fn new(tour: Tour<'p>, neighbours: &'p Neighbours) -> Self {
        let ends = 2 * tour.count();
        Self {
            tour,
            neighbours,
            queue: VecDeque::with_capacity(ends),
            is_queued: vec![false; ends],
            buffers: [Vec::new(), Vec::new()],
        }
    }

    /// Marks an end as one to examine.
    pub(super) fn push(&mut self, end: u32) {
        if !std::mem::replace(&mut self.is_queued[end as usize], true) {
            self.queue.push_back(end);
        }
    }

    /// Marks all ends in the order of the tour.
    pub(super) fn push_all(&mut self) {
        for position in 0..self.tour.count() {
            self.push(self.tour.enters(position));
            self.push(self.tour.leaves(position));
        }
    }

    /// Shortens the tour until no marked end allows it; returns the length that was gained, in mm.
    pub(super) fn run(&mut self, stops: impl Fn() -> bool) -> f64 {
        let mut gained = 0.0;
        let mut examined = 0_u32;
        while let Some(end) = self.queue.pop_front() {
            self.is_queued[end as usize] = false;
            loop {
                let gain = self.improve(end);
                if gain <= 0.0 {
                    break;
                }
                gained += gain;
            }
            examined += 1;
            if examined.is_multiple_of(1024) && stops() {
                break;
            }
        }
        gained
    }

    /// Discards all marks.
    pub(super) fn clear(&mut self) {
        while let Some(end) = self.queue.pop_front() {
            self.is_queued[end as usize] = false;
        }
    }

    /// Makes the best exchange that cuts the link at this end; returns its gain, 0 if there is
    /// none.
    fn improve(&mut self, end: u32) -> f64 {
        let gain = self.improve_entry(end);
        if gain > 0.0 {
            return gain;
        }
        let [mut first, mut second] = std::mem::take(&mut self.buffers);
        let best = self.best_exchange(end, &mut first, &mut second);
        self.buffers = [first, second];
        let Some((gain, exchange, reversals)) = best else { return 0.0 };
        let is_checked = cfg!(test) && self.tour.count() <= 50;
        let before = if is_checked { self.tour.length() } else { 0.0 };
        for (start, count) in reversals.iter() {
            self.tour.reverse(start, count);
        }
        // Tests compare the gain of every exchange in small tours with a sum over the tour.
        if is_checked {
            let gained = before - self.tour.length();
            assert!((gained - gain).abs() <= 1e-9 * (1.0 + before), "gain {gain}, really {gained}");
        }
        exchange.ends().iter().for_each(|&end| self.push(end));
        gain
    }

    /// Moves the entry of a loop to where the detour is shortest; returns the gain.
    fn improve_entry(&mut self, end: u32) -> f64 {
        let item = item_of(end);
        let problem = self.tour.problem;
        let Some(entries @ [_, _, ..]) = problem.entries(item) else { return 0.0 };
        let links = [end, across(end)].map(|end| self.tour.link(end));
        let [before, after] = links.map(|link| self.tour.point(link));
        let detours =
            entries.iter().map(|&entry| problem.step(before, entry) + problem.step(entry, after));
        let present = self.tour.step(links[0], end) + self.tour.step(end, links[1]);
        let (entry, detour) = detours
            .enumerate()
            .fold((0, f64::INFINITY), |best, other| if other.1 < best.1 { other } else { best });
        let gain = present - detour;
        if gain <= self.tour.problem.tolerance {
            return 0.0;
        }
        self.tour.enter(item, entry);
        [links[0], links[1], end, across(end)].into_iter().for_each(|end| self.push(end));
        gain
    }

    fn best_exchange(
        &self,
        end: u32,
        first: &mut Vec<u32>,
        second: &mut Vec<u32>,
    ) -> Option<(f64, Exchange, Reversals)> {
        let tour = &self.tour;
        let tolerance = tour.problem.tolerance;
        let mut best: Option<(f64, Exchange, Reversals)> = None;
        let mut best_gain = tolerance;
        let a = end;
        let b = tour.link(a);
        let cut_first = tour.step(a, b);
        if cut_first <= tolerance {
            return None;
        }
        for &c in self.candidates(b, a, cut_first, first) {
            let saved = cut_first - tour.step(b, c);
            if saved <= tolerance || c == a {
                continue;
            }
            let d = tour.link(c);
            let saved = saved + tour.step(c, d);
            let gain = saved - tour.step(d, a);
            if gain > best_gain {
                let exchange = Exchange::two([a, b, c, d]);
                if let Some(reversals) = exchange.reversals(tour) {
                    best = Some((gain, exchange, reversals));
                    best_gain = gain;
                }
            }
            for &e in self.candidates(d, c, saved, second) {
                let saved = saved - tour.step(d, e);
                if saved <= tolerance || e == c || e == a || e == b {
                    continue;
                }
                let f = tour.link(e);
                let gain = saved + tour.step(e, f) - tour.step(f, a);
                if gain > best_gain {
                    let exchange = Exchange::three([a, b, c, d, e, f]);
                    if let Some(reversals) = exchange.reversals(tour) {
                        best = Some((gain, exchange, reversals));
                        best_gain = gain;
                    }
                }
            }
        }
        best
    }

    /// Ends that may be joined to an end whose present link is cut, among them all that are near
    /// enough; the new link should be shorter than `limit`, in mm.
    fn candidates<'b>(
        &'b self,
        end: u32,
        link: u32,
        limit: f64,
        buffer: &'b mut Vec<u32>,
    ) -> impl Iterator<Item = &'b u32> {
        let problem = self.tour.problem;
        buffer.clear();
        let near = self.neighbours.of_end(end);
        if problem.has_blocks {
            self.add_candidates(end, link, limit, buffer);
        } else if item_of(end) != 0 {
            buffer.push(ARRIVAL);
            if problem.from.is_none() {
                buffer.push(DEPARTURE);
            }
        }
        near.iter().chain(buffer.iter())
    }

    /// Adds candidates at the borders of leaves and groups.
    fn add_candidates(&self, end: u32, link: u32, limit: f64, buffer: &mut Vec<u32>) {
        let tour = &self.tour;
        let problem = tour.problem;
        let [group, other_group] = [end, link].map(|end| problem.group[item_of(end)]);
        let other_leaf = problem.leaf[item_of(link)];
        if problem.leaf[item_of(end)] == other_leaf {
            return;
        }
        if other_leaf != 0 {
            let members = &problem.members[other_leaf as usize];
            let mut near = [(limit, u32::MAX); ACROSS_BORDER];
            for end_of_member in members.iter().flat_map(|&item| [2 * item, 2 * item + 1]) {
                let distance = tour.step(end, end_of_member);
                if distance < near[ACROSS_BORDER - 1].0 {
                    let to = near.partition_point(|&(other, _)| other <= distance);
                    near[to..].rotate_right(1);
                    near[to] = (distance, end_of_member);
                }
            }
            buffer.extend(near.iter().map(|&(_, end)| end).filter(|&end| end != u32::MAX));
        }
        if group != other_group {
            for &near in self.neighbours.of_group(group) {
                buffer.extend(self.borders(near));
            }
            if group != 0 {
                buffer.extend([ARRIVAL, DEPARTURE]);
            }
        }
    }

    /// The ends by which a group is entered and left.
    fn borders(&self, group: u32) -> [u32; 2] {
        let tour = &self.tour;
        let problem = tour.problem;
        let first = problem.first_leaf[group as usize] as usize;
        let last = problem.first_leaf[group as usize + 1] as usize - 1;
        let is_backward = first != last && tour.is_entered(DEPARTURE);
        let (first, last) = if is_backward { (last, first) } else { (first, last) };
        let end = tour.after(tour.start(last), problem.members[last].len() - 1);
        [tour.enters(tour.start(first)), tour.leaves(end)]
    }
}
