//! Cuts a surface by the horizontal planes through the middle of every layer.
//!
//! Nothing is compared with a tolerance.
//! A vertex on a plane counts as above it, so a plane meets a triangle in nothing or in one segment
//! between two of its edges; segments are linked by the edges they end on, which are the same for
//! both triangles there.
//! On a closed surface every link is found, and outlines close, however bad the triangles are:
//! needles, overlaps, edges with four triangles.
//!
//! Planes are swept upwards past triangles sorted by the plane they meet first, so a layer costs
//! what it holds, not what the mesh holds.

use std::ops::Range;

use rayon::ThreadPool;

use super::each::each;
use super::outline::Outline;
use beadwork_mesh::Mesh;

/// Height of the plane through the middle of a layer, in mm.
pub(super) fn plane_mm(layer: usize, layer_mm: f64) -> f64 {
    (layer as f64 + 0.5) * layer_mm
}

/// The outlines of a closed surface in `layers` layers of `layer_mm`, from z = 0 upwards; one for
/// each layer.
///
/// `paint` holds one number for each triangle, which its part of an outline takes over, or nothing.
/// Outlines of a surface that is not closed ([`beadwork_mesh::Body::repair`] sees to that) may miss
/// lines.
///
/// Works in `pool`, or in the calling thread alone; the result does not depend on it.
/// For n triangles, and s segments in all layers: O(n + s log s) time; beside the outlines 8 bytes
/// a triangle, and 4 more for each thread.
///
/// # Panics
/// If there is paint, but not for every triangle.
pub fn cut(
    mesh: &Mesh,
    paint: &[u8],
    layer_mm: f64,
    layers: usize,
    pool: Option<&ThreadPool>,
) -> Vec<Outline> {
    cut_between(mesh, paint, layer_mm, 0..layers, pool)
}

/// The same for some layers only.
pub(super) fn cut_between(
    mesh: &Mesh,
    paint: &[u8],
    layer_mm: f64,
    layers: Range<usize>,
    pool: Option<&ThreadPool>,
) -> Vec<Outline> {
    assert!(paint.is_empty() || paint.len() == mesh.triangles().len(), "one number a triangle");
    let sweep = Sweep::new(mesh, layer_mm, layers.clone());
    // A few for each thread, for layers take unequal time; not many, for each looks at all
    // triangles below it once.
    let threads = pool.map_or(1, ThreadPool::current_num_threads);
    let blocks = if threads == 1 { 1 } else { 4 * threads };
    let bound = |block: usize| layers.len() * block / blocks;
    each(pool, blocks, |block| sweep.block(paint, bound(block)..bound(block + 1))).concat()
}

