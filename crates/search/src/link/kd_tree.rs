//! Nearest points among those that are left.

use super::end::Point;

/// Maximum number of points in a leaf.
const LEAF: usize = 8;

/// Points in the plane, from which points can be removed.
///
/// Ranges of a permutation of the points form a balanced binary tree, and each node counts the
/// points that are left in its range.
/// So searches take O(log n) time however few points are left, and on coinciding points too.
#[derive(Clone)]
pub(super) struct KdTree {
    points: Vec<Point>,
    /// The points of each leaf are consecutive.
    order: Vec<u32>,
    nodes: Vec<Node>,
    /// Number of points left in each node.
    left: Vec<u32>,
    leaf_of: Vec<u32>,
    is_removed: Vec<bool>,
}

#[derive(Clone)]
struct Node {
    min: Point,
    max: Point,
    /// Range of `order`.
    range: [u32; 2],
    parent: u32,
    /// The two halves; 0 for a leaf.
    children: [u32; 2],
}

impl Node {
    /// Square of the distance from the bounding box.
    #[inline]
    fn distance2(&self, point: Point) -> f64 {
        let outside = |k: usize| (self.min[k] - point[k]).max(point[k] - self.max[k]).max(0.0);
        let [x, y] = [outside(0), outside(1)];
        x * x + y * y
    }
}

/// Square of the distance of two points.
#[inline]
pub(super) fn distance2(a: Point, b: Point) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    x * x + y * y
}

impl KdTree {
    /// A tree of points with finite coordinates.
    pub(super) fn new(points: &[Point]) -> Self {
        let count = points.len();
        let mut tree = Self {
            points: points.to_vec(),
            order: (0..count as u32).collect(),
            nodes: Vec::new(),
            left: Vec::new(),
            leaf_of: vec![0; count],
            is_removed: vec![false; count],
        };
        if count > 0 {
            tree.build(0, count, 0);
        }
        tree.restore();
        tree
    }

    fn build(&mut self, from: usize, to: usize, parent: u32) -> u32 {
        let number = self.nodes.len() as u32;
        let points = &self.points;
        let first = points[self.order[from] as usize];
        let [mut min, mut max] = [first; 2];
        for &index in &self.order[from..to] {
            let point = points[index as usize];
            min = [0, 1].map(|k| min[k].min(point[k]));
            max = [0, 1].map(|k| max[k].max(point[k]));
        }
        let range = [from as u32, to as u32];
        self.nodes.push(Node { min, max, range, parent, children: [0; 2] });
        if to - from <= LEAF {
            for &index in &self.order[from..to] {
                self.leaf_of[index as usize] = number;
            }
            return number;
        }
        let axis = usize::from(max[1] - min[1] > max[0] - min[0]);
        let middle = usize::midpoint(from, to);
        self.order[from..to].select_nth_unstable_by(middle - from, |&a, &b| {
            points[a as usize][axis].total_cmp(&points[b as usize][axis]).then(a.cmp(&b))
        });
        let children = [self.build(from, middle, number), self.build(middle, to, number)];
        self.nodes[number as usize].children = children;
        number
    }

    /// Puts all points back.
    pub(super) fn restore(&mut self) {
        self.is_removed.fill(false);
        self.left.clear();
        self.left.extend(self.nodes.iter().map(|node| node.range[1] - node.range[0]));
    }

    /// Removes a point that is left.
    pub(super) fn remove(&mut self, index: usize) {
        self.is_removed[index] = true;
        let mut node = self.leaf_of[index] as usize;
        loop {
            self.left[node] -= 1;
            if node == 0 {
                return;
            }
            node = self.nodes[node].parent as usize;
        }
    }

    /// The point that is left nearest to a position, of several the one with the lowest index.
    pub(super) fn nearest(&self, position: Point) -> Option<usize> {
        let mut best = (f64::INFINITY, usize::MAX);
        if !self.nodes.is_empty() {
            self.search(0, position, &mut best);
        }
        (best.1 != usize::MAX).then_some(best.1)
    }

