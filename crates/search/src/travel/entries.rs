//! Entries of loops for a fixed order of the items, by dynamic programming.

use super::problem::item_of;
use super::tour::Tour;

/// Maximum number of entries of a loop that are all tried; of longer loops as many, chosen evenly,
/// and as many with the shortest detour.
const TRIED: usize = 16;

/// Maximum number of repetitions.
const ROUNDS: usize = 8;

/// Chooses the entries of all loops together, and returns the length that was gained, in mm.
///
/// For the entries that are tried, the choice is the best for this order.
/// O(n k²) steps for n items and k tried entries.
pub(super) fn improve_entries(tour: &mut Tour<'_>) -> f64 {
    let problem = tour.problem;
    if (1..problem.count()).all(|item| problem.entries(item).is_none_or(|all| all.len() == 1)) {
        return 0.0;
    }
    let mut gained = 0.0;
    for _ in 0..ROUNDS {
        let gain = improve_once(tour);
        gained += gain;
        if gain <= problem.tolerance {
            break;
        }
    }
    gained
}

/// A choice at a position: an entry, the length up to it, and the choice before it.
struct Choice {
    entry: u32,
    /// Where the nozzle leaves the item.
    point: [f64; 2],
    length: f64,
    before: u32,
}

fn improve_once(tour: &mut Tour<'_>) -> f64 {
    let anchor = tour.position(0);
    let count = tour.count();
    let mut choices: Vec<Choice> = Vec::with_capacity(count);
    let mut ranges = Vec::with_capacity(count + 1);
    let departure = tour.leaves(anchor);
    choices.push(Choice { entry: 0, point: tour.point(departure), length: 0.0, before: 0 });
    let mut previous = 0..1;
    let mut tried = Vec::new();
    for steps in 1..=count {
        let position = tour.after(anchor, steps);
        let end = tour.enters(position);
        let item = item_of(end);
        find_tried(tour, position, &mut tried);
        let first = choices.len();
        for &entry in &tried {
            let [begin, leave] = match tour.problem.entries(item) {
                Some(entries) => [entries[entry as usize]; 2],
                None => [tour.point(end), tour.point(tour.leaves(position))],
            };
            let (mut length, mut best) = (f64::INFINITY, 0);
            for before in previous.clone() {
                let choice = &choices[before];
                let here = choice.length + tour.problem.step(choice.point, begin);
                if here < length {
                    (length, best) = (here, before as u32);
                }
            }
            choices.push(Choice { entry, point: leave, length, before: best });
        }
        previous = first..choices.len();
        ranges.push(previous.clone());
    }
    // The last position is the anchor again, which has one choice.
    let gain = tour.length() - choices.last().map_or(0.0, |choice| choice.length);
    if gain <= tour.problem.tolerance {
        return 0.0;
    }
    let mut choice = choices.len() - 1;
    for steps in (1..count).rev() {
        choice = choices[choice].before as usize;
        let item = item_of(tour.enters(tour.after(anchor, steps)));
        let entry = choices[choice].entry as usize;
        if tour.problem.entries(item).is_some() && entry != tour.entry(item) {
            tour.enter(item, entry);
        }
    }
    gain
}

/// The entries to try of the item at a position; a single 0 for beads and the anchor.
fn find_tried(tour: &Tour<'_>, position: usize, tried: &mut Vec<u32>) {
    tried.clear();
    let end = tour.enters(position);
    let item = item_of(end);
    let Some(entries) = tour.problem.entries(item) else {
        tried.push(0);
        return;
    };
    if entries.len() <= TRIED {
        tried.extend(0..entries.len() as u32);
        return;
    }
    let before = tour.point(tour.link(end));
    let after = tour.point(tour.link(tour.leaves(position)));
    let mut nearest = [(f64::INFINITY, u32::MAX); TRIED];
    for (entry, &point) in entries.iter().enumerate() {
        let detour = tour.problem.step(before, point) + tour.problem.step(point, after);
        if detour < nearest[TRIED - 1].0 {
            let to = nearest.partition_point(|&(other, _)| other <= detour);
            nearest[to..].rotate_right(1);
            nearest[to] = (detour, entry as u32);
        }
    }
    tried.extend(nearest.iter().map(|&(_, entry)| entry));
    tried.push(tour.entry(item) as u32);
    tried.extend((0..TRIED).map(|sample| (sample * entries.len() / TRIED) as u32));
    tried.sort_unstable();
    tried.dedup();
}
