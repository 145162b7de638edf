//! Splits a painted body into shells of one colour each, where it consists of such shells.
//!
//! Programs often write a part of several materials as one mesh with a colour for each triangle:
//! closed shells of one colour that touch, or lie in each other.
//! What lies in a shell of one colour has that colour; only in a shell of several colours does it
//! depend on the distance to the surface.
//!
//! # Method
//! Shells are the connected components of triangles.
//! Where shells touch along an edge, more than two triangles meet there; those of one colour that
//! are closed there by themselves, because as many use the edge in one direction as in the other,
//! are connected with each other only.
//! A component with a negative volume is a cavity: it belongs to the smallest shell around it.

use std::collections::HashMap;

use beadwork_base::Control;

use super::components::Components;
use super::edges::{Edges, is_rising};
use super::orientation::crossing;
use super::ray_tree::RayTree;
use crate::mesh::Mesh;
use crate::model::Body;
use crate::vector::{minus, tetrahedron_mm3};
use crate::work::Work;

/// Relative error of volumes.
const ROUNDING: f64 = 1e-6;

const NEVER: &str = "a default control does not interrupt";

/// The shells of a painted body, the largest first, so that the smaller of two shells that overlap
/// counts.
/// Other bodies, and bodies of one shell, are returned as they are.
///
/// The body must be repaired.
/// O(n log n) for n triangles, and linear in the triangles above each cavity.
pub(crate) fn split(body: Body) -> Vec<Body> {
    if body.paint.is_empty() {
        return vec![body];
    }
    let roots = shells(&body);
    let mut numbers: HashMap<u32, usize> = HashMap::new();
    let mut volumes: Vec<f64> = Vec::new();
    let mut shell_of = Vec::with_capacity(roots.len());
    let origin = body.mesh.bounds().min;
    for (&root, &triangle) in roots.iter().zip(body.mesh.triangles()) {
        let next = numbers.len();
        let shell = *numbers.entry(root).or_insert(next);
        if shell == next {
            volumes.push(0.0);
        }
        let corners = body.mesh.corners(triangle).map(|corner| minus(corner, origin));
        volumes[shell] += tetrahedron_mm3(corners);
        shell_of.push(shell);
    }
    if volumes.len() == 1 {
        return vec![body];
    }
    let owners = owners(&body.mesh, &shell_of, &volumes);
    let mut order: Vec<usize> =
        (0..volumes.len()).filter(|&shell| owners[shell] == shell).collect();
    order.sort_by(|&a, &b| volumes[b].total_cmp(&volumes[a]));
    let mut triangles: Vec<Vec<usize>> = vec![Vec::new(); volumes.len()];
    for (triangle, &shell) in shell_of.iter().enumerate() {
        triangles[owners[shell]].push(triangle);
    }
    order.iter().map(|&shell| part(&body, &triangles[shell])).collect()
}

/// For each triangle a number that it shares with those of its shell.
fn shells(body: &Body) -> Vec<u32> {
    let control = Control::default();
    let mut work = Work::new(&control, 1, 1);
    let edges = Edges::new(&body.mesh, &mut work).expect(NEVER);
    let count = body.mesh.triangles().len();
    let mut components = Components::separate(count);
    // The half-edges of an edge by colour, and those that remain.
    let mut by_colour: Vec<(u8, u32)> = Vec::new();
    let mut rest: Vec<u32> = Vec::new();
    for (_, edge) in edges.iter() {
        by_colour.clear();
        by_colour.extend(
            edge.iter().map(|&[_, half_edge]| (body.paint[half_edge as usize / 3], half_edge)),
        );
        by_colour.sort_unstable();
        rest.clear();
        for same in by_colour.chunk_by(|a, b| a.0 == b.0) {
            let rising = same.iter().filter(|&&(_, half)| is_rising(&body.mesh, half)).count();
            if 2 * rising == same.len() {
                for pair in same.windows(2) {
                    components.join(pair[0].1 / 3, pair[1].1 / 3, false);
                }
            } else {
                rest.extend(same.iter().map(|&(_, half_edge)| half_edge));
            }
        }
        for pair in rest.windows(2) {
            components.join(pair[0] / 3, pair[1] / 3, false);
        }
    }
    (0..count as u32).map(|triangle| components.find(triangle).0).collect()
}

/// For each shell the one that it belongs to: itself, or for cavities the shell around it.
fn owners(mesh: &Mesh, shell_of: &[usize], volumes: &[f64]) -> Vec<usize> {
    let mut owners: Vec<usize> = (0..volumes.len()).collect();
    if volumes.iter().all(|&volume| volume >= 0.0) {
        return owners;
    }
    let control = Control::default();
    let tree = RayTree::new(mesh, &mut Work::new(&control, 1, 1)).expect(NEVER);
    let mut windings: HashMap<usize, i32> = HashMap::new();
    let mut is_done = vec![false; volumes.len()];
    for (&triangle, &shell) in mesh.triangles().iter().zip(shell_of) {
        if volumes[shell] >= 0.0 || std::mem::replace(&mut is_done[shell], true) {
            continue;
        }
        let [point, ..] = mesh.corners(triangle);
        windings.clear();
        tree.each_above(point, |above| {
            let other = shell_of[above as usize];
            // A shell that just fills the cavity is not around it.
            if volumes[other] > -volumes[shell] * (1.0 + ROUNDING) {
                let corners = mesh.corners(mesh.triangles()[above as usize]);
                *windings.entry(other).or_default() += crossing(corners, point);
            }
        });
        let around = windings.iter().filter(|&(_, &winding)| winding > 0).map(|(&other, _)| other);
        let smallest = around.min_by(|&a, &b| volumes[a].total_cmp(&volumes[b]).then(a.cmp(&b)));
        owners[shell] = smallest.unwrap_or(shell);
    }
    owners
}

/// A body of some of the triangles; it is not painted if they have one colour.
fn part(body: &Body, triangles: &[usize]) -> Body {
    let corners = triangles.iter().map(|&triangle| body.mesh.triangles()[triangle]).collect();
    let mesh = Mesh::of_used_vertices(body.mesh.vertices(), corners);
    let paint: Vec<u8> = triangles.iter().map(|&triangle| body.paint[triangle]).collect();
    let is_one = paint.iter().all(|&colour| colour == paint[0]);
    Body {
        name: body.name.clone(),
        mesh,
        material: if is_one { Some(paint[0].into()) } else { None },
        paint: if is_one { Vec::new() } else { paint },
        ..*body
    }
}
