//! Lower bounds on travel by Lagrangian relaxation, after Held and Karp, "The traveling-salesman
//! problem and minimum spanning trees" (Operations Research 18, 1970).
//!
//! The nodes are the two ends of each bead, joined by the bead itself, and the loops, whose
//! distance from others is that of their nearest entries.
//! The travel of a route is a spanning tree of these nodes, a departure and an arrival, such that
//! each end of a bead has one link and each loop two.
//! Without the condition on the numbers of links, the cheapest tree is a lower bound.
//!
//! So a **multiplier** is added to each link of a node, and subtracted again as often as a route
//! links the node.
//! A route costs the same as before, so the minimum is a lower bound for any multipliers.
//! Raising the multipliers of nodes with too many links, and lowering those of nodes with too few,
//! makes the tree more like a route, and the bound better: a subgradient method.
//!
//! If groups stay together, so do their nodes in the tree: links have **classes**, and a tree
//! prefers all links of a lower class to those of a higher one.
//!
//! Distances are rounded down to integers and multipliers are integers, so the bound is exact.

use beadwork_base::Control;

use super::item::Shape;
use super::kd_tree::KdTree;
use super::problem::Problem;
use super::route::distance;

/// Maximum number of items for which a bound is computed.
pub const MAX_BOUNDED: usize = 1500;

/// Bits of a distance; the class is above.
const DISTANCE_BITS: u32 = 30;
/// Weight of a class, beyond all sums of a distance and two multipliers.
const CLASS: i64 = 1 << 50;
/// Largest absolute value of a multiplier.
const MAX_MULTIPLIER: i64 = 1 << 46;
/// The class of links that no route has.
const NEVER: u32 = 3;

/// Lower bound on the travel of all allowed routes, in mm; 0 if there is no item, `None` if there
/// are more than [`MAX_BOUNDED`].
///
/// `known_mm` is the travel of some route, which limits the length of the steps.
/// O(n²) steps for each iteration, and O(m² log m) for all pairs of m entries of loops at worst.
pub(super) fn bound(
    problem: &Problem<'_>,
    known_mm: f64,
    iterations: u32,
    control: &Control<'_>,
) -> Option<f64> {
    if problem.items.len() > MAX_BOUNDED {
        return None;
    }
    // Extents below this are not worth the care for underflow.
    if known_mm <= 0.0 || problem.extent < 1e-100 {
        return Some(0.0);
    }
    let graph = Graph::new(problem);
    let known = (known_mm * graph.scale).ceil() as i64 + 1;
    let mut best = 0;
    let mut multipliers = vec![0_i64; graph.nodes.len()];
    let mut tree = Tree::new(graph.nodes.len());
    let mut direction = vec![0.0; graph.nodes.len()];
    let mut length = 1.0;
    let mut failed = 0;
    for iteration in 0..iterations {
        if control.interrupted().is_some() {
            break;
        }
        let bound = tree.minimum(&graph, &multipliers);
        if bound > best {
            best = bound;
            failed = 0;
        } else {
            failed += 1;
            if failed == 5 {
                failed = 0;
                length *= 0.6;
            }
        }
        let mut norm = 0.0;
        for ((direction, node), &links) in direction.iter_mut().zip(&graph.nodes).zip(&tree.links) {
            let excess = f64::from(links) - f64::from(node.links);
            // A part of the previous direction damps oscillation.
            *direction = if iteration == 0 { excess } else { 0.7 * excess + 0.3 * *direction };
            norm += excess * excess;
        }
        if norm == 0.0 || best >= known {
            break;
        }
        let step = length * (known - bound) as f64 / norm;
        for (multiplier, direction) in multipliers.iter_mut().zip(&direction) {
            let changed = *multiplier + (step * direction).round() as i64;
            *multiplier = changed.clamp(-MAX_MULTIPLIER, MAX_MULTIPLIER);
        }
    }
    // Sums of rounded distances may be smaller than the exact sums by up to this share.
    Some(best as f64 / graph.scale * (1.0 - 1e-12))
}

/// An end of a bead, or a loop.
struct Node {
    item: u32,
    /// Number of links that a route has at the node.
    links: u8,
    /// Index of the node at the other end of the bead, or of this node.
    across: u32,
    /// Length of the departure of a route to this node, in units; `None` if none begins here.
    departure: Option<i64>,
    /// Whether a route can end here.
    arrives: bool,
}

struct Graph {
    /// Units in a mm, a power of two.
    scale: f64,
    nodes: Vec<Node>,
    /// For each pair of nodes the distance in units, rounded down, and the class of the link.
    pairs: Vec<u32>,
}

