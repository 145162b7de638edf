//! Random items, and the shortest of all their routes.

use proptest::prelude::*;

use crate::travel::{Item, Order, Retraction, Shape, Visit, Way, is_allowed};

/// Items that own the entries of their loops, and constraints.
#[derive(Clone, Debug)]
pub(super) struct Case {
    kinds: Vec<Kind>,
    /// Group and stage of each item.
    groups: Vec<(u32, u32)>,
    pub(super) order: Order,
    pub(super) from: Option<[f64; 2]>,
    pub(super) seed: u64,
}

#[derive(Clone, Debug)]
enum Kind {
    Bead([f64; 2], [f64; 2], bool),
    Loop(Vec<[f64; 2]>),
}

impl Case {
    pub(super) fn items(&self) -> Vec<Item<'_>> {
        let mut items = Vec::new();
        for (kind, &(group, stage)) in self.kinds.iter().zip(&self.groups) {
            let shape = match *kind {
                Kind::Bead(start, end, reversible) => Shape::Bead { start, end, reversible },
                Kind::Loop(ref entries) => Shape::Loop { entries },
            };
            items.push(Item { shape, group, stage });
        }
        items
    }
}

/// Coordinates from a coarse grid cause duplicate and collinear points.
fn any_point() -> impl Strategy<Value = [f64; 2]> {
    prop_oneof![
        2 => [0.0..100.0, 0.0..100.0],
        1 => [0..4_i32, 0..4_i32].prop_map(|[x, y]| [f64::from(x), f64::from(y)]),
    ]
}

/// One item in three is a loop; every fifth bead must not be reversed in half of the cases.
pub(super) fn any_case(
    counts: std::ops::RangeInclusive<usize>,
    max_entries: usize,
) -> impl Strategy<Value = Case> {
    let kind = prop_oneof![
        2 => (any_point(), any_point(), 0..5).prop_map(|(a, b, drawn)| Kind::Bead(a, b, drawn > 0)),
        1 => prop::collection::vec(any_point(), 1..=max_entries).prop_map(Kind::Loop),
    ];
    let item = (kind, (0..4_u32, 0..3_u32));
    let order = prop_oneof![Just(Order::Free), Just(Order::Groups), Just(Order::Stages)];
    let items = prop::collection::vec(item, counts);
    let from = prop::option::of(any_point());
    (items, order, from, any::<u64>(), any::<bool>()).prop_map(
        |(items, order, from, seed, reversible)| {
            let (mut kinds, groups): (Vec<_>, Vec<_>) = items.into_iter().unzip();
            for kind in &mut kinds {
                if let Kind::Bead(_, _, is_reversible) = kind {
                    *is_reversible |= reversible;
                }
            }
            Case { kinds, groups, order, from, seed }
        },
    )
}

/// Travel of the shortest allowed route, by trying all of them.
pub(super) fn shortest(items: &[Item<'_>], order: Order, from: Option<[f64; 2]>) -> f64 {
    let mut best = f64::INFINITY;
    let mut visits = Vec::new();
    extend(items, order, from, None, 0.0, &mut visits, &mut best);
    best
}

/// Cost of the cheapest route with retractions, by trying all.
pub(super) fn cheapest(
    items: &[Item<'_>],
    order: Order,
    from: Option<[f64; 2]>,
    retraction: Option<Retraction>,
) -> f64 {
    let mut best = f64::INFINITY;
    extend(items, order, from, retraction, 0.0, &mut Vec::new(), &mut best);
    best
}

/// Cost of a route with retractions.
pub(super) fn cost_mm_of(
    items: &[Item<'_>],
    visits: &[Visit],
    from: Option<[f64; 2]>,
    retraction: Option<Retraction>,
) -> f64 {
    let mut position = from;
    let mut cost = 0.0;
    for visit in visits {
        let [start, end] = visit.ends(items);
        cost += step_cost(position, start, retraction);
        position = Some(end);
    }
    cost
}

fn step_cost(from: Option<[f64; 2]>, to: [f64; 2], retraction: Option<Retraction>) -> f64 {
    let length = from.map_or(0.0, |[x, y]| (x - to[0]).hypot(y - to[1]));
    match retraction {
        Some(Retraction { beyond_mm, cost_mm }) if length > beyond_mm => length + cost_mm,
        _ => length,
    }
}

fn extend(
    items: &[Item<'_>],
    order: Order,
    position: Option<[f64; 2]>,
    retraction: Option<Retraction>,
    travel: f64,
    visits: &mut Vec<Visit>,
    best: &mut f64,
) {
    if travel >= *best {
        return;
    }
    if visits.len() == items.len() {
        if is_allowed(items, visits, order) {
            *best = travel;
        }
        return;
    }
    for item in 0..items.len() {
        if visits.iter().any(|visit| visit.item == item) {
            continue;
        }
        let ways = match items[item].shape {
            Shape::Bead { reversible: true, .. } => vec![Way::Forward, Way::Backward],
            Shape::Bead { .. } => vec![Way::Forward],
            Shape::Loop { entries } => (0..entries.len()).map(Way::Entry).collect(),
        };
        for way in ways {
            let visit = Visit { item, way };
            let [start, end] = visit.ends(items);
            let step = step_cost(position, start, retraction);
            visits.push(visit);
            extend(items, order, Some(end), retraction, travel + step, visits, best);
            visits.pop();
        }
    }
}
