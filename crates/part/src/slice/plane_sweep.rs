//! Cuts a closed surface by the horizontal planes through the centre of every layer.
//!
//! Three steps make the outline of one layer: find the triangles that the plane meets, intersect
//! each with the plane to a [`Segment`], and link the segments into closed loops.
//!
//! # No tolerances
//! A vertex exactly on the plane counts as above it, so every vertex is on one of two sides and no
//! special case remains.
//! A triangle with vertices on both sides has exactly two edges that change sides, and meets the
//! plane in one segment from one of these edges to the other; all other triangles are missed.
//! A segment's ends are identified by those *edges*, as pairs of vertex numbers, not by
//! coordinates.
//! Both triangles at an edge name it alike, so linking compares integers and never has to decide
//! whether two points are close enough.
//!
//! On a closed surface, an edge is traversed by its triangles as often in one direction as in the
//! other.
//! Hence as many segments begin on an edge as end there, linking never runs into a dead end, and
//! all loops close, however bad the triangles are: slivers, overlapping shells, edges with four
//! triangles.
//!
//! # Sweep
//! The plane is swept upwards.
//! Triangles are sorted by the first plane that meets them; the sweep keeps a list of active
//! triangles, drops those that end below the plane and adds those that begin at it.
//! So the cost of a layer depends on the triangles it meets and not on the size of the mesh.

use std::ops::Range;

use beadwork_base::{Control, Interrupted, Threads};
use beadwork_mesh::Mesh;

use super::outline::Outline;
use super::work::Work;

/// Height of the plane through the centre of a layer, in mm.
pub(super) fn plane_mm(layer: usize, layer_mm: f64) -> f64 {
    (layer as f64 + 0.5) * layer_mm
}

/// Cuts a closed surface into `layers` layers of height `layer_mm`, from z = 0 upwards, and returns
/// one outline for each layer.
///
/// `colours` holds one number for each triangle, which the line that the triangle contributes to an
/// outline inherits; it may be empty.
/// Outlines of a surface that is not closed may lack lines; [`beadwork_mesh::Body::repair`] closes
/// surfaces.
///
/// Progress counts layers.
/// For n triangles and s segments in all layers the time is O(n + s log s); memory is 8 bytes per
/// triangle and another 4 per triangle and thread, besides the outlines.
///
/// # Errors
/// Only if interrupted.
///
/// # Panics
/// If there are colours, but not one for every triangle.
pub fn cut(
    mesh: &Mesh,
    colours: &[u8],
    layer_mm: f64,
    layers: usize,
    control: &Control<'_>,
) -> Result<Vec<Outline>, Interrupted> {
    cut_between(mesh, colours, layer_mm, 0..layers, &Work::new(control, layers))
}

/// [`cut`] for a range of layers; a unit of work is a layer.
pub(super) fn cut_between(
    mesh: &Mesh,
    colours: &[u8],
    layer_mm: f64,
    layers: Range<usize>,
    work: &Work<'_>,
) -> Result<Vec<Outline>, Interrupted> {
    assert!(
        colours.is_empty() || colours.len() == mesh.triangles().len(),
        "there is one colour for each triangle"
    );
    let sweep = Sweep::new(mesh, layer_mm, layers.clone());
    let blocks = block_count(work.control().threads);
    let bound = |block: usize| layers.len() * block / blocks;
    let outlines = work
        .control()
        .threads
        .map_numbers(blocks, |block| sweep.block(colours, bound(block)..bound(block + 1), work));
    Ok(outlines.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
}

/// Number of blocks of consecutive layers that are swept independently.
///
/// Layers take unequal time, so each thread gets several blocks; not many, because every block
/// looks once at all triangles that begin below it.
fn block_count(threads: Threads<'_>) -> usize {
    match threads.count() {
        1 => 1,
        count => 4 * count,
    }
}

/// The triangles of a mesh, sorted by the first plane that meets them.
struct Sweep<'a> {
    mesh: &'a Mesh,
    layer_mm: f64,
    /// Number of the lowest layer of the sweep; all other layer numbers here are relative to it.
    first: usize,
    /// `order[starts[layer]..starts[layer + 1]]` are the triangles that `layer` meets first.
    /// It has two entries more than there are layers: those at the end delimit the triangles that
    /// no plane meets, which `order` leaves out.
    starts: Vec<u32>,
    /// Triangle numbers.
    order: Vec<u32>,
}