/// Triangles in the order of the first plane that meets them.
struct Sweep<'a> {
    mesh: &'a Mesh,
    layer_mm: f64,
    /// Number of the first layer, from which layers are counted here.
    first: usize,
    /// For each layer where the triangles that it meets first begin in `order`; one more for those
    /// that no plane meets, and their end.
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl<'a> Sweep<'a> {
    fn new(mesh: &'a Mesh, layer_mm: f64, layers: Range<usize>) -> Self {
        let Range { start: first, end } = layers;
        let layers = end - first;
        let mut sweep =
            Self { mesh, layer_mm, first, starts: vec![0; layers + 2], order: Vec::new() };
        let triangles = 0..mesh.triangles().len() as u32;
        let firsts: Vec<u32> =
            triangles.map(|triangle| sweep.first_layer(triangle, layers) as u32).collect();
        firsts.iter().for_each(|&layer| sweep.starts[layer as usize + 1] += 1);
        for layer in 1..sweep.starts.len() {
            sweep.starts[layer] += sweep.starts[layer - 1];
        }
        sweep.order.resize(sweep.starts[layers] as usize, 0);
        let mut next = sweep.starts.clone();
        for (triangle, &layer) in
            (0..).zip(&firsts).filter(|&(_, &layer)| (layer as usize) < layers)
        {
            sweep.order[next[layer as usize] as usize] = triangle;
            next[layer as usize] += 1;
        }
        sweep
    }

    /// The lowest layer whose plane meets a triangle, or `layers` if none does.
    fn first_layer(&self, triangle: u32, layers: usize) -> usize {
        let (low, high) = self.range_mm(triangle);
        let guess = (low / self.layer_mm - 0.5).ceil() - self.first as f64;
        let guess = guess.clamp(0.0, layers as f64) as usize;
        // The quotient may be off by its rounding; the plane itself decides.
        let near = guess.saturating_sub(1)..(guess + 2).min(layers);
        let first = near.into_iter().find(|&layer| self.plane_mm(layer) > low);
        first.filter(|&layer| self.plane_mm(layer) <= high).unwrap_or(layers)
    }

    fn plane_mm(&self, layer: usize) -> f64 {
        plane_mm(self.first + layer, self.layer_mm)
    }

    /// Least and greatest z of a triangle.
    fn range_mm(&self, triangle: u32) -> (f64, f64) {
        let [a, b, c] =
            self.mesh.corners(self.mesh.triangles()[triangle as usize]).map(|corner| corner[2]);
        (a.min(b).min(c), a.max(b).max(c))
    }

    fn block(&self, paint: &[u8], layers: Range<usize>) -> Vec<Outline> {
        let started = |layer: usize| self.starts[layer] as usize;
        // Those from below that still reach in.
        let below = &self.order[..started(layers.start)];
        let least = self.plane_mm(layers.start);
        let mut active: Vec<u32> =
            below.iter().copied().filter(|&triangle| self.range_mm(triangle).1 >= least).collect();
        let mut outlines = Vec::with_capacity(layers.len());
        let mut segments = Vec::new();
        for layer in layers {
            let plane = self.plane_mm(layer);
            active.retain(|&triangle| self.range_mm(triangle).1 >= plane);
            active.extend(&self.order[started(layer)..started(layer + 1)]);
            segments.clear();
            segments.extend(active.iter().map(|&triangle| segment(self.mesh, triangle, plane)));
            outlines.push(link(self.mesh, &mut segments, paint, plane));
        }
        outlines
    }
}

/// The part of an outline that lies on one triangle: from one of its edges to another, the body on
/// its left.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Segment {
    from: Edge,
    to: Edge,
    triangle: u32,
}

/// An edge by its two vertices, the lower number first: the same for all its triangles.
type Edge = [u32; 2];

/// The segment of a triangle that the plane meets.
fn segment(mesh: &Mesh, triangle: u32, plane: f64) -> Segment {
    let corners = mesh.triangles()[triangle as usize];
    let is_above = corners.map(|vertex| mesh.vertices()[vertex as usize][2] >= plane);
    let mut ends = [[0; 2]; 2];
    for corner in 0..3 {
        let next = (corner + 1) % 3;
        if is_above[corner] != is_above[next] {
            // Seen from outside, the edge on which the triangle's outline comes down is on the
            // left.
            let edge = [corners[corner].min(corners[next]), corners[corner].max(corners[next])];
            ends[usize::from(is_above[next])] = edge;
        }
    }
    Segment { from: ends[0], to: ends[1], triangle }
}

/// Where an edge meets the plane: x and y in mm, to the bit the same for all its triangles.
fn point([low, high]: Edge, mesh: &Mesh, plane: f64) -> [f64; 2] {
    let (a, b) = (mesh.vertices()[low as usize], mesh.vertices()[high as usize]);
    let part = (plane - a[2]) / (b[2] - a[2]);
    [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]))
}

/// Links segments to closed outlines.
fn link(mesh: &Mesh, segments: &mut [Segment], paint: &[u8], plane: f64) -> Outline {
    // Sorted, they can be found by where they begin; and the outline does not depend on how the
    // sweep came to them.
    segments.sort_unstable();
    let first_from = |edge: Edge| segments.partition_point(|segment| segment.from < edge);
    // For the first segment from each edge, how many from there are used.
    let mut used = vec![0_usize; segments.len()];
    let mut outline = Outline::default();
    for begin in 0..segments.len() {
        let mut at = segments[begin].from;
        let mut is_new = false;
        loop {
            let first = first_from(at);
            let Some(segment) = used.get(first).and_then(|&used| segments.get(first + used)) else {
                break;
            };
            if segment.from != at {
                break;
            }
            used[first] += 1;
            let paint = paint.get(segment.triangle as usize).copied();
            outline.push(point(at, mesh, plane), paint);
            at = segment.to;
            is_new = true;
        }
        if is_new {
            outline.close();
        }
    }
    outline
}

#[cfg(test)]
mod tests;
