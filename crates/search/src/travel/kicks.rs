//! Kicks: small random changes that a local search then repairs.
//!
//! Three successive short segments are put into the opposite order, each keeping its direction, as
//! in the double bridge of Martin, Otto and Felten, "Large-step Markov chains for the traveling
//! salesman problem" (Complex Systems 5, 1991), which exchanges of three links cannot undo.
//! Loops also begin elsewhere.

use beadwork_base::Control;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::entries::improve_entries;
use super::local_search::LocalSearch;
use super::problem::item_of;
use super::tour::Tour;
use crate::random::below;
use crate::stop::Stop;

/// Maximum number of items or groups of a segment.
const SEGMENT: usize = 8;
/// Sequences of fewer items or groups are also changed by random reversals.
const SHORT: usize = 8;

/// Shortens a tour by `count` kicks; returns why it stopped.
///
/// The progress, in kicks, is reported as `count` in all.
pub(super) fn kick(
    search: &mut LocalSearch<'_>,
    count: u64,
    rng: &mut Xoshiro256PlusPlus,
    control: &Control<'_>,
) -> Stop {
    let round = 10 * search.tour.count() as u64;
    for done in 0..count {
        if done % 64 == 0 {
            if let Some(interrupted) = control.interrupted() {
                return interrupted.into();
            }
            control.report(done as usize, count as usize);
        }
        if done % round == round - 1 {
            improve_entries(&mut search.tour);
            search.tour.commit();
        }
        let balance = change(search, rng) + search.run(|| false);
        if balance < 0.0 {
            search.tour.undo();
        } else {
            search.tour.commit();
        }
    }
    control.report(count as usize, count as usize);
    Stop::Done
}

/// Changes the tour near a random item; returns the gain, usually negative.
fn change(search: &mut LocalSearch<'_>, rng: &mut Xoshiro256PlusPlus) -> f64 {
    let item = 1 + below(rng, search.tour.count() - 1);
    let entered = match search.tour.problem.entries(item) {
        Some(entries) if entries.len() > 1 && below(rng, 2) == 0 => {
            enter(search, item, below(rng, entries.len()))
        }
        _ => 0.0,
    };
    let mut gain = entered + shuffle(search, item, rng).unwrap_or(0.0);
    // A different order of groups is often better only with another order in one of them.
    if search.tour.problem.has_blocks && below(rng, 2) == 0 {
        gain += shuffle(search, item, rng).unwrap_or(0.0);
    }
    gain
}

/// Moves the entry of a loop; returns the gain.
fn enter(search: &mut LocalSearch<'_>, item: usize, entry: usize) -> f64 {
    let tour = &mut search.tour;
    let ends = [2 * item as u32, 2 * item as u32 + 1];
    let links = ends.map(|end| tour.link(end));
    let length = |tour: &Tour<'_>| tour.step(links[0], ends[0]) + tour.step(ends[1], links[1]);
    let before = length(tour);
    tour.enter(item, entry);
    let gain = before - length(tour);
    // The ends of the loop are not marked: the search would move the entry back at once.
    links.into_iter().for_each(|end| search.push(end));
    gain
}

/// Changes the order of up to three segments near an item; returns the gain, usually negative.
/// `None` if there is nothing to change.
fn shuffle(search: &mut LocalSearch<'_>, item: usize, rng: &mut Xoshiro256PlusPlus) -> Option<f64> {
    let tour = &search.tour;
    let problem = tour.problem;
    if !problem.has_blocks {
        // Positions after the anchor.
        let first = tour.after(tour.position(0), 1);
        let here = tour.steps(first, tour.position(2 * item as u32));
        let cuts = Cuts::new(tour.count() - 1, here, rng)?;
        return Some(reorder(
            search,
            &cuts,
            &problem.is_directed,
            |cut, tour| tour.after(first, cut),
            rng,
        ));
    }
    let leaf = problem.leaf[item] as usize;
    let size = problem.members[leaf].len();
    let groups = problem.first_leaf.len() - 2;
    if groups == 1 || (size > 1 && below(rng, 4) > 0) {
        // Positions of the leaf, counted from its start.
        let start = tour.start(leaf);
        let here = tour.steps(start, tour.position(2 * item as u32));
        let cuts = Cuts::new(size, here, rng)?;
        return Some(reorder(
            search,
            &cuts,
            &problem.is_irreversible,
            |cut, tour| tour.after(start, cut),
            rng,
        ));
    }
    let starts =
        starts_of_groups(tour, problem.group[item] as usize, below(rng, SEGMENT.min(groups)));
    let cuts = Cuts::new(starts.len() - 1, below(rng, starts.len() - 1), rng)?;
    Some(reorder(search, &cuts, &problem.is_directed, |cut, _| starts[cut], rng))
}

