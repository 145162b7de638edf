//! Merges vertices that are nearly equal, where a surface is open.
//!
//! Programs often write the triangles, or the faces, of a sound part with coordinates that differ
//! in the last digits: the surface then is open along every such edge.
//!
//! # Method
//! An edge is open if an odd number of triangles meet there.
//! Only vertices of open edges take part, so closed regions keep all their details.
//! Tolerances are tried from the precision of float32 upwards, each four times the last one; the
//! first that leaves no open edge is applied, or else the one that leaves the fewest, if it leaves
//! fewer than before.
//!
//! Vertices within the tolerance are found with grids of cells twice as long as the tolerance.
//! Two points that differ by at most the tolerance along an axis lie in the same cell of one of two
//! grids that are half a cell apart; in space, of one of eight grids.
//! So merging all vertices that share a cell in any of the eight merges all that are near enough,
//! and none more than `2 √3` tolerances apart, except through others between them.
//! The time is linear in the vertices, however dense they are.
//!
//! Where vertices are denser than the tolerance, each has a neighbour to merge with, and the whole
//! boundary would become one vertex.
//! So a tolerance with which a group becomes long is not applied.

use std::collections::HashMap;

use beadwork_base::Interrupted;

use super::components::Components;
use super::edges::OddEdge;
use super::settings::spacing_mm;
use crate::bounds::Bounds;
use crate::mesh::Mesh;
use crate::work::Work;

/// Ratio of each tolerance to the one before it.
const STEP: f64 = 4.0;

/// Maximum extent of a group of vertices along an axis, in tolerances.
/// Vertices that share a cell are up to two apart, and up to four through one vertex between them.
const MAX_EXTENT: f64 = 4.0;

/// What was merged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Merged {
    /// Number of vertices that were merged into others.
    pub(super) vertices: usize,
    /// The tolerance that was applied, in mm.
    pub(super) tolerance_mm: f64,
}

/// Merges near vertices of the open edges `odd` into the first of them, with tolerances up to
/// `max_mm`.
/// Triangles may have two equal corners afterwards.
pub(super) fn merge(
    mesh: &mut Mesh,
    odd: &[OddEdge],
    max_mm: f64,
    work: &mut Work<'_>,
) -> Result<Merged, Interrupted> {
    let mut boundary: Vec<u32> = odd.iter().flat_map(|edge| edge.vertices).collect();
    let mut best_open = odd.len();
    boundary.sort_unstable();
    boundary.dedup();
    let mut is_boundary = vec![false; mesh.vertices().len()];
    boundary.iter().for_each(|&vertex| is_boundary[vertex as usize] = true);
    let affected: Vec<[u32; 3]> = mesh
        .triangles()
        .iter()
        .copied()
        .filter(|triangle| triangle.iter().any(|&vertex| is_boundary[vertex as usize]))
        .collect();
    drop(is_boundary);

    let points: Vec<[f64; 3]> =
        boundary.iter().map(|&vertex| mesh.vertices()[vertex as usize]).collect();
    let mut best = None;
    let mut groups = boundary.len();
    for tolerance_mm in tolerances(mesh, max_mm) {
        let first = group(&points, tolerance_mm, work)?;
        let count = first.iter().zip(0..).filter(|&(&first, at)| first == at).count();
        if count == groups {
            continue;
        }
        if max_extent_mm(&points, &first) > MAX_EXTENT * tolerance_mm {
            continue;
        }
        groups = count;
        let left = open_after(&affected, &boundary, &first, work)?;
        if left < best_open {
            (best_open, best) = (left, Some((tolerance_mm, first)));
        }
        if left == 0 {
            break;
        }
    }
    let Some((tolerance_mm, first)) = best else { return Ok(Merged::default()) };
    let (_, triangles) = mesh.parts_mut();
    for vertex in triangles.iter_mut().flatten() {
        *vertex = renamed(*vertex, &boundary, &first);
    }
    let vertices = first.iter().zip(0..).filter(|&(&first, at)| first != at).count();
    Ok(Merged { vertices, tolerance_mm })
}

/// The tolerances to try, ascending, in mm.
fn tolerances(mesh: &Mesh, max_mm: f64) -> impl Iterator<Item = f64> + use<> {
    let first = spacing_mm(&mesh.bounds()).min(max_mm);
    let next = move |&mm: &f64| (mm < max_mm).then_some((STEP * mm).min(max_mm));
    std::iter::successors(Some(first), next).filter(|&mm| mm > 0.0)
}