impl Graph {
    fn new(problem: &Problem<'_>) -> Self {
        let scale =
            libm::exp2(f64::from(DISTANCE_BITS) - 1.0 - libm::ceil(libm::log2(problem.extent)));
        let mut nodes = Vec::new();
        let mut points: Vec<&[[f64; 2]]> = Vec::new();
        for (index, item) in problem.items.iter().enumerate() {
            let here = nodes.len() as u32;
            let leaf = problem.leaf[index + 1];
            let group = problem.group[index + 1] as usize;
            let begins = leaf == problem.first_leaf[group];
            let arrives = leaf + 1 == problem.first_leaf[group + 1];
            let node = |links, across, points: &[[f64; 2]], begins: bool, arrives| Node {
                item: index as u32 + 1,
                links,
                across,
                departure: begins.then(|| match problem.from {
                    Some(from) => units(scale, set_distance(&[from], points, None)),
                    None => 0,
                }),
                arrives,
            };
            match &item.shape {
                Shape::Bead { start, end, reversible } => {
                    let [start, end] = [start, end].map(std::slice::from_ref);
                    nodes.push(node(1, here + 1, start, begins, arrives && *reversible));
                    nodes.push(node(1, here, end, begins && *reversible, arrives));
                    points.extend([start, end]);
                }
                Shape::Loop { entries } => {
                    nodes.push(node(2, here, entries, begins, arrives));
                    points.push(entries);
                }
            }
        }
        let trees: Vec<Option<KdTree<()>>> = points.iter().map(|points| tree(points)).collect();
        let mut pairs = vec![0; nodes.len() * nodes.len()];
        for (a, node) in nodes.iter().enumerate() {
            for b in 0..a {
                let length = match &trees[a] {
                    Some(tree) => set_distance(points[b], points[a], Some(tree)),
                    None => set_distance(points[a], points[b], trees[b].as_ref()),
                };
                let class = class(problem, [node, &nodes[b]], [a, b]);
                let pair = units(scale, length) as u32 | class << DISTANCE_BITS;
                pairs[a * nodes.len() + b] = pair;
                pairs[b * nodes.len() + a] = pair;
            }
        }
        Self { scale, nodes, pairs }
    }
}

/// A length rounded down to units.
fn units(scale: f64, length: f64) -> i64 {
    // Lengths have up to 2^29 units and relative errors of a few 2^-53.
    (length * scale - 1.0 / f64::from(1 << 20)).max(0.0) as i64
}

/// A tree of the entries of a loop, if it has many.
fn tree(points: &[[f64; 2]]) -> Option<KdTree<()>> {
    (points.len() > 8).then(|| KdTree::new(points.iter().map(|&point| (point, ())).collect()))
}

/// Distance of the nearest points of two sets; `tree` holds those of the second.
fn set_distance(points: &[[f64; 2]], others: &[[f64; 2]], tree: Option<&KdTree<()>>) -> f64 {
    let mut minimum = f64::INFINITY;
    for &point in points {
        match tree {
            Some(tree) => tree.search_within(point, minimum, &mut |distance, _, ()| {
                minimum = distance;
                distance
            }),
            None => {
                minimum =
                    others.iter().map(|&other| distance(point, other)).fold(minimum, f64::min);
            }
        }
    }
    minimum
}

/// Class of the link between two nodes: within a leaf, between successive stages of a group or
/// between groups, or [`NEVER`].
fn class(problem: &Problem<'_>, nodes: [&Node; 2], indices: [usize; 2]) -> u32 {
    let [a, b] = nodes.map(|node| node.item as usize);
    // A bead that must not be reversed is entered at its first node and left at the second.
    let irreversible = [a, b].map(|item| problem.is_irreversible[item]);
    let is_second = [0, 1].map(|side| (nodes[side].across as usize) < indices[side]);
    if irreversible == [true; 2] && is_second[0] == is_second[1] {
        return NEVER;
    }
    let leaves = [a, b].map(|item| problem.leaf[item]);
    let groups = [a, b].map(|item| problem.group[item] as usize);
    if !problem.has_blocks || leaves[0] == leaves[1] {
        return 0;
    }
    if groups[0] == groups[1] {
        return if leaves[0].abs_diff(leaves[1]) == 1 { 1 } else { NEVER };
    }
    let is_first = [0, 1].map(|side| leaves[side] == problem.first_leaf[groups[side]]);
    let is_last = [0, 1].map(|side| leaves[side] + 1 == problem.first_leaf[groups[side] + 1]);
    if (is_last[0] && is_first[1]) || (is_last[1] && is_first[0]) { 2 } else { NEVER }
}

