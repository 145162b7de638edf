//! Beam search for the best chain that begins with a given variant.
//!
//! All chains of one length are extended together.
//! The most promising of their extensions, the *beam*, are kept; a chain is promising if its cost
//! is low and its last move lies near a unit cell where the cost can change.
//! Different chains often lead to the same links, for example when two independent moves are
//! exchanged; only the first chain to reach them is extended.
//!
//! Chains are stored as a tree, each node with its last move and its parent.
//! To extend a chain its moves are applied to the links, and undone afterwards.

use std::collections::{HashSet, VecDeque};

use beadwork_grid::{Links, Path, PlacedVariant, Switch};

use crate::Cost;

/// Weight of a unit of cost, relative to one cell of distance from where the cost can change.
const COST_WEIGHT: i64 = 6;

/// Two windows can overlap if their first cells are at most this far apart along x and along y.
const OVERLAP: u16 = 2;

/// Limits of a beam search; see [`Settings`](super::Settings).
#[derive(Clone, Copy)]
pub(super) struct Beam {
    pub(super) width: usize,
    pub(super) depth: usize,
    pub(super) patience: usize,
}

/// A chain that lowers the cost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Chain {
    pub(super) moves: Vec<PlacedVariant>,
    /// The amount by which it lowers the cost; positive.
    pub(super) gain: i64,
}

impl Chain {
    /// Whether it has a larger gain per move or, at the same gain per move, begins closer to the
    /// `last` move made.
    pub(super) fn is_better_than(&self, other: &Self, last: Option<PlacedVariant>) -> bool {
        // Compares gain / moves without dividing.
        let product = |a: &Self, b: &Self| a.gain * b.moves.len() as i64;
        let (own, others) = (product(self, other), product(other, self));
        let distance = |chain: &Self| {
            let first = chain.moves[0];
            last.map_or(0, |last| first.x.abs_diff(last.x).max(first.y.abs_diff(last.y)))
        };
        own > others || own == others && distance(self) < distance(other)
    }
}

/// A rectangle of cells: the first and the last column and row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    x: [u16; 2],
    y: [u16; 2],
}

impl Extent {
    /// The cells whose links a variant can change.
    pub(super) fn window(placed: PlacedVariant) -> Self {
        Self { x: [placed.x, placed.x + 2], y: [placed.y, placed.y + 2] }
    }

    /// Whether two rectangles have a cell in common.
    pub(super) fn overlaps(self, other: Self) -> bool {
        let overlap = |a: [u16; 2], b: [u16; 2]| a[0] <= b[1] && b[0] <= a[1];
        overlap(self.x, other.x) && overlap(self.y, other.y)
    }

    /// Extends it to all windows that can overlap the window of a variant.
    fn include_overlapping(&mut self, placed: PlacedVariant) {
        let include = |range: &mut [u16; 2], at: u16| {
            range[0] = range[0].min(at.saturating_sub(OVERLAP));
            range[1] = range[1].max(at + OVERLAP + 2);
        };
        include(&mut self.x, placed.x);
        include(&mut self.y, placed.y);
    }
}

/// Searches for chains on one grid.
pub(super) struct Grower<'a, C> {
    cost: &'a C,
    beam: Beam,
    width: u32,
    /// For each cell the number of steps to the nearest corner of a unit cell where a switch can
    /// change the cost.
    distance: Vec<u32>,
}

/// The last move of a chain, whose other moves are those of the node's ancestors.
struct Node {
    placed: PlacedVariant,
    parent: Option<usize>,
    /// Change of the cost by the whole chain.
    change: i64,
    /// Zobrist hash of the links after the chain: the same for the same links.
    hash: u64,
}

impl<'a, C: Cost> Grower<'a, C> {
    /// Prepares searches on the grid of a path.
    pub(super) fn new(path: &Path, cost: &'a C, beam: Beam) -> Self {
        let distance = distances(path.width(), path.height(), cost);
        Self { cost, beam, width: path.width(), distance }
    }