impl<'a> Sweep<'a> {
    /// Sorts the triangles by counting: linear in triangles and layers.
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
        let (low, high) = self.z_range_mm(triangle);
        let guess = (low / self.layer_mm - 0.5).ceil() - self.first as f64;
        let guess = guess.clamp(0.0, layers as f64) as usize;
        // The division may round to a neighbour of the right layer; comparing with the plane, as
        // `segment` does, decides.
        let near = guess.saturating_sub(1)..(guess + 2).min(layers);
        let first = near.into_iter().find(|&layer| self.plane_mm(layer) > low);
        first.filter(|&layer| self.plane_mm(layer) <= high).unwrap_or(layers)
    }

    fn plane_mm(&self, layer: usize) -> f64 {
        plane_mm(self.first + layer, self.layer_mm)
    }

    /// Minimum and maximum z of a triangle.
    fn z_range_mm(&self, triangle: u32) -> (f64, f64) {
        let [a, b, c] =
            self.mesh.corners(self.mesh.triangles()[triangle as usize]).map(|corner| corner[2]);
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// The outlines of a block of layers.
    fn block(
        &self,
        colours: &[u8],
        layers: Range<usize>,
        work: &Work<'_>,
    ) -> Result<Vec<Outline>, Interrupted> {
        let started = |layer: usize| self.starts[layer] as usize;
        // The active triangles of the block below are not at hand: find those that begin below this
        // block and reach into it.
        let below = &self.order[..started(layers.start)];
        let lowest = self.plane_mm(layers.start);
        let mut active: Vec<u32> = below
            .iter()
            .copied()
            .filter(|&triangle| self.z_range_mm(triangle).1 >= lowest)
            .collect();
        let mut outlines = Vec::with_capacity(layers.len());
        let mut segments = Vec::new();
        for layer in layers {
            let outline = work.unit(|| {
                let plane = self.plane_mm(layer);
                active.retain(|&triangle| self.z_range_mm(triangle).1 >= plane);
                active.extend(&self.order[started(layer)..started(layer + 1)]);
                segments.clear();
                segments.extend(active.iter().map(|&triangle| segment(self.mesh, triangle, plane)));
                link(self.mesh, &mut segments, colours, plane)
            })?;
            outlines.push(outline);
        }
        Ok(outlines)
    }
}

/// The line in which a triangle meets the plane: it runs from one edge of the triangle to another,
/// with the inside of the body on its left.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Segment {
    from: Edge,
    to: Edge,
    triangle: u32,
}

/// An edge as its two vertex numbers, the lower one first, so that all its triangles name it alike.
type Edge = [u32; 2];

/// The segment of a triangle that the plane meets.
fn segment(mesh: &Mesh, triangle: u32, plane: f64) -> Segment {
    let corners = mesh.triangles()[triangle as usize];
    let is_above = corners.map(|vertex| mesh.vertices()[vertex as usize][2] >= plane);
    let mut ends = [[0; 2]; 2];
    for corner in 0..3 {
        let next = (corner + 1) % 3;
        if is_above[corner] != is_above[next] {
            // Corners run counter-clockwise seen from outside: down on the left, up on the right.
            // A body seen from outside lies to the left of a walk from left to right.
            // So the segment begins on the edge that goes down and ends on the one that goes up.
            let edge = [corners[corner].min(corners[next]), corners[corner].max(corners[next])];
            ends[usize::from(is_above[next])] = edge;
        }
    }
    Segment { from: ends[0], to: ends[1], triangle }
}

/// Intersection of an edge with the plane: x and y in mm.
/// Its vertices come in the same order from all triangles, so the result is the same to the bit.
fn point([low, high]: Edge, mesh: &Mesh, plane: f64) -> [f64; 2] {
    let (a, b) = (mesh.vertices()[low as usize], mesh.vertices()[high as usize]);
    let part = (plane - a[2]) / (b[2] - a[2]);
    [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]))
}

/// Links segments into closed loops: O(s log s) for s segments.
fn link(mesh: &Mesh, segments: &mut [Segment], colours: &[u8], plane: f64) -> Outline {
    // Sorting groups the segments that begin on the same edge, so that a binary search finds them.
    // It also makes the result independent of the order in which the sweep found the triangles.
    segments.sort_unstable();
    let first_from = |edge: Edge| segments.partition_point(|segment| segment.from < edge);
    // At the first segment of each group, the number of segments of the group that are used up.
    let mut used = vec![0_usize; segments.len()];
    let mut outline = Outline::default();
    for begin in 0..segments.len() {
        // Follows segments until no unused one begins on the edge that was reached.
        // On a closed surface that is the edge where the loop began: each other edge has a segment
        // out for every segment in.
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
            let colour = colours.get(segment.triangle as usize).copied();
            outline.push(point(at, mesh, plane), colour);
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