/// For each point the first point of its group: points that share a cell, directly or through
/// others.
fn group(
    points: &[[f64; 3]],
    tolerance_mm: f64,
    work: &mut Work<'_>,
) -> Result<Vec<u32>, Interrupted> {
    let mut groups = Components::separate(points.len());
    let mut cells: HashMap<[i64; 3], u32> = HashMap::with_capacity(points.len());
    for grid in 0..8_u32 {
        cells.clear();
        for (number, point) in (0..).zip(points) {
            work.poll(1)?;
            let cell = [0, 1, 2].map(|axis| {
                let shift = f64::from(grid >> axis & 1) / 2.0;
                (point[axis] / (2.0 * tolerance_mm) + shift).floor() as i64
            });
            groups.join(*cells.entry(cell).or_insert(number), number, false);
        }
    }
    // The root of a component is the first of its members.
    Ok((0..points.len() as u32).map(|point| groups.find(point).0).collect())
}

/// The maximum extent of a group along an axis.
fn max_extent_mm(points: &[[f64; 3]], first: &[u32]) -> f64 {
    let mut bounds = vec![Bounds::EMPTY; points.len()];
    for (point, &first) in points.iter().zip(first) {
        bounds[first as usize].add(*point);
    }
    bounds.iter().flat_map(Bounds::size_mm).fold(0.0, f64::max)
}

/// The vertex that a vertex is merged into: itself, unless it is on the boundary.
fn renamed(vertex: u32, boundary: &[u32], first: &[u32]) -> u32 {
    match boundary.binary_search(&vertex) {
        Ok(at) => boundary[first[at] as usize],
        Err(_) => vertex,
    }
}

/// Number of open edges after merging.
///
/// Edges without a boundary vertex are closed and stay so; all triangles of the others are
/// affected, so these are the only edges to count.
fn open_after(
    affected: &[[u32; 3]],
    boundary: &[u32],
    first: &[u32],
    work: &mut Work<'_>,
) -> Result<usize, Interrupted> {
    let mut sides = Vec::with_capacity(3 * affected.len());
    for &triangle in affected {
        work.poll(1)?;
        let merged = triangle.map(|vertex| renamed(vertex, boundary, first));
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let (a, b) = (merged[corner], merged[next]);
            let touches =
                [corner, next].iter().any(|&at| boundary.binary_search(&triangle[at]).is_ok());
            if touches && a != b {
                sides.push([a.min(b), a.max(b)]);
            }
        }
    }
    sides.sort_unstable();
    Ok(sides.chunk_by(|a, b| a == b).filter(|edge| edge.len() % 2 == 1).count())
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 2_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        /// Compared with all pairs: near points are in one group, and each group is connected by
        /// pairs that are not far apart.
        #[test]
        fn groups_hold_all_near_points(
            points in prop::collection::vec(prop::array::uniform3(-12_i32..12), 1..60),
            tolerance in 1_u32..8,
        ) {
            let tolerance_mm = f64::from(tolerance) / 4.0;
            let points: Vec<[f64; 3]> =
                points.into_iter().map(|point| point.map(|at| f64::from(at) / 3.0)).collect();
            let control = Control::default();
            let first = group(&points, tolerance_mm, &mut Work::new(&control, 1, 1)).unwrap();
            // The same with all pairs, with the tolerance of the cells.
            let mut loose = Components::separate(points.len());
            for a in 0..points.len() {
                for b in 0..a {
                    let apart = [0, 1, 2]
                        .map(|axis| (points[a][axis] - points[b][axis]).abs())
                        .into_iter()
                        .fold(0.0, f64::max);
                    if apart <= tolerance_mm {
                        prop_assert_eq!(first[a], first[b]);
                    }
                    if apart < 2.0 * tolerance_mm {
                        loose.join(a as u32, b as u32, false);
                    }
                }
            }
            for a in 0..points.len() {
                prop_assert!(first[a] <= a as u32 && first[first[a] as usize] == first[a]);
                prop_assert_eq!(loose.find(a as u32), loose.find(first[a]));
            }
        }
    }
}