    /// Returns the chain with the largest gain per move that begins with `first`, which must apply,
    /// or `None` if the search found no chain with a gain; and the cells that the search examined.
    /// Leaves the links as they were.
    pub(super) fn grow(&self, links: &mut Links, first: PlacedVariant) -> (Option<Chain>, Extent) {
        let mut nodes = vec![self.node(first, None, 0, 0)];
        let mut front = vec![0];
        // The links before the chain have the hash 0.
        let mut seen = HashSet::from([0, nodes[0].hash]);
        // Node, length and gain of the best chain.
        let mut best: Option<(usize, usize, i64)> = None;
        let mut examined = Extent::window(first);
        for length in 1..=self.beam.depth {
            for &at in &front {
                let gain = -nodes[at].change;
                let (_, best_length, best_gain) = best.unwrap_or((at, 1, 0));
                if gain * best_length as i64 > best_gain * length as i64 {
                    best = Some((at, length, gain));
                }
            }
            if best.is_some_and(|(_, best_length, _)| length >= best_length + self.beam.patience) {
                break;
            }
            let mut next = Vec::new();
            for &at in &front {
                let chain = chain(&nodes, at);
                chain
                    .iter()
                    .for_each(|&placed| assert!(links.apply_variant(placed), "the chain applies"));
                let Node { placed: last, change, hash, .. } = nodes[at];
                examined.include_overlapping(last);
                for y in last.y.saturating_sub(OVERLAP)..=last.y + OVERLAP {
                    for x in last.x.saturating_sub(OVERLAP)..=last.x + OVERLAP {
                        links.for_each_variant_at(x, y, |placed| {
                            let node = self.node(placed, Some(at), change, hash);
                            if seen.insert(node.hash) {
                                next.push(nodes.len());
                                nodes.push(node);
                            }
                        });
                    }
                }
                chain.iter().rev().for_each(|&placed| links.undo_variant(placed));
            }
            next.sort_by_key(|&at| self.promise(&nodes[at]));
            next.truncate(self.beam.width);
            if next.is_empty() {
                break;
            }
            front = next;
        }
        (best.map(|(at, _, gain)| Chain { moves: chain(&nodes, at), gain }), examined)
    }

    fn node(&self, placed: PlacedVariant, parent: Option<usize>, change: i64, hash: u64) -> Node {
        let switches = placed.switches(self.width);
        Node {
            placed,
            parent,
            change: change + self.cost.change(switches),
            hash: switches.iter().fold(hash, |hash, switch| hash ^ switch.zobrist_key()),
        }
    }

    /// How promising a chain is; lower is better.
    /// Weighs its cost against the distance of its last move to where the cost can change.
    fn promise(&self, node: &Node) -> i64 {
        let corners = node.placed.switches(self.width).map(Switch::corner);
        let nearest = corners.map(|corner| self.distance[corner as usize]).into_iter().min();
        COST_WEIGHT * node.change + i64::from(nearest.expect("a move has two switches"))
    }
}

/// The moves of a chain, in order.
fn chain(nodes: &[Node], last: usize) -> Vec<PlacedVariant> {
    let mut moves: Vec<_> = std::iter::successors(Some(last), |&at| nodes[at].parent)
        .map(|at| nodes[at].placed)
        .collect();
    moves.reverse();
    moves
}

/// The number of steps from each cell to the nearest corner of a unit cell where a switch can
/// change the cost, by breadth-first search; `u32::MAX` if there is no such unit cell.
fn distances<C: Cost>(width: u32, height: u32, cost: &C) -> Vec<u32> {
    let mut distance = vec![u32::MAX; (width * height) as usize];
    let mut queue = VecDeque::new();
    for y in 0..height.saturating_sub(1) {
        for x in 0..width.saturating_sub(1) {
            let corner = y * width + x;
            if cost.is_sensitive(corner, width) {
                distance[corner as usize] = 0;
                queue.push_back(corner);
            }
        }
    }
    while let Some(cell) = queue.pop_front() {
        let (x, y) = (cell % width, cell / width);
        let neighbours = [
            (x > 0).then(|| cell - 1),
            (x + 1 < width).then(|| cell + 1),
            (y > 0).then(|| cell - width),
            (y + 1 < height).then(|| cell + width),
        ];
        for neighbour in neighbours.into_iter().flatten() {
            if distance[neighbour as usize] == u32::MAX {
                distance[neighbour as usize] = distance[cell as usize] + 1;
                queue.push_back(neighbour);
            }
        }
    }
    distance
}
