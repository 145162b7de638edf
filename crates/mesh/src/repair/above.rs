//! Finds the triangles above a point without looking at all of them.

use crate::surface::{Bounds, Mesh};

/// A tree of boxes around triangles, halved by their middles along x and y in turn.
///
/// At most 14 bytes a triangle.
/// A search looks at the triangles whose boxes a ray upwards from the point meets, and a few beside
/// them.
pub(super) struct Above {
    order: Vec<u32>,
    /// Around the triangles of each node, as far as a ray upwards can tell: least and greatest x
    /// and y, greatest z.
    /// The children of node `n` are `2 n + 1` and `2 n + 2`.
    boxes: Vec<[f64; 5]>,
}

/// Triangles of a leaf.
const LEAF: usize = 16;

impl Above {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut order: Vec<u32> = (0..mesh.triangles().len() as u32).collect();
        let mut boxes = Vec::new();
        build(mesh, &mut order, &mut boxes, 0, 0);
        Self { order, boxes }
    }

    /// Shows `visit` every triangle that may lie above a point, in no order; tells how many it has
    /// shown.
    pub(super) fn each(&self, [x, y, z]: [f64; 3], mut visit: impl FnMut(u32)) -> usize {
        let mut shown = 0;
        // Nodes and the triangles below them.
        let mut open = vec![(0, &self.order[..])];
        while let Some((node, triangles)) = open.pop() {
            let [least_x, greatest_x, least_y, greatest_y, greatest_z] = self.boxes[node];
            if x < least_x || x > greatest_x || y < least_y || y > greatest_y || z > greatest_z {
                continue;
            }
            if triangles.len() <= LEAF {
                shown += triangles.len();
                triangles.iter().for_each(|&triangle| visit(triangle));
            } else {
                let (left, right) = triangles.split_at(triangles.len() / 2);
                open.extend([(2 * node + 1, left), (2 * node + 2, right)]);
            }
        }
        shown
    }
}

fn build(mesh: &Mesh, order: &mut [u32], boxes: &mut Vec<[f64; 5]>, node: usize, axis: usize) {
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
        return;
    }
    let middle =
        |triangle: u32| corners(triangle).map(|corner| corner[axis] / 3.0).iter().sum::<f64>();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)));
    let (left, right) = order.split_at_mut(half);
    build(mesh, left, boxes, 2 * node + 1, 1 - axis);
    build(mesh, right, boxes, 2 * node + 2, 1 - axis);
}
