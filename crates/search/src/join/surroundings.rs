//! What lies near a point: loops within reach, and whether a step to them is clear.

use super::bead::{Line, Position};
use super::geometry::{crosses, distance2, nearest_on_segment};
use crate::segment::{Segment, SegmentGrid, are_near};

/// Distance in mm below which points are the same: outlines are rounded to less.
const SAME_MM: f64 = 1e-4;

/// Loops and outline, with a spatial index of their edges.
pub(super) struct Rings {
    /// Distances and steps in mm.
    reach_mm: f64,
    clearance_mm: f64,
    grid: SegmentGrid,
    /// For each segment of the grid the number of its loop, `None` for the outline, and its own
    /// number in it.
    edges: Vec<(Option<u32>, u32)>,
    /// For each loop, points along it.
    samples: Vec<Vec<Position>>,
}

/// Loops, outline and chains, which steps do not cross.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    rings: &'a Rings,
    /// The chains, if they are known.
    chains: Option<&'a Chains>,
}

/// Chains with a spatial index of their edges.
pub(super) struct Chains {
    grid: SegmentGrid,
    /// For each segment of the grid the number of its chain, and its own number in it.
    edges: Vec<(u32, u32)>,
}

impl Chains {
    pub(super) fn new(chains: &[&[[f64; 2]]], reach_mm: f64) -> Self {
        let mut segments = Vec::new();
        let mut edges = Vec::new();
        for (chain, number) in chains.iter().zip(0..) {
            segments.extend(chain.windows(2).map(|pair| [pair[0], pair[1]]));
            edges.extend((0..chain.len().saturating_sub(1) as u32).map(|edge| (number, edge)));
        }
        Self { grid: SegmentGrid::new(segments, reach_mm), edges }
    }
}

impl Rings {
    pub(super) fn new(
        loops: &[&[[f64; 2]]],
        outline: &[&[[f64; 2]]],
        reach_mm: f64,
        clearance_mm: f64,
    ) -> Self {
        let mut segments = Vec::new();
        let mut edges = Vec::new();
        let numbered = (0..).map(Some).zip(loops.iter());
        for (number, ring) in numbered.chain(outline.iter().map(|ring| (None, ring))) {
            segments.extend((0..ring.len()).map(|edge| ends(ring, edge)));
            edges.extend((0..ring.len() as u32).map(|edge| (number, edge)));
        }
        let grid = SegmentGrid::new(segments, reach_mm);
        let samples = loops.iter().map(|ring| samples(ring, reach_mm)).collect();
        Self { reach_mm, clearance_mm, grid, edges, samples }
    }

    pub(super) fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    /// What lies around steps, with the chains if they are known.
    pub(super) fn with<'a>(&'a self, chains: Option<&'a Chains>) -> Surroundings<'a> {
        Surroundings { rings: self, chains }
    }
}

impl<'a> Surroundings<'a> {
    pub(super) fn reach_mm(&self) -> f64 {
        self.rings.reach_mm
    }

    pub(super) fn loop_count(&self) -> usize {
        self.rings.samples.len()
    }

