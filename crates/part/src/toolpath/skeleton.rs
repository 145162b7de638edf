//! Skeletons: beads of varying width along walls and gaps that are too thin for insets and infill.
//!
//! A skeleton follows the medial axis, the centres of the largest discs that fit into an area; its
//! width is twice the distance to the outline.
//! The boundary is cut into short segments, and the axis is the dual graph of their constrained
//! Delaunay triangulation, whose nodes are then moved to where two segments are equally near.
//! The triangulation has exact predicates: it exists for any points, and its dual graph has the
//! topology of the area, however thin that is.
//! (A Voronoi diagram of segments needs no samples, but its known implementations fail or do not
//! end on some inputs.)
//!
//! Branches into corners of the outline are removed: at the end of a wall the axis splits into two
//! of them, and the skeleton continues straight ahead instead.
//! Where three or more walls meet, the two that are most nearly opposite are joined, and the others
//! end at the edge of their bead.

mod axis;
mod boundary;
mod finish;
mod prune;
#[cfg(test)]
mod tests;
mod trace;
mod vector;

use beadwork_gcode::Feature;

use self::axis::Axis;
use self::boundary::Boundary;
use self::finish::finish;
use self::prune::Graph;
use self::trace::trace;
use self::vector::{add_scaled, distance, lerp};
use crate::area::Area;
use crate::bead::{Bead, ExtrusionMove};

/// Smallest width in mm that is considered; below, nothing can be printed.
const MIN_WIDTH_MM: f64 = 0.02;
/// Distance in mm up to which the boundary is searched around the axis.
const MAX_SEARCH_MM: f64 = 10.0;
/// Width of a move to that of the next one within a line whose width changes, at most about this.
const WIDTH_STEP: f64 = 0.1;

/// Which skeletons are made.
///
/// Construct it with `..SkeletonSettings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonSettings {
    /// Width in mm below which nothing is printed: 0.2.
    /// Values below 0.02 count as 0.02.
    pub min_width_mm: f64,
    /// Width in mm of the bead where the area is wider: 0.8.
    /// Values below the minimum count as the minimum.
    pub max_width_mm: f64,
    /// Length in mm below which a skeleton is dropped: 0.2.
    pub min_length_mm: f64,
    /// Deviation in mm of the points that are left out: 0.005.
    /// Values below 0.0001 count as 0.0001.
    pub tolerance_mm: f64,
}

impl Default for SkeletonSettings {
    fn default() -> Self {
        Self { min_width_mm: 0.2, max_width_mm: 0.8, min_length_mm: 0.2, tolerance_mm: 0.005 }
    }
}

/// A line that follows the middle of a wall or a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    /// Its points in mm, at least two; a closed one does not repeat the first point.
    pub points: Vec<[f64; 2]>,
    /// Width of the strip at each point in mm, linear in between.
    pub widths_mm: Vec<f64>,
    /// Whether the last point is joined to the first one.
    pub is_closed: bool,
}

/// The skeletons of an area.
///
/// Parts narrower than the minimum width are left out, and the ends of tapered parts.
/// In parts wider than the maximum width, one bead of that width runs along the middle, and the
/// rest is left empty.
/// Lines do not cross each other; widths are within both limits.
/// A strip stays within the area, except that within about a bead's width of an end or a junction a
/// corner of it may protrude.
///
/// The time grows with n log n, where n is the number of corners plus the perimeter divided by half
/// the minimum width.
/// Parts that are wider than four times the maximum width, or 20 mm, are followed only roughly.
///
/// # Example
/// ```
/// use beadwork_part::Area;
/// use beadwork_part::slice::FillRule;
/// use beadwork_part::toolpath::{SkeletonSettings, skeletons};
///
/// let wall = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 0.5], [0.0, 0.5]];
/// let area = Area::from_rings(&[wall], FillRule::NonZero);
/// let found = skeletons(&area, &SkeletonSettings::default());
/// assert_eq!(found.len(), 1);
/// assert!((found[0].length_mm() - 10.0).abs() < 0.1);
/// assert!(found[0].widths_mm.iter().all(|width| (width - 0.5).abs() < 0.001));
/// ```
pub fn skeletons(area: &Area, settings: &SkeletonSettings) -> Vec<Skeleton> {
    // `max` also replaces NaN.
    let min_width_mm = settings.min_width_mm.max(MIN_WIDTH_MM);
    let settings = SkeletonSettings {
        min_width_mm,
        max_width_mm: settings.max_width_mm.max(min_width_mm),
        min_length_mm: settings.min_length_mm.max(0.0),
        tolerance_mm: settings.tolerance_mm.max(1e-4),
    };
    let mut found = Vec::new();
    for rings in area.components() {
        let Some(boundary) = Boundary::new(rings, min_width_mm / 2.0) else { continue };
        let axis = Axis::new(&boundary, (2.0 * settings.max_width_mm).min(MAX_SEARCH_MM));
        let graph = Graph::new(&axis, min_width_mm / 2.0);
        for line in trace(&graph, settings.max_width_mm / 2.0) {
            let points = finish(&line, &boundary, &settings);
            if points.is_empty() {
                continue;
            }
            found.push(Skeleton {
                points: points.iter().map(|p| add_scaled(boundary.origin, p.0, 1.0)).collect(),
                widths_mm: points.iter().map(|p| p.1).collect(),
                is_closed: line.is_closed,
            });
        }
    }
    found
}

impl Skeleton {
    /// Length in mm.
    pub fn length_mm(&self) -> f64 {
        self.lines().map(|[from, to]| distance(from.0, to.0)).sum()
    }

    /// Area of the strip in mm²: the sum of length times mean width.
    pub fn area_mm2(&self) -> f64 {
        self.lines().map(|[from, to]| distance(from.0, to.0) * (from.1 + to.1) / 2.0).sum()
    }

    /// The bead that prints it, whose moves have one width each.
    ///
    /// Lines whose width changes are split into moves with steps of about a tenth of the width; the
    /// area of the strip stays the same.
    pub fn bead(&self, tool: u8, feature: Feature) -> Bead {
        let mut moves = Vec::new();
        for [from, to] in self.lines() {
            let change = (to.1 - from.1).abs() / (WIDTH_STEP * from.1.min(to.1));
            // A width is at least a hundredth of another one, as a rule.
            let count = change.ceil().clamp(1.0, 1000.0);
            moves.extend((1..=count as usize).map(|i| ExtrusionMove {
                to_mm: lerp(from.0, to.0, i as f64 / count),
                width_mm: from.1 + (to.1 - from.1) * (i as f64 - 0.5) / count,
                feature,
            }));
        }
        Bead { tool, start_mm: self.points.first().copied().unwrap_or_default(), moves }
    }

    /// The points and widths at both ends of each line.
    fn lines(&self) -> impl Iterator<Item = [([f64; 2], f64); 2]> {
        let at = |i: usize| (self.points[i], self.widths_mm[i]);
        let count = self.points.len();
        let lines = if self.is_closed { count } else { count.saturating_sub(1) };
        (0..lines).map(move |i| [at(i), at((i + 1) % count)])
    }
}