/// A minimum spanning tree with a departure and an arrival.
struct Tree {
    /// Number of links at each node.
    links: Vec<u32>,
    /// Nodes outside the tree: weight of the cheapest link, its node inside, and the node.
    outside: Vec<(i64, u32, u32)>,
    position: Vec<u32>,
}

impl Tree {
    fn new(nodes: usize) -> Self {
        Self { links: vec![0; nodes], outside: Vec::with_capacity(nodes), position: vec![0; nodes] }
    }

    /// Finds the tree by the method of Prim, and returns the bound in units.
    fn minimum(&mut self, graph: &Graph, multipliers: &[i64]) -> i64 {
        let count = graph.nodes.len();
        self.links.fill(0);
        self.outside.clear();
        self.outside.extend((0..count as u32).map(|node| (i64::MAX, 0, node)));
        self.position.iter_mut().zip(0..).for_each(|(position, index)| *position = index);
        let mut sum = 0;
        let mut next = 0;
        loop {
            self.add(graph, multipliers, next);
            let across = graph.nodes[next as usize].across;
            if across != next {
                self.add(graph, multipliers, across);
            }
            let Some(&(_, from, node)) = self.outside.iter().min() else { break };
            let pair = graph.pairs[from as usize * count + node as usize];
            let length = i64::from(pair & ((1 << DISTANCE_BITS) - 1));
            sum += length + multipliers[from as usize] + multipliers[node as usize];
            self.links[from as usize] += 1;
            self.links[node as usize] += 1;
            next = node;
        }
        sum += self.add_anchor(graph, multipliers);
        let constant = graph.nodes.iter().zip(multipliers);
        sum - constant.map(|(node, multiplier)| i64::from(node.links) * multiplier).sum::<i64>()
    }

    /// Moves a node into the tree.
    fn add(&mut self, graph: &Graph, multipliers: &[i64], node: u32) {
        let position = self.position[node as usize] as usize;
        self.outside.swap_remove(position);
        if let Some(&(_, _, moved)) = self.outside.get(position) {
            self.position[moved as usize] = position as u32;
        }
        let count = graph.nodes.len();
        let row = &graph.pairs[node as usize * count..][..count];
        let own = multipliers[node as usize];
        for (weight, from, other) in &mut self.outside {
            let pair = row[*other as usize];
            let length = i64::from(pair & ((1 << DISTANCE_BITS) - 1));
            let class = i64::from(pair >> DISTANCE_BITS) * CLASS;
            let here = class + length + own + multipliers[*other as usize];
            if here < *weight {
                (*weight, *from) = (here, node);
            }
        }
    }

    /// Adds the cheapest departure and arrival, at different items if there are several.
    fn add_anchor(&mut self, graph: &Graph, multipliers: &[i64]) -> i64 {
        let nodes = || graph.nodes.iter().zip(multipliers).enumerate();
        let departures = nodes().filter_map(|(index, (node, multiplier))| {
            Some((node.departure? + multiplier, index, node.item))
        });
        let arrivals = nodes()
            .filter(|(_, (node, _))| node.arrives)
            .map(|(index, (node, &multiplier))| (multiplier, index, node.item));
        let departures = two_cheapest(departures);
        let arrivals = two_cheapest(arrivals);
        let pairs = departures
            .iter()
            .flat_map(|departure| arrivals.iter().map(move |arrival| (departure, arrival)));
        let is_single = graph.nodes.iter().all(|node| node.item == graph.nodes[0].item);
        let cheapest = pairs
            .filter(|(departure, arrival)| is_single || departure.2 != arrival.2)
            .min_by_key(|(departure, arrival)| departure.0 + arrival.0);
        let Some((departure, arrival)) = cheapest else { return 0 };
        self.links[departure.1] += 1;
        self.links[arrival.1] += 1;
        departure.0 + arrival.0
    }
}

/// The cheapest of the given weights, and the cheapest one of another item: weight, node and item.
fn two_cheapest(weights: impl Iterator<Item = (i64, usize, u32)>) -> Vec<(i64, usize, u32)> {
    let mut cheapest: Vec<(i64, usize, u32)> = Vec::with_capacity(3);
    for weight in weights {
        let slot = cheapest.iter().position(|other| other.2 == weight.2);
        match slot {
            Some(slot) if cheapest[slot].0 <= weight.0 => continue,
            Some(slot) => cheapest[slot] = weight,
            None => cheapest.push(weight),
        }
        cheapest.sort_unstable();
        cheapest.truncate(2);
    }
    cheapest
}
