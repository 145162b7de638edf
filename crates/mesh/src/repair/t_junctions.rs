//! Closes T-junctions: points where a vertex of one side of a surface lies on an edge of the other.
//!
//! They appear where neighbouring faces are divided into triangles independently of each other.
//! The triangle of the undivided edge is split at the vertex, so the surface does not change.
//!
//! # Method
//! An edge is open if an odd number of triangles meet there.
//! Along a T-junction both sides are open, and both boundaries run along the same line.
//! So the vertices on an open edge are found by a walk from each of its ends along other open edges
//! that stay on it.
//! Along a T-junction each vertex lies on one other edge, or on a few where several faces meet.
//! If there are more vertices on edges than open edges, as where many edges lie on one line,
//! nothing is split: so the time and the new triangles are linear in the open edges.

use beadwork_base::Interrupted;

use super::edges::OddEdge;
use crate::model::Body;
use crate::vector::{dot, minus};
use crate::work::Work;

/// Open edges of a vertex that a walk considers; this bounds the time at a vertex with many.
const MAX_BRANCHES: usize = 1024;

/// Vertices on open edges that are split, for each direction of an open edge on average.
/// A walk from each end finds the same ones, and several faces may meet in a line.
const VERTICES_PER_EDGE: usize = 8;

/// Splits triangles at the vertices that lie on their open edges `odd`, at most `tolerance_mm` off;
/// returns the number of edges that are split, 0 if that would take too many new triangles.
pub(super) fn close(
    body: &mut Body,
    odd: &[OddEdge],
    tolerance_mm: f64,
    work: &mut Work<'_>,
) -> Result<usize, Interrupted> {
    // Both directions of every open edge: from, to, and a half-edge of it.
    let both = |&OddEdge { vertices: [low, high], half_edge }: &OddEdge| {
        [[low, high, half_edge], [high, low, half_edge]]
    };
    let mut open: Vec<[u32; 3]> = odd.iter().flat_map(both).collect();
    open.sort_unstable();

    // Half-edges to split, each with the vertices on it in the order from its start.
    let mut splits: Vec<(u32, Vec<u32>)> = Vec::new();
    // Vertices that walks may still find.
    let mut budget = VERTICES_PER_EDGE * open.len();
    let vertices = body.mesh.vertices();
    let triangles = body.mesh.triangles();
    for &[from, to, half_edge] in &open {
        work.poll(1)?;
        let corners = triangles[half_edge as usize / 3];
        if corners[half_edge as usize % 3] != from {
            continue;
        }
        let line = Line::new(vertices[from as usize], vertices[to as usize], tolerance_mm);
        let position = |vertex: u32| line.position(vertices[vertex as usize]);
        let mut on_edge: Vec<(f64, u32)> = Vec::new();
        for (start, forwards) in [(from, true), (to, false)] {
            let (mut vertex, mut reached) = (start, if forwards { 0.0 } else { 1.0 });
            loop {
                let branches = open[open.partition_point(|edge| edge[0] < vertex)..].iter();
                let next = branches
                    .take_while(|edge| edge[0] == vertex)
                    .take(MAX_BRANCHES)
                    .filter_map(|&[_, next, _]| Some((position(next)?, next)))
                    .filter(|&(at, _)| if forwards { at > reached } else { at < reached })
                    .min_by(|a, b| (a.0 - reached).abs().total_cmp(&(b.0 - reached).abs()));
                let Some((at, next)) = next else { break };
                work.poll(1)?;
                if budget == 0 {
                    return Ok(0);
                }
                budget -= 1;
                on_edge.push((at, next));
                (vertex, reached) = (next, at);
            }
        }
        on_edge.retain(|&(_, vertex)| !corners.contains(&vertex));
        on_edge.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        on_edge.dedup();
        if !on_edge.is_empty() {
            splits.push((half_edge, on_edge.into_iter().map(|(_, vertex)| vertex).collect()));
        }
    }
    splits.sort_unstable();
    for of_triangle in splits.chunk_by(|a, b| a.0 / 3 == b.0 / 3) {
        split(body, of_triangle);
    }
    Ok(splits.len())
}

/// Splits a triangle at the vertices on its edges, which are given by half-edge.
///
/// Splits along one edge after the other: the part that has the whole edge becomes a fan around its
/// opposite corner.
fn split(body: &mut Body, splits: &[(u32, Vec<u32>)]) {
    let number = splits[0].0 as usize / 3;
    let (_, triangles) = body.mesh.parts_mut();
    let corners = triangles[number];
    let mut parts = vec![corners];
    for (half_edge, on_edge) in splits {
        let corner = *half_edge as usize % 3;
        let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
        let of_part =
            |part: &[u32; 3]| (0..3).find(|&at| part[at] == from && part[(at + 1) % 3] == to);
        let found = parts.iter().zip(0..).find_map(|(part, at)| Some((at, of_part(part)?)));
        let (part, at) = found.expect("one part has the edge, which is not split yet");
        let apex = parts.swap_remove(part)[(at + 2) % 3];
        let mut last = from;
        for &vertex in on_edge.iter().chain([&to]) {
            parts.push([last, vertex, apex]);
            last = vertex;
        }
    }
    triangles[number] = parts[0];
    triangles.extend(&parts[1..]);
    if !body.paint.is_empty() {
        let paint = body.paint[number];
        body.paint.resize(triangles.len(), paint);
    }
}

/// A line between two points, and the distance within which points count as on it.
struct Line {
    from: [f64; 3],
    direction: [f64; 3],
    /// Square of its length.
    squared: f64,
    tolerance_mm: f64,
}

impl Line {
    fn new(from: [f64; 3], to: [f64; 3], tolerance_mm: f64) -> Self {
        let direction = minus(to, from);
        Self { from, direction, squared: dot(direction, direction), tolerance_mm }
    }

    /// Where a point lies on the line, from 0 to 1, ends excluded; `None` if it is not on the line,
    /// or nearer to an end than the tolerance.
    fn position(&self, point: [f64; 3]) -> Option<f64> {
        let offset = minus(point, self.from);
        let position = dot(offset, self.direction) / self.squared;
        let margin = self.tolerance_mm / self.squared.sqrt();
        let away = minus(offset, self.direction.map(|value| position * value));
        let is_near = dot(away, away) <= self.tolerance_mm * self.tolerance_mm;
        (is_near && position > margin && position < 1.0 - margin).then_some(position)
    }
}
