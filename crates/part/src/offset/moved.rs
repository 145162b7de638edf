//! Moves the edges of a ring along their normals.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Length in mm of edges that count as shrunk to nothing.
const SHORT_MM: f64 = 1e-6;

/// 1 plus the cosine of a turn at a corner below which the moved edges count as parallel.
const REVERSAL: f64 = 1e-6;

type Vector = [f64; 2];

/// A ring whose edges have moved.
pub(super) enum Moved {
    /// All edges have shrunk to nothing.
    Nothing,
    /// All edges are cut off at their intersections.
    Plain {
        ring: Vec<Vector>,
        /// Maximum speed of corners that were not arcs, relative to edges.
        max_speed: f64,
    },
    /// Some edges are joined through the corner between them.
    Joined(Vec<Vector>),
}

/// Moves the edges of a ring by a distance in mm to the right, or to the left if it is negative.
///
/// Arcs lie beyond the exact ones by at most a tolerance in mm.
/// O(n log n).
pub(super) fn moved(ring: &[Vector], by_mm: f64, tolerance_mm: f64) -> Moved {
    let Some(front) = Front::new(ring, by_mm, tolerance_mm) else { return Moved::Nothing };
    let shrunk: Vec<usize> = (0..front.edges.len())
        .filter(|&at| front.edge_length(at, front.distance_mm) < SHORT_MM)
        .collect();
    if shrunk.is_empty() {
        return front.plain();
    }
    let mut without_shrunk = front.clone();
    match without_shrunk.shrink() {
        Some(0) => Moved::Nothing,
        Some(_) => without_shrunk.plain(),
        None => front.joined(&shrunk),
    }
}

/// The edges of a ring while they move.
#[derive(Clone)]
struct Front {
    edges: Vec<Edge>,
    /// Distance in mm by which edges move in all.
    distance_mm: f64,
    /// 1 if edges move to the left, -1 if they move to the right.
    side: f64,
    tolerance_mm: f64,
    max_speed: f64,
}

/// An edge, with the corner where it starts.
#[derive(Clone, Copy)]
struct Edge {
    along: Vector,
    /// The direction in which it moves.
    normal: Vector,
    before: usize,
    after: usize,
    /// Position of the corner when edges have moved by `since_mm`.
    corner: Vector,
    since_mm: f64,
    /// Movement of the corner for each mm by which edges move; 0 if an arc is around it.
    velocity: Vector,
    is_arc: bool,
    /// Counts the changes of an end.
    version: u32,
    is_gone: bool,
}

impl Front {
    /// `None` if the ring has fewer than three corners.
    fn new(ring: &[Vector], by_mm: f64, tolerance_mm: f64) -> Option<Self> {
        let mut corners: Vec<Vector> = ring.to_vec();
        corners.dedup_by(|b, a| distance(*a, *b) < SHORT_MM);
        while corners.len() > 1 && distance(corners[0], corners[corners.len() - 1]) < SHORT_MM {
            corners.pop();
        }
        let count = corners.len();
        if count < 3 {
            return None;
        }
        let side = if by_mm < 0.0 { 1.0 } else { -1.0 };
        let edge = |at: usize| {
            let (from, to) = (corners[at], corners[(at + 1) % count]);
            let length = distance(from, to);
            let along = [0, 1].map(|k| (to[k] - from[k]) / length);
            Edge {
                along,
                normal: [-along[1] * side, along[0] * side],
                before: (at + count - 1) % count,
                after: (at + 1) % count,
                corner: from,
                since_mm: 0.0,
                velocity: [0.0; 2],
                is_arc: true,
                version: 0,
                is_gone: false,
            }
        };
        let edges = (0..count).map(edge).collect();
        let mut front =
            Self { edges, distance_mm: by_mm.abs(), side, tolerance_mm, max_speed: 1.0 };
        for at in 0..count {
            let (before, edge) = (front.edges[front.edges[at].before], front.edges[at]);
            if side * cross(before.along, edge.along) > 0.0 {
                let velocity = meeting(&before, &edge).unwrap_or([f64::INFINITY; 2]);
                (front.edges[at].velocity, front.edges[at].is_arc) = (velocity, false);
                front.max_speed = front.max_speed.max(velocity[0].hypot(velocity[1]));
            }
        }
        Some(front)
    }

    /// The corner where an edge starts, when edges have moved by a distance.
    fn start(&self, at: usize, moved_mm: f64) -> Vector {
        let edge = &self.edges[at];
        [0, 1].map(|k| edge.corner[k] + (moved_mm - edge.since_mm) * edge.velocity[k])
    }

    /// The length of an edge when edges have moved by a distance, negative if it has shrunk to
    /// nothing before; negative as well if edges do not meet.
    fn edge_length(&self, at: usize, moved_mm: f64) -> f64 {
        let edge = &self.edges[at];
        let [start, end] = [at, edge.after].map(|corner| self.start(corner, moved_mm));
        let length = dot(edge.along, [end[0] - start[0], end[1] - start[1]]);
        if length.is_finite() { length } else { -1.0 }
    }

