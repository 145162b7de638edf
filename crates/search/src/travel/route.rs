//! The result: a route, its length, and what is proven about it.

use super::item::{Item, Shape, Way};
use super::settings::Order;
use crate::Stop;

/// The items in the order of printing, the travel between them, and a bound on it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Route {
    /// Each item once, in the order of printing.
    pub visits: Vec<Visit>,
    /// Sum of the straight distances from each item to the next, and from
    /// [`Settings::from`](super::Settings::from) to the first, in mm.
    pub travel_mm: f64,
    /// Proven lower bound on the travel of every allowed route, in mm, with rounding taken into
    /// account.
    /// `None` if [`Settings::bound_iterations`](super::Settings::bound_iterations) is 0, or if
    /// there are more items than [`MAX_BOUNDED`](super::MAX_BOUNDED).
    pub bound_mm: Option<f64>,
    /// Reason why the search stopped; [`Stop::Optimal`] if no shorter route exists.
    pub stop: Stop,
}

impl Route {
    /// Maximum amount by which another route could be shorter, in mm; `None` without a bound.
    pub fn gap_mm(&self) -> Option<f64> {
        self.bound_mm.map(|bound| self.travel_mm - bound)
    }
}

/// An item of a route.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// Index of the item.
    pub item: usize,
    /// How the item is printed.
    pub way: Way,
}

impl Visit {
    /// First and last point of the visit, in mm.
    ///
    /// # Panics
    /// If the visit does not fit the items: no such item or entry, or a loop printed as a bead.
    pub fn ends(self, items: &[Item<'_>]) -> [[f64; 2]; 2] {
        match (items[self.item].shape, self.way) {
            (Shape::Bead { start, end, .. }, Way::Forward) => [start, end],
            (Shape::Bead { start, end, .. }, Way::Backward) => [end, start],
            (Shape::Loop { entries }, Way::Entry(entry)) => [entries[entry]; 2],
            (shape, way) => panic!("{shape:?} cannot be printed {way:?}"),
        }
    }
}

/// Travel of these visits, in mm: the sum of the distances from each to the next, and from `from`
/// to the first.
///
/// # Panics
/// As [`Visit::ends`].
pub fn travel_mm(items: &[Item<'_>], visits: &[Visit], from: Option<[f64; 2]>) -> f64 {
    let mut position = from;
    let mut travel = 0.0;
    for visit in visits {
        let [start, end] = visit.ends(items);
        travel += position.map_or(0.0, |position| distance(position, start));
        position = Some(end);
    }
    travel
}

/// Whether the visits print each item once, in a way that its shape allows, and in an allowed
/// order.
/// O(n log n) for n items.
pub fn is_allowed(items: &[Item<'_>], visits: &[Visit], order: Order) -> bool {
    let mut visited = vec![false; items.len()];
    for &Visit { item, way } in visits {
        let Some(shape) = items.get(item).map(|item| item.shape) else { return false };
        let is_possible = match (shape, way) {
            (Shape::Bead { .. }, Way::Forward) => true,
            (Shape::Bead { reversible, .. }, Way::Backward) => reversible,
            (Shape::Loop { entries }, Way::Entry(entry)) => entry < entries.len(),
            _ => false,
        };
        if !is_possible || std::mem::replace(&mut visited[item], true) {
            return false;
        }
    }
    if visits.len() != items.len() {
        return false;
    }
    if order == Order::Free {
        return true;
    }
    let items = visits.iter().map(|visit| &items[visit.item]);
    let mut blocks: Vec<(u32, u32)> = items.map(|item| (item.group, item.stage)).collect();
    if order == Order::Stages
        && !blocks.is_sorted_by(|(group, stage), (next, later)| group != next || stage <= later)
    {
        return false;
    }
    // Each group forms one block: none returns after another.
    blocks.dedup_by_key(|(group, _)| *group);
    let count = blocks.len();
    blocks.sort_unstable();
    blocks.dedup_by_key(|(group, _)| *group);
    blocks.len() == count
}

/// Distance of two points.
#[inline]
pub(super) fn distance([x, y]: [f64; 2], [other_x, other_y]: [f64; 2]) -> f64 {
    let (dx, dy) = (x - other_x, y - other_y);
    (dx * dx + dy * dy).sqrt()
}
