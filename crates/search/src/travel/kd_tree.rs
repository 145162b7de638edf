//! A k-d tree of points that can be removed, after Bentley, "K-d trees for semidynamic point sets"
//! (Symposium on Computational Geometry, 1990).
//!
//! A tree is built once.
//! Each node counts the points that remain below it, so that a search skips emptied parts; an
//! R-tree would have to be rebuilt while points are removed, and is slower at this size.

use super::route::distance;

/// Maximum number of points of a leaf.
const BUCKET: usize = 8;

/// Points with a label each.
#[derive(Clone)]
pub(super) struct KdTree<T> {
    /// Points and labels, those of a node next to each other.
    points: Vec<([f64; 2], T)>,
    /// Whether each point remains.
    remains: Vec<bool>,
    /// Nodes in preorder: the left child follows its parent.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    /// Range of the points.
    from: u32,
    to: u32,
    /// Number of remaining points.
    remaining: u32,
    /// Index of the right child; 0 for a leaf.
    right: u32,
    /// Box around the points.
    low: [f64; 2],
    high: [f64; 2],
}

impl Node {
    /// Lower bound of the distance to the points.
    #[inline]
    fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        distance([x, y], [x.clamp(self.low[0], self.high[0]), y.clamp(self.low[1], self.high[1])])
    }
}

impl<T: Copy> KdTree<T> {
    /// Builds a tree in O(n log n) steps for n points.
    pub(super) fn new(points: Vec<([f64; 2], T)>) -> Self {
        let remains = vec![true; points.len()];
        let mut tree = Self { points, remains, nodes: Vec::new() };
        if !tree.points.is_empty() {
            tree.build(0, tree.points.len());
        }
        tree
    }

    fn build(&mut self, from: usize, to: usize) {
        let points = &mut self.points[from..to];
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for (point, _) in points.iter() {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let index = self.nodes.len();
        let remaining = (to - from) as u32;
        self.nodes.push(Node { from: from as u32, to: to as u32, remaining, right: 0, low, high });
        if to - from > BUCKET {
            let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
            let half = points.len() / 2;
            points.select_nth_unstable_by(half, |(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
            self.build(from, from + half);
            self.nodes[index].right = self.nodes.len() as u32;
            self.build(from + half, to);
        }
    }

    /// The remaining points with their indices and labels, in an arbitrary order that is always the
    /// same.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, T)> + '_ {
        let points = self.points.iter().enumerate();
        points.filter(|&(index, _)| self.remains[index]).map(|(index, &(_, label))| (index, label))
    }

    /// Removes the point with this index, if it remains; O(log n) steps.
    pub(super) fn remove(&mut self, index: usize) {
        if !std::mem::replace(&mut self.remains[index], false) {
            return;
        }
        let mut node = 0;
        loop {
            self.nodes[node].remaining -= 1;
            let right = self.nodes[node].right as usize;
            if right == 0 {
                return;
            }
            node = if index < self.nodes[right].from as usize { node + 1 } else { right };
        }
    }

    /// Calls `visit` with the distance, the index and the label of each remaining point whose
    /// distance is less than the limit, nearest nodes first.
    /// The limit starts as infinity, and `visit` returns the limit from then on.
    pub(super) fn search(&self, point: [f64; 2], visit: &mut impl FnMut(f64, usize, T) -> f64) {
        self.search_within(point, f64::INFINITY, visit);
    }

    /// As [`search`](Self::search), with the limit at the start.
    pub(super) fn search_within(
        &self,
        point: [f64; 2],
        mut limit: f64,
        visit: &mut impl FnMut(f64, usize, T) -> f64,
    ) {
        if !self.nodes.is_empty() {
            self.search_node(0, point, &mut limit, visit);
        }
    }

    fn search_node(
        &self,
        index: usize,
        point: [f64; 2],
        limit: &mut f64,
        visit: &mut impl FnMut(f64, usize, T) -> f64,
    ) {
        let node = &self.nodes[index];
        if node.right == 0 {
            for index in node.from as usize..node.to as usize {
                let (other, label) = self.points[index];
                let distance = distance(point, other);
                if distance < *limit && self.remains[index] {
                    *limit = visit(distance, index, label);
                }
            }
            return;
        }
        let [left, right] = [index + 1, node.right as usize];
        let key = |child: usize| {
            let node = &self.nodes[child];
            if node.remaining == 0 { f64::INFINITY } else { node.distance(point) }
        };
        let (left, right) = ((key(left), left), (key(right), right));
        let (near, far) = if right.0 < left.0 { (right, left) } else { (left, right) };
        for (distance, child) in [near, far] {
            if distance < *limit {
                self.search_node(child, point, limit, visit);
            }
        }
    }

    /// Index and label of the nearest remaining point, if any remains.
    pub(super) fn nearest(&self, point: [f64; 2]) -> Option<(usize, T)> {
        let mut nearest = None;
        self.search(point, &mut |distance, index, label| {
            nearest = Some((index, label));
            distance
        });
        nearest
    }
}
