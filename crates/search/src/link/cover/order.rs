//! Orders of ends with a small frontier.

use super::component::Component;
use super::schedule::MAX_SLOTS;
use crate::link::end::Point;

/// Directions of the sweeps that are tried, in steps of a half turn.
const DIRECTIONS: u32 = 8;

/// Frontiers above this size count like this one.
const MAX_FRONTIER: u32 = 60;

/// The order of the ends of a component with the smallest frontier among several: sweeps over the
/// lines in several directions, and orders that grow from an end and keep the frontier small.
pub(super) fn order(component: &Component) -> Vec<u32> {
    let mut best: Option<(f64, Vec<u32>)> = None;
    let mut consider = |order: Vec<u32>| {
        let cost = cost(component, &order);
        if best.as_ref().is_none_or(|best| cost < best.0) {
            best = Some((cost, order));
        }
    };
    let points = &component.points;
    let mut angles: Vec<f64> = (0..DIRECTIONS)
        .map(|step| f64::from(step) * std::f64::consts::PI / f64::from(DIRECTIONS))
        .collect();
    angles.insert(0, normal(points));
    for &angle in &angles {
        let (sine, cosine) = libm::sincos(angle);
        let along = |end: u32| {
            let [x, y] = points[end as usize];
            x * cosine + y * sine
        };
        consider(sorted(component, |end| along(end & !1) + along(end | 1)));
    }
    let (sine, cosine) = libm::sincos(angles[0]);
    let along = |end: &u32| points[*end as usize][0] * cosine + points[*end as usize][1] * sine;
    let ends = || 0..component.end_count() as u32;
    let starts = [
        ends().min_by(|a, b| along(a).total_cmp(&along(b))),
        ends().max_by(|a, b| along(a).total_cmp(&along(b))),
        ends().min_by_key(|&end| component.links_at(end).count()),
    ];
    for start in starts.into_iter().flatten() {
        if let Some(order) = grown(component, start) {
            consider(order);
        }
    }
    best.map_or_else(Vec::new, |best| best.1)
}

/// Angle of the normal of most lines, each weighted by its length.
fn normal(points: &[Point]) -> f64 {
    let mut sum = [0.0; 2];
    for ends in points.chunks_exact(2) {
        let [x, y] = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let size = libm::hypot(x, y);
        if size > 0.0 {
            // Twice the angle, so that opposite directions are one.
            sum = [sum[0] + (x * x - y * y) / size, sum[1] + 2.0 * x * y / size];
        }
    }
    libm::atan2(sum[1], sum[0]) / 2.0 + std::f64::consts::FRAC_PI_2
}

/// The ends, sorted by a key.
fn sorted(component: &Component, key: impl Fn(u32) -> f64) -> Vec<u32> {
    let mut keys: Vec<(f64, u32)> =
        (0..component.end_count() as u32).map(|end| (key(end), end)).collect();
    keys.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    keys.into_iter().map(|(_, end)| end).collect()
}

/// An order that takes next the end of the frontier that brings the fewest lines into it, of
/// several the one that has been in it for the longest time; `None` if the frontier gets too large.
fn grown(component: &Component, start: u32) -> Option<Vec<u32>> {
    let count = component.end_count();
    let mut is_touched = vec![false; count / 2];
    let mut frontier = Vec::new();
    let mut order = Vec::with_capacity(count);
    let mut is_done = vec![false; count];
    let mut rest = (0..count as u32).cycle().skip(start as usize).take(count);
    while order.len() < count {
        if frontier.len() > MAX_SLOTS {
            return None;
        }
        let growth = |end: u32| {
            let lines = component.links_at(end).map(|(_, other)| other / 2);
            lines.filter(|&line| !is_touched[line as usize]).count()
        };
        let best = (0..frontier.len()).min_by_key(|&index| growth(frontier[index]));
        let end = match best {
            Some(index) => frontier.remove(index),
            // Conflicts alone connect what remains.
            None => match rest.find(|&end| !is_done[end as usize]) {
                Some(end) => {
                    is_touched[end as usize / 2] = true;
                    frontier.push(end ^ 1);
                    end
                }
                None => break,
            },
        };
        is_done[end as usize] = true;
        order.push(end);
        for (_, other) in component.links_at(end) {
            if !std::mem::replace(&mut is_touched[other as usize / 2], true) {
                frontier.extend([other & !1, other | 1]);
            }
        }
    }
    Some(order)
}

/// A cost of an order that rises with the number of states of a dynamic program.
fn cost(component: &Component, order: &[u32]) -> f64 {
    let mut is_touched = vec![false; component.end_count() / 2];
    let mut frontier = 0_u32;
    let mut touch = |line: u32| {
        let is_new = !std::mem::replace(&mut is_touched[line as usize], true);
        2 * u32::from(is_new)
    };
    let mut cost = 0.0;
    for &end in order {
        frontier += touch(end / 2);
        for (_, other) in component.links_at(end) {
            frontier += touch(other / 2);
        }
        frontier -= 1;
        cost += libm::exp2(f64::from(frontier.min(MAX_FRONTIER)) / 2.0);
    }
    cost
}