    fn search(&self, number: u32, position: Point, best: &mut (f64, usize)) {
        let node = &self.nodes[number as usize];
        let [from, to] = node.range.map(|index| index as usize);
        if node.children[0] == 0 {
            for &index in &self.order[from..to] {
                let index = index as usize;
                let found = (distance2(self.points[index], position), index);
                if !self.is_removed[index] && found < *best {
                    *best = found;
                }
            }
            return;
        }
        let mut children =
            node.children.map(|child| (self.nodes[child as usize].distance2(position), child));
        if children[1].0 < children[0].0 {
            children.reverse();
        }
        for (distance2, child) in children {
            if self.left[child as usize] > 0 && distance2 <= best.0 {
                self.search(child, position, best);
            }
        }
    }

    /// The points that are left within a distance of a position, nearest first, at most `limit`.
    pub(super) fn within(&self, position: Point, distance: f64, limit: usize) -> Vec<(f64, u32)> {
        let mut found = Vec::new();
        let mut radius2 = distance * distance;
        if !self.nodes.is_empty() && limit > 0 {
            self.collect(0, position, &mut radius2, limit, &mut found);
        }
        keep_nearest(&mut found, limit);
        found
    }

    fn collect(
        &self,
        number: u32,
        position: Point,
        radius2: &mut f64,
        limit: usize,
        found: &mut Vec<(f64, u32)>,
    ) {
        let node = &self.nodes[number as usize];
        let [from, to] = node.range.map(|index| index as usize);
        if node.children[0] == 0 {
            for &index in &self.order[from..to] {
                let distance2 = distance2(self.points[index as usize], position);
                if !self.is_removed[index as usize] && distance2 <= *radius2 {
                    found.push((distance2, index));
                }
            }
            if found.len() >= 4 * limit {
                keep_nearest(found, limit);
                // Points at the same distance but with a lower index still count, unless too many
                // coincide with the position that a search for all would be slow.
                let farthest = found[limit - 1].0;
                *radius2 = if farthest > 0.0 { farthest } else { -1.0 };
            }
            return;
        }
        let mut children =
            node.children.map(|child| (self.nodes[child as usize].distance2(position), child));
        if children[1].0 < children[0].0 {
            children.reverse();
        }
        for (distance2, child) in children {
            if self.left[child as usize] > 0 && distance2 <= *radius2 {
                self.collect(child, position, radius2, limit, found);
            }
        }
    }
}

fn keep_nearest(found: &mut Vec<(f64, u32)>, limit: usize) {
    found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(limit);
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn searches_find_what_a_scan_finds() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for round in 0..200 {
            let count = rng.random_range(0..200);
            // Few different coordinates, so that many points coincide.
            let mut coordinate = || f64::from(rng.random_range(0..(2 + round / 4)));
            let points: Vec<Point> = (0..count).map(|_| [coordinate(), coordinate()]).collect();
            let mut tree = KdTree::new(&points);
            let mut left: Vec<usize> = (0..count).collect();
            while !left.is_empty() {
                let position = [0, 1].map(|_| rng.random_range(-5.0..60.0));
                let key = |&index: &usize| distance2(points[index], position);
                let scan = left.iter().copied().min_by(|a, b| key(a).total_cmp(&key(b)));
                assert_eq!(tree.nearest(position), scan);
                let radius = rng.random_range(0.0..30.0);
                let mut near: Vec<(f64, u32)> = left
                    .iter()
                    .map(|index| (key(index), *index as u32))
                    .filter(|near| near.0 <= radius * radius)
                    .collect();
                keep_nearest(&mut near, 5);
                assert_eq!(tree.within(position, radius, 5), near);
                let removed = left.swap_remove(rng.random_range(0..left.len()));
                left.sort_unstable();
                tree.remove(removed);
            }
            assert_eq!(tree.nearest([0.0; 2]), None);
            tree.restore();
            assert_eq!(tree.nearest([0.0; 2]).is_some(), count > 0);
        }
    }
}
