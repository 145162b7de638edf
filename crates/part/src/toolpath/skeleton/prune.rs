//! Removes the parts of a medial axis that add nothing to a bead.

use std::collections::VecDeque;
use std::f64::consts::FRAC_1_SQRT_2;

use super::axis::Axis;
use super::vector::{Vector, dot, lerp};

/// A side branch is removed if it reaches no farther than this multiple of the radius at its root.
///
/// The branch into a corner of an angle reaches 1 / sin(angle / 2) times as far as the radius: 1.41
/// for a right angle, 2 for 60 degrees.
const MIN_REACH: f64 = 1.8;
/// The same multiple for the only way ahead, below which it is a round end.
const MIN_REACH_AHEAD: f64 = 1.25;
/// Unit directions in which extents are measured, which finds distances to 2 %.
const DIRECTIONS: [Vector; 16] = {
    // Cosines of multiples of 22.5 degrees.
    let [a, b, c] = [0.923_879_532_511_286_7, FRAC_1_SQRT_2, 0.382_683_432_365_089_8];
    [
        [1.0, 0.0],
        [a, c],
        [b, b],
        [c, a],
        [0.0, 1.0],
        [-c, a],
        [-b, b],
        [-a, c],
        [-1.0, 0.0],
        [-a, -c],
        [-b, -b],
        [-c, -a],
        [0.0, -1.0],
        [c, -a],
        [b, -b],
        [a, -c],
    ]
};

/// The part of a medial axis that is printed.
#[derive(Default)]
pub(super) struct Graph {
    /// Nodes.
    pub(super) nodes: Vec<Node>,
    /// For each node the adjacent ones.
    pub(super) neighbours: Vec<Vec<u32>>,
}

/// A point of the medial axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Position in mm.
    pub(super) point: Vector,
    /// Distance to the boundary, in mm.
    pub(super) radius: f64,
    /// Whether side branches were removed here, so that a bead that ends here is extended.
    pub(super) is_blunt: bool,
}

impl Graph {
    /// Prunes side branches, then cuts off what is nearer to the boundary than `min_radius` mm.
    pub(super) fn new(axis: &Axis, min_radius: f64) -> Self {
        let half_links = HalfLinks::new(axis);
        let (is_kept, is_blunt) = half_links.prune(axis);
        let mut graph = Self::default();
        let is_wide = |node: usize| axis.radii[node] >= min_radius;
        let ids: Vec<_> = (0..axis.points.len())
            .map(|node| {
                (is_kept[node] && is_wide(node)).then(|| {
                    graph.push(Node {
                        point: axis.points[node],
                        radius: axis.radii[node],
                        is_blunt: is_blunt[node],
                    })
                })
            })
            .collect();
        for link in &axis.links {
            let [a, b] = link.map(|node| node as usize);
            if !(is_kept[a] && is_kept[b]) {
                continue;
            }
            match (ids[a], ids[b]) {
                (Some(one), Some(other)) => graph.link(one, other),
                (Some(wide), None) => graph.cut(axis, wide, [a, b], min_radius),
                (None, Some(wide)) => graph.cut(axis, wide, [b, a], min_radius),
                (None, None) => {}
            }
        }
        graph
    }

    /// Adds the part of a link that is wide enough.
    fn cut(&mut self, axis: &Axis, wide: u32, [from, to]: [usize; 2], min_radius: f64) {
        let [high, low] = [axis.radii[from], axis.radii[to]];
        let t = (high - min_radius) / (high - low);
        let point = lerp(axis.points[from], axis.points[to], t);
        let end = self.push(Node { point, radius: min_radius, is_blunt: false });
        self.link(wide, end);
    }

    fn push(&mut self, node: Node) -> u32 {
        self.nodes.push(node);
        self.neighbours.push(Vec::new());
        self.nodes.len() as u32 - 1
    }

    fn link(&mut self, a: u32, b: u32) {
        self.neighbours[a as usize].push(b);
        self.neighbours[b as usize].push(a);
    }
}

/// Each link in both directions: link `i` as `2 i` and, reversed, as `2 i + 1`.
struct HalfLinks {
    /// Node to which each half link leads.
    to: Vec<usize>,
    /// Half links that leave each node.
    leaving: Vec<Vec<usize>>,
}

impl HalfLinks {
    fn new(axis: &Axis) -> Self {
        let mut half_links = Self { to: vec![], leaving: vec![vec![]; axis.points.len()] };
        for link in &axis.links {
            let [a, b] = link.map(|node| node as usize);
            for (from, to) in [(a, b), (b, a)] {
                half_links.leaving[from].push(half_links.to.len());
                half_links.to.push(to);
            }
        }
        half_links
    }

    /// Whether each node is kept, and whether it is kept and loses a side branch.
    fn prune(&self, axis: &Axis) -> (Vec<bool>, Vec<bool>) {
        let reach = self.reach(axis);
        let nodes = axis.points.len();
        let mut roots: Vec<_> = (0..nodes).collect();
        roots.sort_by(|&a, &b| axis.radii[b].total_cmp(&axis.radii[a]).then(a.cmp(&b)));

        let mut is_visited = vec![false; nodes];
        let mut is_kept = vec![false; nodes];
        let mut is_blunt = vec![false; nodes];
        let mut stack = Vec::new();
        // From the node with the largest radius of each component outwards.
        for root in roots {
            if is_visited[root] {
                continue;
            }
            is_visited[root] = true;
            is_kept[root] = true;
            stack.push(root);
            while let Some(node) = stack.pop() {
                for &half_link in &self.leaving[node] {
                    let next = self.to[half_link];
                    if is_visited[next] {
                        continue;
                    }
                    is_visited[next] = true;
                    let min_reach =
                        if self.leaving[node].len() > 2 { MIN_REACH } else { MIN_REACH_AHEAD };
                    let is_short = reach[half_link] < min_reach * axis.radii[node];
                    is_kept[next] = is_kept[node] && !is_short;
                    is_blunt[node] |= is_kept[node] && is_short;
                    stack.push(next);
                }
            }
        }
        (is_kept, is_blunt)
    }

    /// For each half link the maximum distance in mm from its start to the discs behind it,
    /// infinite if there is a cycle behind it.
    ///
    /// The distance is straight: the nodes of a round end all lie near its centre, and a path over
    /// them would go back and forth.
    fn reach(&self, axis: &Axis) -> Vec<f64> {
        let mut reach = vec![f64::INFINITY; self.to.len()];
        // Of the half links that follow: the number without a result, and the extent of the rest.
        let mut unknown: Vec<_> = self.to.iter().map(|&to| self.leaving[to].len() - 1).collect();
        let mut extent: Vec<_> = self
            .to
            .iter()
            .map(|&to| DIRECTIONS.map(|way| dot(axis.points[to], way) + axis.radii[to]))
            .collect();
        let mut queue: VecDeque<_> =
            (0..self.to.len()).filter(|&half_link| unknown[half_link] == 0).collect();
        while let Some(half_link) = queue.pop_front() {
            let from = self.to[half_link ^ 1];
            let behind = extent[half_link];
            reach[half_link] = std::iter::zip(DIRECTIONS, behind)
                .map(|(way, extent)| extent - dot(axis.points[from], way))
                .fold(0.0, f64::max);
            for &leaving in &self.leaving[from] {
                let before = leaving ^ 1;
                if leaving == half_link {
                    continue;
                }
                for (sum, behind) in std::iter::zip(&mut extent[before], behind) {
                    *sum = sum.max(behind);
                }
                unknown[before] -= 1;
                if unknown[before] == 0 {
                    queue.push_back(before);
                }
            }
        }
        reach
    }
}
