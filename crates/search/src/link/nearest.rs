//! Nearest neighbour, and the two methods that repeat it from chosen starts.

use beadwork_base::{Control, Interrupted};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::bead::{Bead, DirectedLine};
use super::end::End;
use super::kd_tree::KdTree;
use super::links::Links;
use crate::random::below;

/// Runs of nearest neighbour, which share their memory.
pub(super) struct Nearest<'a> {
    links: &'a Links,
    links_first: bool,
    tree: KdTree,
    is_visited: Vec<bool>,
    is_used: Vec<bool>,
    used: Vec<u32>,
    /// Runs so far.
    pub(super) runs: u32,
}

impl<'a> Nearest<'a> {
    pub(super) fn new(links: &'a Links, links_first: bool) -> Self {
        Self {
            links,
            links_first,
            tree: KdTree::new(links.points()),
            is_visited: vec![false; links.line_count()],
            is_used: vec![false; links.all().len()],
            used: Vec::new(),
            runs: 0,
        }
    }

    /// The beads of a run that begins at an end; `None` if they would be `limit` or more.
    pub(super) fn run(&mut self, start: End, limit: usize) -> Option<Vec<Bead>> {
        self.runs += 1;
        self.tree.restore();
        self.is_visited.fill(false);
        self.used.drain(..).for_each(|link| self.is_used[link as usize] = false);
        let mut beads = vec![Bead::default()];
        if limit <= 1 {
            return None;
        }
        let mut entry = start;
        loop {
            self.is_visited[entry.line as usize] = true;
            self.tree.remove(entry.index());
            self.tree.remove(entry.other().index());
            let exit = entry.other();
            let last = beads.len() - 1;
            beads[last].lines.push(DirectedLine::from(entry));
            match self.next(exit) {
                None => return Some(beads),
                Some((next, Some(link))) => {
                    beads[last].links.push(link);
                    self.is_used[link as usize] = true;
                    self.used.push(link);
                    entry = next;
                }
                Some((next, None)) => {
                    if beads.len() + 1 >= limit {
                        return None;
                    }
                    beads.push(Bead::default());
                    entry = next;
                }
            }
        }
    }

    /// The next end and the link to it, if it is not a lift; `None` at the end of the run.
    fn next(&self, exit: End) -> Option<(End, Option<u32>)> {
        let links = self.links;
        if self.links_first {
            let nearest = self.usable(exit).min_by(|&a, &b| {
                let key = |link: u32| links.link(link).length_mm;
                key(a).total_cmp(&key(b)).then(a.cmp(&b))
            });
            if let Some(link) = nearest {
                return Some((links.link(link).other(exit), Some(link)));
            }
        }
        let next = End::from_index(self.tree.nearest(links.point(exit))?);
        Some((next, self.usable(exit).find(|&link| links.link(link).other(exit) == next)))
    }

    /// The links from an end to lines that are not visited yet, without those that cross a used
    /// link.
    fn usable(&self, exit: End) -> impl Iterator<Item = u32> + '_ {
        self.links.at(exit).iter().copied().filter(move |&link| {
            !self.is_visited[self.links.link(link).other(exit).line as usize]
                && !self.links.conflicts_of(link).iter().any(|&other| self.is_used[other as usize])
        })
    }

    /// Tries starts one after the other, and returns the first result of those with the fewest
    /// beads, `best` included, and why it stopped early.
    ///
    /// Progress counts starts.
    pub(super) fn best_of(
        &mut self,
        mut best: Vec<Bead>,
        starts: &[End],
        control: &Control<'_>,
    ) -> (Vec<Bead>, Option<Interrupted>) {
        for (done, &start) in starts.iter().enumerate() {
            if let Some(interrupted) = control.interrupted() {
                return (best, Some(interrupted));
            }
            if let Some(beads) = self.run(start, best.len()) {
                best = beads;
            }
            control.report(done + 1, starts.len());
        }
        (best, None)
    }

    /// Rounds of starts at the break points of the best beads, from those of a first run, until a
    /// round finds no fewer; returns the best, and why it stopped early.
    ///
    /// Progress counts the starts of the first round, which has the most.
    pub(super) fn break_points(
        &mut self,
        first: Vec<Bead>,
        rounds: u32,
        control: &Control<'_>,
    ) -> (Vec<Bead>, Option<Interrupted>) {
        let mut best = first;
        let mut control = *control;
        for _ in 0..rounds {
            let before = best.len();
            let starts = breaks(&best);
            let (beads, interrupted) = self.best_of(best, &starts, &control);
            best = beads;
            if interrupted.is_some() || best.len() == before {
                return (best, interrupted);
            }
            control = control.without_progress();
        }
        (best, None)
    }

    /// Nearest neighbour from a random start; there must be a line.
    pub(super) fn random(&mut self, seed: u64) -> Vec<Bead> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let start = End::from_index(below(&mut rng, self.links.points().len()));
        self.run(start, usize::MAX).unwrap_or_default()
    }
}

/// The ends before and after each lift between beads, in order.
pub(super) fn breaks(beads: &[Bead]) -> Vec<End> {
    let ends_of = |pair: &[Bead]| {
        let before = pair[0].lines.last().map(|line| line.exit());
        let after = pair[1].lines.first().map(|line| line.entry());
        [before, after]
    };
    beads.windows(2).flat_map(ends_of).flatten().collect()
}
