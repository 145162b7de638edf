//! Fills the holes of a surface with fans of triangles.

use std::collections::HashMap;

use super::components::Components;
use super::edges::{Edges, is_rising};
use super::report::RepairError;
use crate::mesh::Mesh;
use crate::model::Body;
use crate::vector::{cross, dot, minus};
use crate::work::Work;

/// A hole is small if its perimeter is at most this share of the body's diagonal.
const SMALL_HOLE: f64 = 1.0;

/// A hole is flat if no corner deviates from its plane by more than this share of the body's
/// diagonal.
/// Flat holes may have any size.
const FLAT_HOLE: f64 = 1e-3;

/// A directed edge along a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct OpenEdge {
    from: u32,
    to: u32,
    /// The triangle on the other side of the edge.
    triangle: u32,
}

/// Fills all holes, or none if one of them is neither small nor flat; returns how many there are.
pub(super) fn close(
    body: &mut Body,
    edges: &Edges,
    components: &mut Components,
    work: &mut Work<'_>,
) -> Result<usize, RepairError> {
    let open = open_edges(&body.mesh, edges, work)?;
    if open.is_empty() {
        return Ok(0);
    }
    let loops = loops(&open);
    let mesh = &body.mesh;
    let diagonal = mesh.bounds().diagonal_mm();
    for hole in &loops {
        let points: Vec<[f64; 3]> =
            hole.iter().map(|&edge| mesh.vertices()[open[edge].from as usize]).collect();
        let length_mm = perimeter_mm(&points);
        if length_mm > SMALL_HOLE * diagonal && !is_flat(&points, FLAT_HOLE * diagonal) {
            return Err(RepairError::Hole { edges: points.len(), length_mm, at_mm: points[0] });
        }
    }
    for hole in &loops {
        let first = open[hole[0]];
        // A hole between two components connects them.
        hole.iter().for_each(|&edge| components.join(first.triangle, open[edge].triangle, false));
        // A fan around the first corner: one triangle for each edge that does not touch it.
        for &edge in &hole[1..hole.len() - 1] {
            let OpenEdge { from, to, triangle } = open[edge];
            components.push(triangle);
            body.mesh.parts_mut().1.push([first.from, from, to]);
            if !body.paint.is_empty() {
                body.paint.push(body.paint[triangle as usize]);
            }
        }
    }
    Ok(loops.len())
}

/// The directed edges that new triangles need, sorted.
///
/// An edge of a closed surface has as many half-edges in one direction as in the other.
/// Where one direction has more of them, the new triangles must supply the other.
fn open_edges(
    mesh: &Mesh,
    edges: &Edges,
    work: &mut Work<'_>,
) -> Result<Vec<OpenEdge>, RepairError> {
    let mut open = Vec::new();
    work.set_items(edges.len());
    let mut done = 0;
    for (low, edge) in edges.iter() {
        work.tick(done)?;
        done += edge.len();
        let high = edge[0][0];
        let rising = edge.iter().filter(|&&[_, half_edge]| is_rising(mesh, half_edge)).count();
        let falling = edge.len() - rising;
        // Triangles of the half-edges in one direction that have no partner in the other.
        let surplus = |direction: bool, more: usize, fewer: usize| {
            edge.iter()
                .filter(move |&&[_, half_edge]| is_rising(mesh, half_edge) == direction)
                .take(more.saturating_sub(fewer))
                .map(|&[_, half_edge]| half_edge / 3)
        };
        let falls = surplus(true, rising, falling);
        open.extend(falls.map(|triangle| OpenEdge { from: high, to: low, triangle }));
        let rises = surplus(false, falling, rising);
        open.extend(rises.map(|triangle| OpenEdge { from: low, to: high, triangle }));
    }
    open.sort_unstable();
    Ok(open)
}

/// Splits directed edges, sorted by their start, into simple loops, each a list of indices into
/// `open` in order.
///
/// As many edges arrive at each vertex as leave it, so a walk along edges that have not been used
/// can only get stuck where it began.
/// As soon as the walk returns to a vertex, the edges since its first visit are cut off as a loop:
/// so two holes that touch at a vertex become two loops.
fn loops(open: &[OpenEdge]) -> Vec<Vec<usize>> {
    let first_from = |vertex: u32| open.partition_point(|edge| edge.from < vertex);
    // For the first edge of each vertex, how many of the edges from this vertex have been used.
    let mut used = vec![0; open.len()];
    let mut loops = Vec::new();
    let mut walk: Vec<usize> = Vec::new();
    // For the vertices on the walk, the number of edges before their visit.
    let mut visits = HashMap::new();
    for begin in 0..open.len() {
        let mut vertex = open[begin].from;
        loop {
            if let Some(since) = visits.insert(vertex, walk.len())
                && since < walk.len()
            {
                let closed = walk.split_off(since);
                closed.iter().for_each(|&edge| {
                    visits.remove(&open[edge].from);
                });
                visits.insert(vertex, since);
                loops.push(closed);
            }
            let first = first_from(vertex);
            let edge = first + used[first];
            if open.get(edge).is_none_or(|edge| edge.from != vertex) {
                break;
            }
            used[first] += 1;
            walk.push(edge);
            vertex = open[edge].to;
        }
        // All edges of the walk have been cut off as loops, so only its last vertex is left.
        // Clearing the map instead would take time proportional to its capacity, for every edge.
        visits.remove(&vertex);
    }
    loops
}

fn perimeter_mm(points: &[[f64; 3]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(&a, &b)| dot(minus(a, b), minus(a, b)).sqrt()).sum()
}

/// Whether all points are within `tolerance_mm` of the plane through their centre that is normal to
/// the vector area of the polygon.
fn is_flat(points: &[[f64; 3]], tolerance_mm: f64) -> bool {
    let count = points.len() as f64;
    let centre = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
    let next = points.iter().cycle().skip(1);
    let mut normal = [0.0; 3];
    for (&a, &b) in points.iter().zip(next) {
        let area = cross(minus(a, centre), minus(b, centre));
        (0..3).for_each(|axis| normal[axis] += area[axis]);
    }
    let length = dot(normal, normal).sqrt();
    // Points on a line do not define a plane, but their hole has no area either.
    length <= tolerance_mm * tolerance_mm
        || points
            .iter()
            .all(|&point| dot(minus(point, centre), normal).abs() <= tolerance_mm * length)
}
