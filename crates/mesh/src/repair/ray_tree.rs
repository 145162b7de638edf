//! Finds the triangles above a point without testing all of them.

use beadwork_base::Interrupted;

use crate::bounds::Bounds;
use crate::mesh::Mesh;
use crate::work::Work;

/// A bounding volume hierarchy: a binary tree of boxes around triangles.
///
/// Each node splits its triangles into halves by their centres, along x and y in turn.
/// Takes at most 14 bytes per triangle.
pub(super) struct RayTree {
    /// The triangles; those of a node are a slice, and its children have the halves of the slice.
    order: Vec<u32>,
    /// The box of each node, as far as rays upwards need it: minimum x, maximum x, minimum y,
    /// maximum y, maximum z.
    /// The children of node `n` are `2 n + 1` and `2 n + 2`.
    boxes: Vec<[f64; 5]>,
}

/// Maximum number of triangles of a leaf.
const LEAF: usize = 16;

impl RayTree {
    /// Builds the tree in O(n log n).
    pub(super) fn new(mesh: &Mesh, work: &mut Work<'_>) -> Result<Self, Interrupted> {
        let mut order: Vec<u32> = (0..mesh.triangles().len() as u32).collect();
        let mut boxes = Vec::new();
        build(mesh, &mut order, &mut boxes, 0, 0, work)?;
        Ok(Self { order, boxes })
    }

    /// Calls `visit` for every triangle that may lie above a point, and for some others nearby, in
    /// no particular order; returns the number of calls.
    pub(super) fn each_above(&self, [x, y, z]: [f64; 3], mut visit: impl FnMut(u32)) -> usize {
        let mut visited = 0;
        // Nodes to search, with their triangles.
        let mut stack = vec![(0, &self.order[..])];
        while let Some((node, triangles)) = stack.pop() {
            let [min_x, max_x, min_y, max_y, max_z] = self.boxes[node];
            if x < min_x || x > max_x || y < min_y || y > max_y || z > max_z {
                continue;
            }
            if triangles.len() <= LEAF {
                visited += triangles.len();
                triangles.iter().for_each(|&triangle| visit(triangle));
            } else {
                let (left, right) = triangles.split_at(triangles.len() / 2);
                stack.extend([(2 * node + 1, left), (2 * node + 2, right)]);
            }
        }
        visited
    }
}

fn build(
    mesh: &Mesh,
    order: &mut [u32],
    boxes: &mut Vec<[f64; 5]>,
    node: usize,
    axis: usize,
    work: &mut Work<'_>,
) -> Result<(), Interrupted> {
    work.poll(order.len())?;
    let corners = |triangle: u32| mesh.corners(mesh.triangles()[triangle as usize]);
    let mut bounds = Bounds::EMPTY;
    order
        .iter()
        .for_each(|&triangle| corners(triangle).iter().for_each(|&corner| bounds.add(corner)));
    if boxes.len() <= node {
        boxes.resize(node + 1, [0.0; 5]);
    }
    let Bounds { min, max } = bounds;
    boxes[node] = [min[0], max[0], min[1], max[1], max[2]];
    if order.len() <= LEAF {
        return Ok(());
    }
    let centre =
        |triangle: u32| corners(triangle).map(|corner| corner[axis] / 3.0).iter().sum::<f64>();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| centre(a).total_cmp(&centre(b)));
    let (left, right) = order.split_at_mut(half);
    build(mesh, left, boxes, 2 * node + 1, 1 - axis, work)?;
    build(mesh, right, boxes, 2 * node + 2, 1 - axis, work)
}
