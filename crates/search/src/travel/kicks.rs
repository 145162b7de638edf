//! Kicks: small random changes that a local search then repairs.
//!
//! Three successive short segments are put into the opposite order, each keeping its direction: the
//! double bridge of Martin, Otto and Felten, "Large-step Markov chains for the traveling salesman
//! problem" (Complex Systems 5, 1991), which exchanges of three links cannot undo.

use beadwork_base::Control;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::entries::improve_entries;
use super::local_search::LocalSearch;
use super::problem::item_of;
use super::tour::Tour;
use crate::random::below;
use crate::stop::Stop;

/// Maximum number of items or groups of a segment.
const SEGMENT: usize = 30;

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
    entered + shuffle(search, item, rng).unwrap_or(0.0)
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

/// Changes the order of three segments near an item; returns the gain, usually negative.
/// `None` if there are too few items or groups.
fn shuffle(search: &mut LocalSearch<'_>, item: usize, rng: &mut Xoshiro256PlusPlus) -> Option<f64> {
    let tour = &search.tour;
    let problem = tour.problem;
    let leaf = problem.leaf[item] as usize;
    let size = problem.members[leaf].len();
    let cuts = if problem.has_blocks && (size >= 3 && below(rng, 4) > 0) {
        // Positions of the leaf, counted from its start.
        let here = tour.steps(tour.start(leaf), tour.position(2 * item as u32));
        let cuts = cuts(size, here, rng)?;
        cuts.map(|cut| tour.after(tour.start(leaf), cut))
    } else if problem.has_blocks {
        return shuffle_groups(search, item, rng);
    } else {
        // Positions after the anchor.
        let first = tour.after(tour.position(0), 1);
        let here = tour.steps(first, tour.position(2 * item as u32));
        let cuts = cuts(tour.count() - 1, here, rng)?;
        cuts.map(|cut| tour.after(first, cut))
    };
    Some(reorder(search, cuts))
}

/// Exchanges three successive runs of groups around that of an item.
fn shuffle_groups(
    search: &mut LocalSearch<'_>,
    item: usize,
    rng: &mut Xoshiro256PlusPlus,
) -> Option<f64> {
    let tour = &search.tour;
    let problem = tour.problem;
    let groups = problem.first_leaf.len() - 2;
    if groups < 3 {
        return None;
    }
    let group = problem.group[item] as usize;
    let size = |group: usize| -> usize {
        let leaves = problem.first_leaf[group] as usize..problem.first_leaf[group + 1] as usize;
        problem.members[leaves].iter().map(Vec::len).sum()
    };
    // The first positions of successive groups, from the one of the item.
    let first = |group: usize| {
        let leaves = problem.first_leaf[group]..problem.first_leaf[group + 1];
        let starts = leaves.map(|leaf| tour.start(leaf as usize));
        let anchor = tour.position(0);
        starts.min_by_key(|&start| tour.steps(anchor, start)).unwrap_or(0)
    };
    let mut starts = vec![first(group)];
    let mut position = starts[0];
    while starts.len() <= SEGMENT {
        let here = problem.group[item_of(tour.enters(position))] as usize;
        if here == 0 {
            break;
        }
        position = tour.after(position, size(here));
        starts.push(position);
    }
    let cuts = cuts(starts.len() - 1, 0, rng)?;
    let cuts = cuts.map(|cut| starts[cut]);
    Some(reorder(search, cuts))
}

/// Four ascending numbers up to `count`, near each other and near `here`, which is below `count`.
fn cuts(count: usize, here: usize, rng: &mut Xoshiro256PlusPlus) -> Option<[usize; 4]> {
    if count < 3 {
        return None;
    }
    let length = (3 * SEGMENT).min(count);
    let first = here.saturating_sub(below(rng, length)).min(count - length);
    // Three different lengths without repetition: numbers from 0 to length, ascending.
    let mut cuts = [0; 4];
    loop {
        for cut in &mut cuts {
            *cut = first + below(rng, length + 1);
        }
        cuts.sort_unstable();
        if cuts.windows(2).all(|pair| pair[0] < pair[1]) {
            return Some(cuts);
        }
    }
}

/// Puts the segments that begin at the first three of these positions, up to the last one, into the
/// opposite order; returns the gain.
fn reorder(search: &mut LocalSearch<'_>, cuts: [usize; 4]) -> f64 {
    let tour = &mut search.tour;
    let [a, b, c, end] = cuts;
    let lengths = [tour.steps(a, b), tour.steps(b, c), tour.steps(c, end)];
    let before = |tour: &Tour<'_>, cut: usize| [tour.link(tour.enters(cut)), tour.enters(cut)];
    let old = cuts.map(|cut| before(tour, cut));
    tour.reverse(a, lengths.iter().sum());
    let mut start = a;
    for length in lengths.into_iter().rev() {
        tour.reverse(start, length);
        start = tour.after(start, length);
    }
    let [_, first, second, _] = [0, lengths[2], lengths[2] + lengths[1], 0];
    let new = [a, tour.after(a, first), tour.after(a, second), end].map(|cut| before(tour, cut));
    let sum =
        |links: [[u32; 2]; 4]| -> f64 { links.iter().map(|&[from, to]| tour.step(from, to)).sum() };
    let gain = sum(old) - sum(new);
    for end in old.into_iter().flatten() {
        search.push(end);
    }
    gain
}