    /// How far edges have moved when an edge has shrunk to nothing; `None` if that is more than
    /// they move.
    fn shrinks_at_mm(&self, at: usize) -> Option<f64> {
        let last = self.edge_length(at, self.distance_mm);
        if last >= SHORT_MM {
            return None;
        }
        let first = self.edge_length(at, 0.0);
        // Positive at first, unless edges do not meet.
        Some(self.distance_mm * (first / (first - last)).clamp(0.0, 1.0))
    }

    /// Leaves out edges that shrink to nothing, and returns the number of the others.
    ///
    /// `None` if an edge shrinks to nothing next to an arc or between edges that do not meet.
    fn shrink(&mut self) -> Option<usize> {
        let mut left = self.edges.len();
        let mut queue = BinaryHeap::new();
        // The bits of numbers that are not negative have the order of the numbers.
        let entry = |front: &Self, at: usize| {
            let moved_mm = front.shrinks_at_mm(at)?;
            Some(Reverse((moved_mm.to_bits(), at, front.edges[at].version)))
        };
        queue.extend((0..left).filter_map(|at| entry(self, at)));
        while let Some(Reverse((bits, at, version))) = queue.pop() {
            let edge = self.edges[at];
            if edge.is_gone || edge.version != version {
                continue;
            }
            if edge.is_arc || self.edges[edge.after].is_arc {
                return None;
            }
            if left <= 3 {
                return Some(0);
            }
            let moved_mm = f64::from_bits(bits);
            let (before, after) = (self.edges[edge.before], self.edges[edge.after]);
            if self.side * cross(before.along, after.along) <= 0.0 {
                return None;
            }
            let velocity = meeting(&before, &after)?;
            self.max_speed = self.max_speed.max(velocity[0].hypot(velocity[1]));
            let corner = self.start(at, moved_mm);
            if !corner.iter().all(|x| x.is_finite()) {
                return None;
            }
            self.edges[at].is_gone = true;
            self.edges[edge.before].after = edge.after;
            let next = &mut self.edges[edge.after];
            (next.corner, next.since_mm, next.velocity) = (corner, moved_mm, velocity);
            next.before = edge.before;
            left -= 1;
            for changed in [edge.before, edge.after] {
                self.edges[changed].version += 1;
                queue.extend(entry(self, changed));
            }
        }
        Some(left)
    }

    /// The ring of the edges that have not shrunk to nothing.
    fn plain(&self) -> Moved {
        let mut ring = Vec::with_capacity(self.edges.len());
        for (at, edge) in self.edges.iter().enumerate().filter(|(_, edge)| !edge.is_gone) {
            if edge.is_arc {
                self.push_arc(at, &mut ring);
            } else {
                ring.push(self.start(at, self.distance_mm));
            }
        }
        ring.dedup_by(|b, a| distance(*a, *b) < SHORT_MM);
        Moved::Plain { ring, max_speed: self.max_speed }
    }

    /// The ring of all edges, of which some, that are not cut off, are joined through their
    /// corners.
    fn joined(&self, whole: &[usize]) -> Moved {
        let mut is_whole = vec![false; self.edges.len()];
        for &at in whole {
            (is_whole[at], is_whole[self.edges[at].after]) = (true, true);
        }
        let mut ring = Vec::with_capacity(self.edges.len() + 4 * whole.len());
        for (at, edge) in self.edges.iter().enumerate() {
            if edge.is_arc {
                self.push_arc(at, &mut ring);
            } else if is_whole[at] {
                let moved = |edge: &Edge, corner: Vector| {
                    [0, 1].map(|k| corner[k] + self.distance_mm * edge.normal[k])
                };
                let before = &self.edges[edge.before];
                ring.extend([moved(before, edge.corner), edge.corner, moved(edge, edge.corner)]);
            } else {
                ring.push(self.start(at, self.distance_mm));
            }
        }
        Moved::Joined(ring)
    }

    /// Appends the corners of lines that touch an arc around the corner where an edge starts.
    fn push_arc(&self, at: usize, ring: &mut Vec<Vector>) {
        let edge = &self.edges[at];
        let before = &self.edges[edge.before];
        let radius = self.distance_mm;
        let cosine = dot(before.along, edge.along);
        let turn = libm::atan2(cross(before.along, edge.along).abs(), cosine);
        // A corner of two tangents at an angle of a is outside by r (1 / cos(a / 2) - 1).
        let step = 2.0 * libm::acos(radius / (radius + self.tolerance_mm));
        let count = (turn / step.min(std::f64::consts::FRAC_PI_2)).ceil().max(1.0);
        let reach = radius / libm::cos(turn / (2.0 * count));
        for number in 0..count as usize {
            let angle = -self.side * turn * (number as f64 + 0.5) / count;
            let (sine, cosine) = libm::sincos(angle);
            let [x, y] = before.normal;
            let direction = [x * cosine - y * sine, x * sine + y * cosine];
            ring.push([0, 1].map(|k| edge.corner[k] + reach * direction[k]));
        }
    }
}

/// Movement of the intersection of two edges for each mm by which they move; `None` if they turn
/// back.
fn meeting(before: &Edge, after: &Edge) -> Option<Vector> {
    let sum = 1.0 + dot(before.along, after.along);
    (sum > REVERSAL).then(|| [0, 1].map(|k| (before.normal[k] + after.normal[k]) / sum))
}

fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn distance(a: Vector, b: Vector) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