    /// Points along a loop, about `reach` apart.
    pub(super) fn samples(&self, number: usize) -> &'a [Position] {
        &self.rings.samples[number]
    }

    /// Calls `visit` with each edge of a loop within reach of a point: the loop, the point of the
    /// edge nearest to it, and the square of its distance.
    fn for_each_near(&self, point_mm: [f64; 2], mut visit: impl FnMut(usize, Position, f64)) {
        let reach2 = self.rings.reach_mm * self.rings.reach_mm;
        self.rings.grid.any_near([point_mm; 2], self.rings.reach_mm, |segment| {
            if let (Some(number), edge) = self.rings.edges[segment as usize] {
                let [a, b] = self.rings.grid.segments()[segment as usize];
                let nearest = nearest_on_segment(point_mm, a, b);
                let length2 = distance2(point_mm, nearest);
                if length2 <= reach2 {
                    let on_loop = Position { edge: edge as usize, point_mm: nearest };
                    visit(number as usize, on_loop, length2);
                }
            }
            false
        });
    }

    /// The loops within reach of a point, in ascending order: for each the nearest point of it, if
    /// the step to it is clear.
    pub(super) fn loops_near(&self, point_mm: [f64; 2]) -> Vec<(usize, Position)> {
        let mut near: Vec<(usize, Position, f64)> = Vec::new();
        self.for_each_near(point_mm, |number, on_loop, length2| {
            match near.iter_mut().find(|near| near.0 == number) {
                Some(best) => {
                    if is_nearer((length2, on_loop.edge), (best.2, best.1.edge)) {
                        *best = (number, on_loop, length2);
                    }
                }
                None => near.push((number, on_loop, length2)),
            }
        });
        near.retain(|near| self.is_clear(point_mm, near.1.point_mm));
        near.sort_unstable_by_key(|near| near.0);
        near.into_iter().map(|(number, on_loop, _)| (number, on_loop)).collect()
    }

    /// The loops within reach of a point, whatever lies between; a loop may be repeated.
    pub(super) fn loops_within(&self, point_mm: [f64; 2]) -> Vec<usize> {
        let mut found = Vec::new();
        self.for_each_near(point_mm, |number, _, _| found.push(number));
        found
    }

    /// All loops and chains within reach of a point, whatever lies between, sorted: for each the
    /// nearest point.
    pub(super) fn lines_near(&self, point_mm: [f64; 2]) -> Vec<(Line, Position)> {
        let mut near: Vec<(Line, f64, Position)> = Vec::new();
        self.for_each_near(point_mm, |ring, position, length2| {
            near.push((Line::Loop(ring), length2, position));
        });
        if let Some(Chains { grid, edges }) = self.chains {
            grid.any_near([point_mm; 2], self.reach_mm(), |segment| {
                let [a, b] = grid.segments()[segment as usize];
                let nearest = nearest_on_segment(point_mm, a, b);
                let length2 = distance2(point_mm, nearest);
                if length2 <= self.reach_mm() * self.reach_mm() {
                    let (chain, edge) = edges[segment as usize];
                    let position = Position { edge: edge as usize, point_mm: nearest };
                    near.push((Line::Chain(chain as usize), length2, position));
                }
                false
            });
        }
        near.sort_unstable_by(|a, b| {
            let by_line = a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            by_line.then(a.2.edge.cmp(&b.2.edge))
        });
        near.dedup_by_key(|near| near.0);
        near.into_iter().map(|(line, _, position)| (line, position)).collect()
    }

    /// All pairs of a loop and a chain with points within reach of each other, whatever lies
    /// between.
    pub(super) fn near_chains(&self) -> Vec<[usize; 2]> {
        let Some(Chains { grid, edges }) = self.chains else { return Vec::new() };
        let chains = edges.iter().map(|&(chain, _)| chain);
        self.pairs(grid.segments().iter().copied().zip(chains), |_, _| true)
    }

    /// All pairs of loops with points within reach of each other, whatever lies between.
    pub(super) fn near_pairs(&self) -> Vec<[usize; 2]> {
        let edges = self.rings.grid.segments().iter().zip(&self.rings.edges);
        let edges = edges.filter_map(|(&segment, &(ring, _))| Some((segment, ring?)));
        self.pairs(edges, |ring, other| ring < other)
    }

    /// All pairs of a loop and the number of a segment within reach of each other, sorted; only
    /// those that are wanted are measured.
    fn pairs(
        &self,
        segments: impl Iterator<Item = (Segment, u32)>,
        is_wanted: impl Fn(u32, u32) -> bool,
    ) -> Vec<[usize; 2]> {
        let Rings { grid, edges, reach_mm, .. } = self.rings;
        let mut found = Vec::new();
        for (segment, number) in segments {
            grid.any_near(segment, *reach_mm, |other| {
                if let (Some(ring), _) = edges[other as usize]
                    && is_wanted(ring, number)
                    && found.last() != Some(&[ring as usize, number as usize])
                    && are_near(segment, grid.segments()[other as usize], *reach_mm)
                {
                    found.push([ring as usize, number as usize]);
                }
                false
            });
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The nearest point of a loop, if it is within reach of a point and the step to it is clear.
    pub(super) fn nearest(&self, number: usize, point_mm: [f64; 2]) -> Option<Position> {
        let mut best: Option<(Position, f64)> = None;
        self.for_each_near(point_mm, |other, on_loop, length2| {
            let is_better = other == number
                && best
                    .is_none_or(|best| is_nearer((length2, on_loop.edge), (best.1, best.0.edge)));
            if is_better {
                best = Some((on_loop, length2));
            }
        });
        let (on_loop, _) = best?;
        self.is_clear(point_mm, on_loop.point_mm).then_some(on_loop)
    }

    /// Whether a step is short enough and clear.
    pub(super) fn is_step(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        distance2(from, to) <= self.rings.reach_mm * self.rings.reach_mm && self.is_clear(from, to)
    }

    /// Whether the straight line between two points properly crosses neither the outline nor loops
    /// nor chains, and keeps the clearance from the outline, or the distance of its ends if they
    /// are nearer.
    fn is_clear(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let crosses_any = |grid: &SegmentGrid| {
            let crosses =
                |segment: u32| crosses([from, to], grid.segments()[segment as usize], SAME_MM);
            grid.any_near([from, to], SAME_MM, crosses)
        };
        if crosses_any(&self.rings.grid)
            || self.chains.is_some_and(|chains| crosses_any(&chains.grid))
        {
            return false;
        }
        let ends_mm = self.outline_distance_mm([from; 2]).min(self.outline_distance_mm([to; 2]));
        self.outline_distance_mm([from, to]) >= ends_mm - SAME_MM
    }

    /// Distance of a segment that does not cross the outline from the outline, at most the
    /// clearance, in mm.
    fn outline_distance_mm(&self, [from, to]: Segment) -> f64 {
        let mut best2 = self.rings.clearance_mm * self.rings.clearance_mm;
        if best2 > 0.0 {
            self.rings.grid.any_near([from, to], self.rings.clearance_mm, |segment| {
                if self.rings.edges[segment as usize].0.is_none() {
                    // Two segments that do not cross are nearest at an end of one of them.
                    let [a, b] = self.rings.grid.segments()[segment as usize];
                    let near = |point, c, d| distance2(point, nearest_on_segment(point, c, d));
                    let nearest = near(from, a, b).min(near(to, a, b));
                    best2 = best2.min(nearest).min(near(a, from, to)).min(near(b, from, to));
                }
                false
            });
        }
        best2.sqrt()
    }
}

/// Whether an edge at a distance is preferred to another one; of equally near ones, the first.
fn is_nearer(a: (f64, usize), b: (f64, usize)) -> bool {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).is_lt()
}

/// Points along a ring: of its corners and of points between them, which are at most `reach` apart,
/// those that are not much nearer to each other.
fn samples(ring: &[[f64; 2]], reach_mm: f64) -> Vec<Position> {
    let mut found: Vec<Position> = Vec::new();
    for edge in 0..ring.len() {
        let [a, b] = ends(ring, edge);
        let count = (distance2(a, b).sqrt() / reach_mm).ceil().clamp(1.0, 1e4) as usize;
        for step in 0..count {
            let part = step as f64 / count as f64;
            let point_mm = [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]));
            let is_far =
                |last: &Position| distance2(last.point_mm, point_mm) > 0.25 * reach_mm * reach_mm;
            if found.last().is_none_or(is_far) {
                found.push(Position { edge, point_mm });
            }
        }
    }
    found
}

/// Both ends of an edge of a ring.
fn ends(ring: &[[f64; 2]], edge: usize) -> Segment {
    [ring[edge], ring[(edge + 1) % ring.len()]]
}
