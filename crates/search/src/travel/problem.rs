//! The items as nodes of a closed tour.
//!
//! Each item has two **ends**: ends `2 * item` and `2 * item + 1` are the start and the end of a
//! bead, or both the chosen entry of a loop.
//! Item 0 is the **anchor**, which closes a route to a tour: its end [`DEPARTURE`] is the position
//! of the nozzle before the route, and its end [`ARRIVAL`] has distance 0 from every other end.
//! The items of the caller follow, so all their indices are one higher here.
//!
//! Items are in **leaves**, and leaves in groups.
//! The items of a leaf stay next to each other in any order; a group is a sequence of leaves, one
//! for each stage; the groups may follow each other in any order.
//! In free order each item is a group of its own.

use super::item::{Item, Shape};
use super::settings::{Order, Retraction};

/// End of the anchor from which the route departs.
pub(super) const DEPARTURE: u32 = 1;
/// End of the anchor at which the route arrives.
pub(super) const ARRIVAL: u32 = 0;

/// Coordinates of an end whose distance from all others is 0.
///
/// A difference to them is not a number either, and the larger of such a number and 0 is 0.
const FREE: [f64; 2] = [f64::NAN; 2];

/// Retractions that never happen.
const NO_RETRACTION: Retraction = Retraction { beyond_mm: f64::INFINITY, cost_mm: 0.0 };

/// Length of the travel between two ends, 0 if one of them is free.
#[inline]
fn length([x, y]: [f64; 2], [other_x, other_y]: [f64; 2]) -> f64 {
    let (dx, dy) = (x - other_x, y - other_y);
    (dx * dx + dy * dy).sqrt().max(0.0)
}

/// The item that an end belongs to.
#[inline]
pub(super) fn item_of(end: u32) -> usize {
    (end >> 1) as usize
}

/// The other end of the same item.
#[inline]
pub(super) fn across(end: u32) -> u32 {
    end ^ 1
}

/// What the search needs to know about the items.
pub(super) struct Problem<'a> {
    /// The items of the caller.
    pub(super) items: &'a [Item<'a>],
    /// Position of the nozzle, if it matters.
    pub(super) from: Option<[f64; 2]>,
    /// Group of each item, the anchor's being 0.
    pub(super) group: Vec<u32>,
    /// Leaf of each item; leaves are numbered by group, then by stage.
    pub(super) leaf: Vec<u32>,
    /// Items of each leaf.
    pub(super) members: Vec<Vec<u32>>,
    /// First leaf of each group, and at the end the number of leaves.
    pub(super) first_leaf: Vec<u32>,
    /// Whether some group has several items.
    pub(super) has_blocks: bool,
    /// Whether each item is a bead that must not be reversed.
    pub(super) is_irreversible: Vec<bool>,
    /// Whether each item must keep its direction, relative to the anchor's, when groups move.
    /// Empty if this holds for none.
    pub(super) is_directed: Vec<bool>,
    /// Number of items that must keep their direction.
    pub(super) directed: usize,
    /// Length of travel above which it costs more, in mm, and by how much.
    retraction: Retraction,
    /// Length of the diagonal of the box around all points, in mm.
    pub(super) extent: f64,
    /// Gains up to this length are rounding errors, in mm.
    pub(super) tolerance: f64,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        items: &'a [Item<'a>],
        order: Order,
        from: Option<[f64; 2]>,
        retraction: Option<Retraction>,
    ) -> Self {
        let key = |index: usize| match (order, &items[index]) {
            (Order::Free, _) => (index as u32, 0),
            (Order::Groups, item) => (item.group, 0),
            (Order::Stages, item) => (item.group, item.stage),
        };
        let mut sorted: Vec<u32> = (0..items.len() as u32).collect();
        sorted.sort_by_key(|&index| key(index as usize));
        let mut group = vec![0; items.len() + 1];
        let mut leaf = vec![0; items.len() + 1];
        let mut members = vec![vec![0]];
        let mut first_leaf = vec![0];
        let mut previous = None;
        for index in sorted {
            let here = key(index as usize);
            if previous.is_none_or(|(group, _)| group != here.0) {
                first_leaf.push(members.len() as u32);
            }
            if previous != Some(here) {
                members.push(Vec::new());
            }
            previous = Some(here);
            let item = index as usize + 1;
            group[item] = first_leaf.len() as u32 - 1;
            leaf[item] = members.len() as u32 - 1;
            members.last_mut().expect("the anchor has a leaf").push(item as u32);
        }
        first_leaf.push(members.len() as u32);

        let irreversible = items.iter().map(|item| is_irreversible(item.shape));
        let is_irreversible: Vec<bool> = std::iter::once(false).chain(irreversible).collect();
        let has_stages = |item: usize| {
            let group = group[item] as usize;
            first_leaf[group + 1] - first_leaf[group] > 1
        };
        let is_directed = (0..=items.len()).map(|item| is_irreversible[item] || has_stages(item));
        let mut is_directed: Vec<bool> = is_directed.collect();
        let mut directed = is_directed.iter().filter(|&&is_directed| is_directed).count();
        if directed == 0 {
            is_directed.clear();
        } else {
            is_directed[0] = true;
            directed += 1;
        }
        let extent = extent(items, from);
        Self {
            items,
            from,
            has_blocks: first_leaf.len() <= items.len() + 1,
            group,
            leaf,
            members,
            first_leaf,
            is_irreversible,
            is_directed,
            directed,
            retraction: retraction.unwrap_or(NO_RETRACTION),
            extent,
            tolerance: 1e-11 * extent,
        }
    }

    /// Cost of the travel between two ends in mm: its length, and that of a retraction if it is
    /// long.
    #[inline]
    pub(super) fn step(&self, end: [f64; 2], other: [f64; 2]) -> f64 {
        let length = length(end, other);
        if length > self.retraction.beyond_mm { length + self.retraction.cost_mm } else { length }
    }

    /// Number of items with the anchor.
    pub(super) fn count(&self) -> usize {
        self.items.len() + 1
    }

    /// Entries of a loop; `None` for beads and the anchor.
    #[inline]
    pub(super) fn entries(&self, item: usize) -> Option<&'a [[f64; 2]]> {
        match self.items.get(item.checked_sub(1)?)?.shape {
            Shape::Loop { entries } => Some(entries),
            Shape::Bead { .. } => None,
        }
    }

    /// Points of the two ends of an item; a loop begins at its first entry.
    pub(super) fn ends(&self, item: usize) -> [[f64; 2]; 2] {
        let Some(index) = item.checked_sub(1) else {
            return [FREE, self.from.unwrap_or(FREE)];
        };
        match self.items[index].shape {
            Shape::Bead { start, end, .. } => [start, end],
            Shape::Loop { entries } => [entries[0]; 2],
        }
    }
}

fn is_irreversible(shape: Shape<'_>) -> bool {
    matches!(shape, Shape::Bead { reversible: false, .. })
}

/// Length of the diagonal of the box around all points.
fn extent(items: &[Item<'_>], from: Option<[f64; 2]>) -> f64 {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    let mut add = |point: &[f64; 2]| {
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    };
    from.iter().for_each(&mut add);
    for item in items {
        match &item.shape {
            Shape::Bead { start, end, .. } => [start, end].into_iter().for_each(&mut add),
            Shape::Loop { entries } => entries.iter().for_each(&mut add),
        }
    }
    if low[0] <= high[0] { super::route::distance(low, high) } else { 0.0 }
}
