//! Dispatch of the methods.

use beadwork_base::Control;

use super::cover::cover;
use super::end::End;
use super::links::Links;
use super::nearest::{Nearest, breaks};
use super::settings::{Method, Outcome, Settings, Work};
use crate::Stop;
use crate::disjoint_sets::DisjointSets;

/// Links lines to beads.
///
/// Works on the calling thread.
/// Progress counts runs of nearest neighbour, or lines of components that are done.
/// An interrupted call returns the best beads so far, each line once.
///
/// A run of nearest neighbour takes O(n log n) time for n lines.
/// [`Method::Nearest`] makes one, [`Method::BreakPoints`] one more for each two beads of it at each
/// side of a lift, [`Method::Repetitive`] 2 n.
pub fn solve(links: &Links, settings: &Settings, control: &Control<'_>) -> Outcome {
    if links.line_count() == 0 {
        let stop = Stop::Optimal;
        return Outcome { beads: Vec::new(), bound: 0, stop, work: Work::default() };
    }
    let mut nearest = Nearest::new(links, settings.links_first);
    let first = nearest.random(settings.seed);
    let mut work = Work::default();
    let (beads, bound, interrupted) = match settings.method {
        Method::Cover => {
            let found = cover(links, &first, settings, &mut work, control);
            (found.beads, found.bound, found.interrupted)
        }
        method => {
            let starts = match method {
                Method::Nearest | Method::Cover => Vec::new(),
                Method::BreakPoints => breaks(&first),
                Method::Repetitive => (0..links.points().len()).map(End::from_index).collect(),
            };
            let (beads, interrupted) = nearest.best_of(first, &starts, control);
            let (components, bound) = degree_bound(links);
            work.components = components;
            (beads, bound, interrupted)
        }
    };
    work.runs = nearest.runs;
    let stop = match interrupted {
        _ if beads.len() <= bound => Stop::Optimal,
        Some(interrupted) => interrupted.into(),
        None => Stop::Done,
    };
    Outcome { beads, bound, stop, work }
}

/// Number of connected components, and a lower bound on the number of beads: no component has less
/// than one bead, and each end without links is the end of a bead.
fn degree_bound(links: &Links) -> (u32, usize) {
    let mut sets = DisjointSets::new(links.line_count());
    for link in links.all() {
        sets.union(link.ends[0].line, link.ends[1].line);
    }
    let mut unlinked = vec![0_usize; links.line_count()];
    let mut is_root = vec![false; links.line_count()];
    for index in 0..links.points().len() {
        let end = End::from_index(index);
        let root = sets.find(end.line) as usize;
        is_root[root] = true;
        unlinked[root] += usize::from(links.at(end).is_empty());
    }
    let roots = || is_root.iter().zip(&unlinked).filter(|(is_root, _)| **is_root);
    (roots().count() as u32, roots().map(|(_, unlinked)| unlinked.div_ceil(2).max(1)).sum())
}
