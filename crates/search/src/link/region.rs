//! The region in which links may run.

use super::end::Point;
use crate::lists::Lists;
use crate::segment::{Segment, SegmentGrid, near_interval, point_at};

/// A region by the edges of its rings: the points that an odd number of rings enclose.
pub(super) struct Region {
    edges: SegmentGrid,
    /// For each of a number of horizontal bands the edges that reach into it.
    bands: Lists,
    band_count: usize,
    bottom: f64,
    band: f64,
}

impl Region {
    /// The region of rings, with a grid whose cells have about the given size in mm.
    pub(super) fn new(rings: &[Vec<Point>], cell: f64) -> Self {
        let edges: Vec<Segment> = rings.iter().flat_map(|ring| edges(ring)).collect();
        let heights = || edges.as_flattened().iter().map(|point| point[1]);
        let bottom = heights().fold(f64::INFINITY, f64::min);
        let extent = heights().fold(f64::NEG_INFINITY, f64::max) - bottom;
        // Bands as many as edges: few edges reach into more than a few.
        let total: f64 = edges.iter().map(|edge| (edge[0][1] - edge[1][1]).abs()).sum();
        let band = cell.max(extent / (edges.len() + 1) as f64).max(total / 1e6);
        let band_count = if edges.is_empty() { 0 } else { (extent / band) as usize + 1 };
        let number = |y: f64| (((y - bottom) / band) as usize).min(band_count.saturating_sub(1));
        let passes: Vec<(usize, u32)> = edges
            .iter()
            .enumerate()
            .flat_map(|(index, edge)| {
                let [a, b] = edge.map(|point| number(point[1]));
                (a.min(b)..=a.max(b)).map(move |band| (band, index as u32))
            })
            .collect();
        let bands = Lists::new(band_count, passes.into_iter());
        Self { edges: SegmentGrid::new(edges, cell), bands, band_count, bottom, band }
    }

    /// The edges, ring by ring.
    pub(super) fn edges(&self) -> &SegmentGrid {
        &self.edges
    }

    /// Whether the region contains a point that does not lie on its boundary.
    pub(super) fn contains(&self, [x, y]: Point) -> bool {
        if self.band_count == 0 || y < self.bottom {
            return false;
        }
        let band = (((y - self.bottom) / self.band) as usize).min(self.band_count - 1);
        let is_left_of = |&&number: &&u32| {
            let [a, b] = self.edges.segments()[number as usize];
            (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        self.bands.list(band).iter().filter(is_left_of).count() % 2 == 1
    }

    /// Whether each point of a segment lies in the region or within a tolerance of its boundary.
    pub(super) fn contains_segment(&self, segment: Segment, tolerance: f64) -> bool {
        let mut near: Vec<[f64; 2]> = Vec::new();
        self.edges.any_near(segment, tolerance, |number| {
            let edge = self.edges.segments()[number as usize];
            let interval = near_interval(segment, edge, tolerance);
            if interval[0] <= interval[1] {
                near.push(interval);
            }
            false
        });
        near.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        near.push([1.0; 2]);
        // Between the intervals the segment does not meet the boundary.
        let mut covered = 0.0;
        for [from, to] in near {
            let middle = f64::midpoint(covered, from);
            if from > covered + 1e-9 && !self.contains(point_at(segment, middle)) {
                return false;
            }
            covered = to.max(covered);
        }
        true
    }
}

/// The edges of a ring.
pub(super) fn edges(ring: &[Point]) -> impl Iterator<Item = Segment> {
    (0..ring.len()).map(|index| [ring[index], ring[(index + 1) % ring.len()]])
}
