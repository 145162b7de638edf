//! What lies near a point: loops within reach, and whether a step to them is clear.

use rstar::RTree;
use rstar::primitives::{GeomWithData, Line};

use super::bead::OnLoop;
use super::geometry::{crosses, distance2, nearest_on_segment};
use super::solve::Input;

/// Distance in mm below which points are the same: outlines are rounded to less.
const SAME_MM: f64 = 1e-4;

/// An edge, with the number of its loop (`None` for the outline) and its own number in it.
type Edge = GeomWithData<Line<[f64; 2]>, (Option<usize>, usize)>;

/// Spatial index of loops and outline.
pub(super) struct Surroundings<'a> {
    input: &'a Input<'a>,
    reach_mm: f64,
    edges: RTree<Edge>,
}

impl<'a> Surroundings<'a> {
    pub(super) fn new(input: &'a Input<'a>, reach_mm: f64) -> Self {
        let edges = |number: Option<usize>, ring: &'a [[f64; 2]]| {
            (0..ring.len()).map(move |edge| {
                let [from, to] = ends(ring, edge);
                Edge::new(Line::new(from, to), (number, edge))
            })
        };
        let loops = input.loops.iter().enumerate();
        let loops = loops.flat_map(|(number, ring)| edges(Some(number), ring));
        let outline = input.outline.iter().flat_map(|ring| edges(None, ring));
        Self { input, reach_mm, edges: RTree::bulk_load(loops.chain(outline).collect()) }
    }

    /// The loops within reach of a point, in ascending order: for each the nearest point of it.
    pub(super) fn loops_near(&self, point_mm: [f64; 2]) -> Vec<(usize, OnLoop)> {
        let reach2 = self.reach_mm * self.reach_mm;
        let mut near: Vec<(usize, f64, OnLoop)> = self
            .edges
            .locate_within_distance(point_mm, reach2)
            .filter_map(|edge| {
                let (Some(number), at) = edge.data else { return None };
                let Line { from, to } = *edge.geom();
                let nearest = nearest_on_segment(point_mm, from, to);
                let on_loop = OnLoop { edge: at, point_mm: nearest };
                Some((number, distance2(point_mm, nearest), on_loop))
            })
            .collect();
        near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.edge.cmp(&b.2.edge)));
        near.dedup_by_key(|near| near.0);
        near.into_iter().map(|(number, _, on_loop)| (number, on_loop)).collect()
    }

    /// The nearest point of a loop, if it is within reach of a point and the step to it is clear.
    pub(super) fn nearest(&self, number: usize, point_mm: [f64; 2]) -> Option<OnLoop> {
        let near = self.loops_near(point_mm);
        let at = near.binary_search_by_key(&number, |near| near.0).ok()?;
        let on_loop = near[at].1;
        self.is_clear(point_mm, on_loop.point_mm).then_some(on_loop)
    }

    /// Whether a step is short enough and properly crosses neither the outline nor a loop.
    pub(super) fn is_step(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        distance2(from, to) <= self.reach_mm * self.reach_mm && self.is_clear(from, to)
    }

    /// Whether the straight line between two points properly crosses neither outline nor loops.
    fn is_clear(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let centre = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
        let radius2 = 0.25 * distance2(from, to) + SAME_MM * SAME_MM;
        let mut near = self.edges.locate_within_distance(centre, radius2);
        near.all(|edge| {
            let Line { from: c, to: d } = *edge.geom();
            !crosses([from, to], [c, d], SAME_MM)
        })
    }

    /// Points along a loop, at its corners and between them, at most `reach` apart.
    pub(super) fn samples(&self, number: usize) -> Vec<OnLoop> {
        let ring = self.input.loops[number];
        let sample = |edge: usize| {
            let [a, b] = ends(ring, edge);
            let count = (distance2(a, b).sqrt() / self.reach_mm).ceil().clamp(1.0, 1e4) as usize;
            (0..count).map(move |step| {
                let part = step as f64 / count as f64;
                let point_mm = [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]));
                OnLoop { edge, point_mm }
            })
        };
        (0..ring.len()).flat_map(sample).collect()
    }
}

/// Both ends of an edge of a ring.
fn ends(ring: &[[f64; 2]], edge: usize) -> [[f64; 2]; 2] {
    [ring[edge], ring[(edge + 1) % ring.len()]]
}
