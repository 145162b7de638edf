//! Loops and chains by their length.

use super::bead::Position;
use crate::segment::{Segment, length, point_at};

/// A loop or chain with the distance of each point from its beginning.
pub(super) struct Path {
    points: Vec<[f64; 2]>,
    /// Whether the last point is joined to the first.
    pub(super) is_loop: bool,
    /// Distance of each point from the first one along the path in mm; after them, for a loop, its
    /// length.
    at_mm: Vec<f64>,
}

impl Path {
    /// A path through points, at least one.
    pub(super) fn new(points: &[[f64; 2]], is_loop: bool) -> Self {
        let mut path =
            Self { points: points.to_vec(), is_loop, at_mm: Vec::with_capacity(points.len() + 1) };
        let mut sum = 0.0;
        path.at_mm.push(sum);
        for edge in 0..path.edge_count() {
            sum += length(path.edge(edge));
            path.at_mm.push(sum);
        }
        path
    }

    pub(super) fn edge_count(&self) -> usize {
        self.points.len() - usize::from(!self.is_loop)
    }

    pub(super) fn edge(&self, edge: usize) -> Segment {
        [self.points[edge], self.points[(edge + 1) % self.points.len()]]
    }

    /// Distances along the path of the ends of an edge.
    pub(super) fn edge_at_mm(&self, edge: usize) -> [f64; 2] {
        [self.at_mm[edge], self.at_mm[edge + 1]]
    }

    /// Length in mm.
    pub(super) fn length_mm(&self) -> f64 {
        self.at_mm[self.edge_count()]
    }

    /// The first and the last point of a chain.
    pub(super) fn chain_ends(&self) -> [Position; 2] {
        let last = self.points.len() - 1;
        [
            Position { edge: 0, point_mm: self.points[0] },
            Position { edge: last.saturating_sub(1), point_mm: self.points[last] },
        ]
    }

    /// The distance along a loop in 0..length, of any other one.
    pub(super) fn wrap(&self, at_mm: f64) -> f64 {
        let length = self.length_mm();
        if !self.is_loop || length <= 0.0 {
            return at_mm.clamp(0.0, length);
        }
        let wrapped = at_mm.rem_euclid(length);
        // Rounding may reach the length itself.
        if wrapped >= length { 0.0 } else { wrapped }
    }

    /// The point at a distance along the path.
    pub(super) fn position(&self, at_mm: f64) -> Position {
        let at_mm = self.wrap(at_mm);
        if self.edge_count() == 0 {
            return Position { edge: 0, point_mm: self.points[0] };
        }
        let after = self.at_mm.partition_point(|&corner| corner <= at_mm);
        let edge = after.saturating_sub(1).min(self.edge_count() - 1);
        let [from, to] = self.edge_at_mm(edge);
        let share = if to > from { ((at_mm - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        Position { edge, point_mm: point_at(self.edge(edge), share) }
    }

    /// Distance along the path of one of its points.
    pub(super) fn at_mm(&self, position: &Position) -> f64 {
        if self.edge_count() == 0 {
            return 0.0;
        }
        let [from, to] = self.edge_at_mm(position.edge);
        (from + length([self.points[position.edge], position.point_mm])).min(to)
    }

    /// Distance along the path between two of its points, the shorter way around a loop.
    pub(super) fn between_mm(&self, a_mm: f64, b_mm: f64) -> f64 {
        let apart = (a_mm - b_mm).abs();
        if self.is_loop { apart.min((self.length_mm() - apart).abs()) } else { apart }
    }
}