/// First positions of some successive groups and the position after them, not across the anchor.
/// The group of this number is among them; about `before` others come before it.
fn starts_of_groups(tour: &Tour<'_>, group: usize, before: usize) -> Vec<usize> {
    let problem = tour.problem;
    let group_at = |position: usize| problem.group[item_of(tour.enters(position))] as usize;
    let back = |position: usize| tour.after(position, tour.count() - 1);
    let size = |group: usize| -> usize {
        let leaves = problem.first_leaf[group] as usize..problem.first_leaf[group + 1] as usize;
        problem.members[leaves].iter().map(Vec::len).sum()
    };
    let anchor = tour.position(0);
    let leaves = problem.first_leaf[group] as usize..problem.first_leaf[group + 1] as usize;
    let starts = leaves.map(|leaf| tour.start(leaf));
    let mut position = starts.min_by_key(|&start| tour.steps(anchor, start)).unwrap_or(anchor);
    for _ in 0..before {
        let earlier = group_at(back(position));
        if earlier == 0 {
            break;
        }
        position = tour.after(position, tour.count() - size(earlier));
    }
    let mut starts = vec![position];
    while starts.len() <= 3 * SEGMENT && group_at(position) != 0 {
        position = tour.after(position, size(group_at(position)));
        starts.push(position);
    }
    starts
}

/// Up to three successive segments of a sequence.
struct Cuts {
    /// Where the segments begin, and where the last one ends.
    at: [usize; 4],
    segments: usize,
    /// Whether the sequence is so short that segments should also be reversed.
    is_short: bool,
}

impl Cuts {
    /// Random segments near `here`, of a sequence of `count` items or groups; `None` if it is
    /// empty.
    fn new(count: usize, here: usize, rng: &mut Xoshiro256PlusPlus) -> Option<Self> {
        let is_short = count < SHORT;
        if count < 3 {
            return (count > 0).then_some(Self { at: [0, 1, 2, 2], segments: count, is_short });
        }
        let length = (3 * SEGMENT).min(count);
        let first = here.saturating_sub(below(rng, length)).min(count - length);
        let mut cuts = [0; 4];
        loop {
            for cut in &mut cuts {
                *cut = first + below(rng, length + 1);
            }
            cuts.sort_unstable();
            if cuts.windows(2).all(|pair| pair[0] < pair[1]) {
                return Some(Self { at: cuts, segments: 3, is_short });
            }
        }
    }
}

/// Puts segments into the opposite order, and reverses some if the sequence is short; returns the
/// gain.
///
/// `fixed` are the items that must not be reversed, empty if there are none.
fn reorder(
    search: &mut LocalSearch<'_>,
    cuts: &Cuts,
    fixed: &[bool],
    position: impl Fn(usize, &Tour<'_>) -> usize,
    rng: &mut Xoshiro256PlusPlus,
) -> f64 {
    let tour = &mut search.tour;
    let count = cuts.segments;
    let starts = cuts.at.map(|cut| position(cut.min(cuts.at[count]), tour));
    let lengths = [0, 1, 2].map(|index| tour.steps(starts[index], starts[index + 1]));
    let before = |tour: &Tour<'_>, cut: usize| [tour.link(tour.enters(cut)), tour.enters(cut)];
    let old = starts.map(|cut| before(tour, cut));
    tour.reverse(starts[0], lengths.iter().sum());
    let mut new = [starts[0]; 4];
    for (index, &length) in lengths[..count].iter().rev().enumerate() {
        let is_reversed = cuts.is_short && below(rng, 2) == 0 && {
            let mut items =
                (0..length).map(|steps| item_of(tour.enters(tour.after(new[index], steps))));
            fixed.is_empty() || !items.any(|item| fixed[item])
        };
        // All are reversed already.
        if !is_reversed {
            tour.reverse(new[index], length);
        }
        new[index + 1] = tour.after(new[index], length);
    }
    let new = new.map(|cut| before(tour, cut));
    let sum =
        |links: &[[u32; 2]]| -> f64 { links.iter().map(|&[from, to]| tour.step(from, to)).sum() };
    let gain = sum(&old[..=count]) - sum(&new[..=count]);
    for &end in old[..=count].as_flattened() {
        search.push(end);
    }
    gain
}
