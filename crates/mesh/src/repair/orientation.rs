//! Turns a closed surface outwards.
//!
//! A connected component with a negative volume is inside out, or it is the surface of a cavity,
//! which faces into the cavity and so away from the material.
//! It is a cavity if other components enclose it.
//!
//! To find out, a ray is cast upwards from a vertex of the component.
//! Each time the ray leaves the material of another component it counts +1, each time it enters,
//! -1.
//! The sum is how many times the other components enclose the vertex: their winding number there.

use beadwork_base::Interrupted;

use super::components::Components;
use super::ray_tree::RayTree;
use crate::mesh::Mesh;
use crate::vector::{cross, dot, minus, tetrahedron_mm3};
use crate::work::Work;

/// Rays are no longer cast after this many tests of a ray against a triangle, which take some
/// seconds.
const MAX_TESTS: usize = 500_000_000;

/// Flips components that are inside out and not cavities; returns the number of flipped triangles.
pub(super) fn turn_outwards(
    mesh: &mut Mesh,
    components: &mut Components,
    work: &mut Work<'_>,
) -> Result<usize, Interrupted> {
    let count = mesh.triangles().len();
    let mut roots = Vec::with_capacity(count);
    // Relative to a point of the body, volumes are not small differences of large numbers.
    let origin = mesh.vertices()[mesh.triangles()[0][0] as usize];
    let mut volumes = vec![0.0; count];
    work.set_items(count);
    for triangle in 0..count {
        work.tick(triangle)?;
        let (root, _) = components.find(triangle as u32);
        let corners = mesh.corners(mesh.triangles()[triangle]).map(|corner| minus(corner, origin));
        volumes[root as usize] += tetrahedron_mm3(corners);
        roots.push(root);
    }
    // If the body as a whole is inside out, its cavities look like solid components.
    // So the whole body is flipped first.
    let is_inverted = volumes.iter().sum::<f64>() < 0.0;
    if is_inverted {
        mesh.parts_mut().1.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        volumes.iter_mut().for_each(|volume| *volume = -*volume);
    }
    let mut flipped = if is_inverted { count } else { 0 };
    let negative: Vec<u32> =
        (0..count as u32).filter(|&root| volumes[root as usize] < 0.0).collect();
    if negative.is_empty() {
        return Ok(flipped);
    }
    let tree = RayTree::new(mesh, work)?;
    let mut is_inside_out: Vec<bool> = vec![false; count];
    let mut tests = 0;
    for root in negative {
        if tests > MAX_TESTS {
            break;
        }
        let point = mesh.vertices()[mesh.triangles()[root as usize][0] as usize];
        let mut winding = 0;
        let tested = tree.each_above(point, |triangle| {
            if roots[triangle as usize] != root {
                winding += crossing(mesh.corners(mesh.triangles()[triangle as usize]), point);
            }
        });
        work.poll(tested)?;
        tests += tested;
        is_inside_out[root as usize] = winding == 0;
    }
    let (_, triangles) = mesh.parts_mut();
    for (triangle, &root) in triangles.iter_mut().zip(&roots) {
        if is_inside_out[root as usize] {
            triangle.swap(1, 2);
            flipped = if is_inverted { flipped - 1 } else { flipped + 1 };
        }
    }
    Ok(flipped)
}

/// How a ray upwards from a point crosses a triangle: 1 if it leaves the body there, because the
/// triangle faces up; -1 if it enters; 0 if it misses the triangle.
pub(super) fn crossing(corners: [[f64; 3]; 3], point: [f64; 3]) -> i32 {
    let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let is_above = normal[2] != 0.0
        && covers(corners, point)
        && dot(normal, minus(corners[0], point)) * normal[2].signum() > 0.0;
    if !is_above {
        0
    } else if normal[2] > 0.0 {
        1
    } else {
        -1
    }
}

/// Whether a point lies inside a triangle, both projected to the xy plane.
///
/// Counts the edges to the right of the point; the point is inside if their number is odd.
/// Each edge includes its lower end and excludes its upper end, so if triangles share an edge or a
/// vertex, a point on it is inside of exactly one of those on either side.
fn covers(corners: [[f64; 3]; 3], point: [f64; 3]) -> bool {
    let mut is_inside = false;
    for corner in 0..3 {
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        if low[1] <= point[1] && point[1] < high[1] {
            let x = low[0] + (point[1] - low[1]) / (high[1] - low[1]) * (high[0] - low[0]);
            is_inside ^= x > point[0];
        }
    }
    is_inside
}
