//! Ends, widths and points of skeletons.

use super::SkeletonSettings;
use super::boundary::Boundary;
use super::prune::Node;
use super::trace::Line;
use super::vector::{Vector, add_scaled, distance, left, lerp, nearest_on_segment, sub, unit};

/// Rays across the width of a bead that measure how far it is from the end of the wall.
const RAYS: usize = 6;
/// Distance from the end of a bead to the boundary, in mm and as a share of half the maximum width:
/// positions in a file are rounded, callers simplify the boundary, and the centreline must not
/// touch the outline.
const END_GAP: [f64; 2] = [0.005, 0.025];
/// Change of width that a simplified line may have to the original one, as a ratio.
const WIDTH_TOLERANCE: f64 = 0.05;
/// Directions in which a bead without direction is tried.
const DIRECTIONS: [Vector; 12] = [
    [1.0, 0.0],
    [0.0, 1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [2.0, 1.0],
    [1.0, 2.0],
    [-1.0, 2.0],
    [-2.0, 1.0],
    [4.0, 1.0],
    [1.0, 4.0],
    [-1.0, 4.0],
    [-4.0, 1.0],
];

/// A point of a line with its width, in mm.
type Point = (Vector, f64);

/// The points of a line, extended to the ends of the wall and simplified; empty if it is too short.
pub(super) fn finish(line: &Line, boundary: &Boundary, settings: &SkeletonSettings) -> Vec<Point> {
    let max_radius = settings.max_width_mm / 2.0;
    let mut nodes = line.nodes.clone();
    if !line.is_closed {
        trim(&mut nodes, line.trim_mm[0]);
        nodes.reverse();
        trim(&mut nodes, line.trim_mm[1]);
        nodes.reverse();
        extend(&mut nodes, line.trim_mm, boundary, max_radius);
    }
    let mut points: Vec<Point> =
        nodes.iter().map(|node| (node.point, 2.0 * node.radius.min(max_radius))).collect();
    points.dedup_by(|b, a| distance(a.0, b.0) < 1e-6);
    let closing = if line.is_closed { points.first().copied() } else { None };
    points.extend(closing);
    simplify(&mut points, settings.tolerance_mm);
    let length: f64 = points.windows(2).map(|pair| distance(pair[0].0, pair[1].0)).sum();
    if line.is_closed {
        points.pop();
    }
    if points.len() < 2 || length < settings.min_length_mm {
        return Vec::new();
    }
    points
}

/// Removes a length from the start of a line.
fn trim(nodes: &mut Vec<Node>, mut by_mm: f64) {
    if by_mm <= 0.0 {
        return;
    }
    for i in 1..nodes.len() {
        let [a, b] = [nodes[i - 1], nodes[i]];
        let length = distance(a.point, b.point);
        if length > by_mm {
            let t = by_mm / length;
            let radius = a.radius + (b.radius - a.radius) * t;
            nodes[i - 1] = Node { point: lerp(a.point, b.point, t), radius, is_blunt: false };
            nodes.drain(..i - 1);
            return;
        }
        by_mm -= length;
    }
    nodes.clear();
}

/// Extends a line to the ends of the wall where it ended for the pruning of branches.
fn extend(nodes: &mut Vec<Node>, trim_mm: [f64; 2], boundary: &Boundary, max_radius: f64) {
    let Some(&widest) = nodes.iter().max_by(|a, b| a.radius.total_cmp(&b.radius)) else { return };
    let length: f64 = nodes.windows(2).map(|pair| distance(pair[0].point, pair[1].point)).sum();
    let ends = [nodes[0], nodes[nodes.len() - 1]];
    let may_extend = [0, 1].map(|k| ends[k].is_blunt && trim_mm[k] == 0.0);
    if may_extend == [true; 2] && length < 0.25 * widest.radius {
        // A spot: the longest bead through its centre.
        let [one, other] = DIRECTIONS
            .iter()
            .filter_map(|&direction| unit(direction))
            .map(|direction| {
                [1.0, -1.0].map(|sign| {
                    let direction = direction.map(|x| x * sign);
                    let room = room_ahead(widest, direction, boundary, max_radius);
                    (room, Node { point: add_scaled(widest.point, direction, room), ..widest })
                })
            })
            .reduce(|best, next| {
                let length = |spot: &[(f64, Node); 2]| spot[0].0 + spot[1].0;
                if length(&next) > length(&best) + 1e-6 { next } else { best }
            })
            .unwrap_or([(0.0, widest); 2]);
        *nodes = vec![other.1, widest, one.1];
        return;
    }
    for may_extend in may_extend {
        nodes.reverse();
        if may_extend {
            // The end that was first is last now.
            let end = nodes[nodes.len() - 1];
            let from = nodes
                .iter()
                .rev()
                .find(|node| distance(node.point, end.point) >= end.radius)
                .unwrap_or(&nodes[0]);
            if let Some(direction) = unit(sub(end.point, from.point)) {
                let room = room_ahead(end, direction, boundary, max_radius);
                nodes.push(Node { point: add_scaled(end.point, direction, room), ..end });
            }
        }
    }
}

/// Mean distance in mm to the boundary ahead, over the width of the bead, but not up to it.
fn room_ahead(end: Node, direction: Vector, boundary: &Boundary, max_radius: f64) -> f64 {
    let half_width = end.radius.min(max_radius);
    let limit = 2.5 * half_width.max(end.radius.min(2.0 * max_radius));
    let hit = |offset: f64| {
        let from = add_scaled(end.point, left(direction), offset * half_width);
        boundary.hit(from, direction, limit)
    };
    let sum: f64 = (0..RAYS).map(|i| hit((2 * i + 1) as f64 / RAYS as f64 - 1.0)).sum();
    let room = hit(0.0) - END_GAP[0] - END_GAP[1] * max_radius;
    (sum / RAYS as f64).min(room).max(0.0)
}

/// Drops points between which position and width are almost linear, as Douglas and Peucker do.
fn simplify(points: &mut Vec<Point>, tolerance_mm: f64) {
    let Some(last) = points.len().checked_sub(1) else { return };
    let mut is_kept = vec![false; points.len()];
    is_kept[0] = true;
    is_kept[last] = true;
    let mut stack = vec![(0, last)];
    while let Some((from, to)) = stack.pop() {
        let [a, b] = [points[from], points[to]];
        let span = distance(a.0, b.0);
        let worst = (from + 1..to)
            .map(|i| {
                let (point, width) = points[i];
                let foot = nearest_on_segment([a.0, b.0], point);
                let t = if span > 0.0 { distance(a.0, foot) / span } else { 0.0 };
                let expected = a.1 + (b.1 - a.1) * t;
                let by_width = (expected - width).abs() / (width * WIDTH_TOLERANCE);
                (i, (distance(point, foot) / tolerance_mm).max(by_width))
            })
            .max_by(|x, y| x.1.total_cmp(&y.1));
        if let Some((i, deviation)) = worst
            && deviation > 1.0
        {
            is_kept[i] = true;
            stack.extend([(from, i), (i, to)]);
        }
    }
    let mut keep = is_kept.into_iter();
    points.retain(|_| keep.next() == Some(true));
}
