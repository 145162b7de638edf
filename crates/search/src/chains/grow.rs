//! The best chain that begins with a given variant.

use std::collections::{HashSet, VecDeque};

use beadwork_grid::{Links, Path, PlacedVariant, Switch};

use super::Settings;
use crate::Cost;

/// Weight of the cost beside the distance to where it can change, in the choice of chains to
/// pursue.
const GAIN_WEIGHT: i64 = 6;

/// Windows whose first cells lie at most so far apart, along x and y, can overlap.
const OVERLAP: u16 = 2;

/// A chain that lowers the cost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) moves: Vec<PlacedVariant>,
    /// By how much, positive.
    pub(super) gain: i64,
}

impl Found {
    /// Whether it gains more for each move or, gaining the same, begins closer to the move made
    /// last.
    pub(super) fn is_better_than(&self, other: &Self, last: Option<PlacedVariant>) -> bool {
        let rate = |a: &Self, b: &Self| a.gain * b.moves.len() as i64;
        let (own, others) = (rate(self, other), rate(other, self));
        let distance = |chain: &Self| {
            let first = chain.moves[0];
            last.map_or(0, |last| first.x.abs_diff(last.x).max(first.y.abs_diff(last.y)))
        };
        own > others || own == others && distance(self) < distance(other)
    }
}

/// A rectangle of cells, both ends included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    x: [u16; 2],
    y: [u16; 2],
}

impl Reach {
    /// The cells of a window whose links a variant changes.
    pub(super) fn window(placed: PlacedVariant) -> Self {
        Self { x: [placed.x, placed.x + 2], y: [placed.y, placed.y + 2] }
    }

    /// Whether they share a cell.
    pub(super) fn meets(self, other: Self) -> bool {
        let meet = |a: [u16; 2], b: [u16; 2]| a[0] <= b[1] && b[0] <= a[1];
        meet(self.x, other.x) && meet(self.y, other.y)
    }

    /// Takes in all windows that can overlap a variant's.
    fn follow(&mut self, placed: PlacedVariant) {
        let take = |range: &mut [u16; 2], at: u16| {
            range[0] = range[0].min(at.saturating_sub(OVERLAP));
            range[1] = range[1].max(at + OVERLAP + 2);
        };
        take(&mut self.x, placed.x);
        take(&mut self.y, placed.y);
    }
}

/// Grows chains in one plane.
pub(super) struct Grower<'a, C> {
    cost: &'a C,
    settings: &'a Settings<'a>,
    width: u32,
    /// For each cell how many steps it lies from a corner where a switch can change the cost.
    distance: Vec<u32>,
}

/// The last move of a chain; the others are its ancestors.
struct Node {
    placed: PlacedVariant,
    parent: Option<usize>,
    /// Change of the cost by the whole chain.
    change: i64,
    /// Of the links after it: equal for equal links.
    key: u64,
}

impl<'a, C: Cost> Grower<'a, C> {
    pub(super) fn new(plane: &Path, cost: &'a C, settings: &'a Settings<'a>) -> Self {
        let distance = distances(plane.width(), plane.height(), cost);
        Self { cost, settings, width: plane.width(), distance }
    }

    /// The best chain from a variant that applies, if one within the settings' limits lowers the
    /// cost, and all cells at which the search looked.
    /// The links are the same afterwards.
    pub(super) fn grow(&self, links: &mut Links, first: PlacedVariant) -> (Option<Found>, Reach) {
        let mut nodes = vec![self.node(first, None, 0, 0)];
        let mut front = vec![0];
        let mut seen = HashSet::from([0, nodes[0].key]);
        let mut best: Option<(usize, usize, i64)> = None;
        let mut reach = Reach::window(first);
        for length in 1..=self.settings.depth {
            for &at in &front {
                let gain = -nodes[at].change;
                let (_, best_length, best_gain) = best.unwrap_or((at, 1, 0));
                if gain * best_length as i64 > best_gain * length as i64 {
                    best = Some((at, length, gain));
                }
            }
            if best
                .is_some_and(|(_, best_length, _)| length >= best_length + self.settings.patience)
            {
                break;
            }
            let mut next = Vec::new();
            for &at in &front {
                let chain = chain(&nodes, at);
                chain
                    .iter()
                    .for_each(|&placed| assert!(links.apply_variant(placed), "the chain applies"));
                let Node { placed: last, change, key, .. } = nodes[at];
                reach.follow(last);
                for y in last.y.saturating_sub(OVERLAP)..=last.y + OVERLAP {
                    for x in last.x.saturating_sub(OVERLAP)..=last.x + OVERLAP {
                        links.for_each_variant_at(x, y, |placed| {
                            let node = self.node(placed, Some(at), change, key);
                            if seen.insert(node.key) {
                                next.push(nodes.len());
                                nodes.push(node);
                            }
                        });
                    }
                }
                chain.iter().rev().for_each(|&placed| links.undo_variant(placed));
            }
            next.sort_by_key(|&at| self.promise(&nodes[at]));
            next.truncate(self.settings.beam);
            if next.is_empty() {
                break;
            }
            front = next;
        }
        (best.map(|(at, _, gain)| Found { moves: chain(&nodes, at), gain }), reach)
    }

    fn node(&self, placed: PlacedVariant, parent: Option<usize>, change: i64, key: u64) -> Node {
        let switches = placed.switches(self.width);
        Node {
            placed,
            parent,
            change: change + self.cost.change(switches),
            key: switches.iter().fold(key, |key, switch| key ^ switch.zobrist_key()),
        }
    }

    /// What a chain is pursued for, the less the better: its cost, and how far it still is from
    /// changing it.
    fn promise(&self, node: &Node) -> i64 {
        let corners = node.placed.switches(self.width).map(Switch::corner);
        let near = corners.map(|corner| self.distance[corner as usize]).into_iter().min();
        GAIN_WEIGHT * node.change + i64::from(near.expect("two switches"))
    }
}

/// The moves of a chain, the first one first.
fn chain(nodes: &[Node], last: usize) -> Vec<PlacedVariant> {
    let mut moves: Vec<_> = std::iter::successors(Some(last), |&at| nodes[at].parent)
        .map(|at| nodes[at].placed)
        .collect();
    moves.reverse();
    moves
}

/// Steps from each cell to the nearest corner where a switch can change the cost; far more than any
/// where there is none.
fn distances<C: Cost>(width: u32, height: u32, cost: &C) -> Vec<u32> {
    let mut distance = vec![u32::MAX; (width * height) as usize];
    let mut waiting = VecDeque::new();
    for y in 0..height.saturating_sub(1) {
        for x in 0..width.saturating_sub(1) {
            let corner = y * width + x;
            if cost.is_sensitive(corner, width) {
                distance[corner as usize] = 0;
                waiting.push_back(corner);
            }
        }
    }
    while let Some(cell) = waiting.pop_front() {
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
                waiting.push_back(neighbour);
            }
        }
    }
    distance
}
