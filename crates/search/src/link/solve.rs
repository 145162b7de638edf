//! Dispatch of the methods.

use beadwork_base::Control;

use super::cover::cover;
use super::end::End;
use super::links::Links;
use super::nearest::{Nearest, breaks};
use super::settings::{Method, Outcome, Settings, Work};
use crate::Stop;
use crate::disjoint_sets::DisjointSets;

/// Maximum number of lines for which the fewest beads, if they are not proven, are compared with
/// those of nearest neighbour from all ends.
const MAX_REPETITIVE: usize = 200;

/// The same for starts at break points.
const MAX_BREAK_POINTS: usize = 3000;

/// Links lines to beads.
///
/// Works on the calling thread.
/// Progress counts runs of nearest neighbour, or lines of components that are done.
/// An interrupted call returns the best beads so far, each line once.
///
/// A run of nearest neighbour takes O(n log n) time for n lines.
/// [`Method::Nearest`] makes one, [`Method::BreakPoints`] two more for each lift of that one in its
/// first round, and [`Method::Repetitive`] 2 n.
/// [`Method::Cover`] is a dynamic program over the ends of each connected component, in an order
/// with a small *frontier*: the ends between those that are done and those that are not.
/// Its time is proportional to the number of states that it generates, which
/// [`Settings::states_per_line`] limits; components with a small frontier need few.
/// If it keeps all states, the result is optimal.
/// If there are too many, it drops some, which gives a cover, or merges some, which gives a bound,
/// as in decision diagrams (Bergman, Cire, van Hoeve and Hooker, *Decision Diagrams for
/// Optimization*, 2016).
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
            let breaks = breaks(&first);
            let found = cover(links, &first, settings, &mut work, control);
            let count = links.line_count();
            let is_open = found.interrupted.is_none() && found.beads.len() > found.bound;
            let starts = if !is_open || count > MAX_BREAK_POINTS {
                Vec::new()
            } else if count > MAX_REPETITIVE {
                breaks
            } else {
                all_ends(links)
            };
            let control = control.without_progress();
            let (beads, interrupted) = nearest.best_of(found.beads, &starts, &control);
            (beads, found.bound, found.interrupted.or(interrupted))
        }
        method => {
            let (beads, interrupted) = match method {
                Method::Nearest | Method::Cover => (first, None),
                Method::BreakPoints => nearest.break_points(first, settings.rounds, control),
                Method::Repetitive => nearest.best_of(first, &all_ends(links), control),
            };
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

/// All ends of lines.
fn all_ends(links: &Links) -> Vec<End> {
    (0..links.points().len()).map(End::from_index).collect()
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
