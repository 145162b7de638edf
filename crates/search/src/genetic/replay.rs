//! Replays of genes from snapshots.
//!
//! An individual is evaluated by applying its genes, one after the other, to the start path.
//! A child begins with the same genes as one of its parents, often with most of them, and equal
//! genes lead to equal states.
//! So each individual keeps **snapshots**: copies of the state before a few fixed genes, the same
//! ones for all individuals.
//! A child takes over snapshots from the parent with which it shares the longer beginning: those up
//! to the first gene that differs.
//! Only the genes after the last of these snapshots are replayed.
//!
//! ```text
//! parent   a b c d e f g h i j k l        snapshots before d, g and j
//! child    a b c d e f g x y j k l        shares 7 genes: takes over those before d and g,
//!                      ^ starts here       and makes a new one before j
//! ```
//!
//! Snapshots are reference counted, since many descendants share them.

use std::ops::Range;
use std::sync::Arc;

use beadwork_grid::{Links, Path, PlacedVariant};

use super::gene::Gene;
use super::individual::{Individual, Score, Snapshot};
use crate::{Cost, Move};

/// The state that genes are replayed on.
pub(super) trait State: Clone + Send + Sync {
    /// Makes it a copy of another state of the same layer, without allocating.
    fn copy_from(&mut self, other: &Self);

    /// Applies a gene and returns true, or returns false and changes nothing if the gene does not
    /// apply.
    fn apply(&mut self, gene: Move) -> bool;

    /// Writes a variant as the kind of move that is replayed on this state, in a grid of the given
    /// width.
    fn gene(placed: PlacedVariant, width: u32) -> Move;

    /// Approximate size in bytes.
    fn bytes(&self) -> usize;
}

/// Replays variants only: whether they apply depends only on links, not on positions along the
/// path, and links are much cheaper to update.
impl State for Links {
    fn copy_from(&mut self, other: &Self) {
        self.copy_from(other);
    }

    #[inline]
    fn apply(&mut self, gene: Move) -> bool {
        match gene {
            Move::Variant(placed) => self.apply_variant(placed),
            Move::Pair(_) => unreachable!("pairs are replayed on a path"),
        }
    }

    fn gene(placed: PlacedVariant, _: u32) -> Move {
        Move::Variant(placed)
    }

    fn bytes(&self) -> usize {
        Self::bytes(self)
    }
}

/// Replays any moves; variants are written as pairs, since a record holds only one kind of move.
impl State for Path {
    fn copy_from(&mut self, other: &Self) {
        self.copy_from(other);
    }

    fn apply(&mut self, gene: Move) -> bool {
        gene.apply(self)
    }

    fn gene(placed: PlacedVariant, width: u32) -> Move {
        Move::Pair(placed.switches(width))
    }

    fn bytes(&self) -> usize {
        // Each cell has 4 bytes of order, 4 of position and 1 of links.
        9 * (self.width() * self.height()) as usize
    }
}

/// What all replays of a population share.
pub(super) struct Replay<'a, S, C> {
    start: &'a S,
    cost: &'a C,
    width: u32,
    /// Cost of the start path.
    pub(super) initial: i64,
    /// Indices of the genes before which a snapshot is kept, in ascending order.
    positions: Vec<usize>,
}

impl<'a, S: State, C: Cost> Replay<'a, S, C> {
    /// Prepares replays of lists of `length` genes from `state`, the state of the path `start`;
    /// each replay keeps `snapshots` snapshots.
    pub(super) fn new(
        state: &'a S,
        start: &Path,
        cost: &'a C,
        length: usize,
        snapshots: usize,
    ) -> Self {
        let positions = (1..=snapshots).map(|number| length * number / (snapshots + 1)).collect();
        Self { start: state, cost, width: start.width(), initial: cost.total(start), positions }
    }

    /// Evaluates an individual of the first population.
    /// `state` is a buffer, whose content does not matter.
    pub(super) fn first(&self, genes: &[Gene], state: &mut S) -> Individual<S> {
        state.copy_from(self.start);
        let score = Score { current: self.initial, best: self.initial, best_at: 0 };
        self.replay(genes.into(), Vec::new(), score, state)
    }

    /// Evaluates a child of two parents.
    /// `state` is a buffer, whose content does not matter.
    pub(super) fn child(
        &self,
        genes: Vec<Gene>,
        parents: [&Individual<S>; 2],
        state: &mut S,
    ) -> Individual<S> {
        let common = parents.map(|parent| common_prefix(&genes, &parent.genes));
        let (parent, common) =
            if common[0] >= common[1] { (parents[0], common[0]) } else { (parents[1], common[1]) };
        if common == genes.len() {
            return parent.copy();
        }
        // A snapshot at position p depends on the genes before p, so it is valid for the child if
        // the first p genes are the same.
        let kept = self.positions.partition_point(|&position| position <= common);
        let snapshots = parent.snapshots[..kept].to_vec();
        match snapshots.last() {
            Some(snapshot) => {
                state.copy_from(&snapshot.state);
                let score = snapshot.score;
                self.replay(genes.into(), snapshots, score, state)
            }
            None => self.first(&genes, state),
        }
    }

    /// Replays the genes after the last of the given snapshots, and adds the missing snapshots.
    fn replay(
        &self,
        genes: Arc<[Gene]>,
        mut snapshots: Vec<Arc<Snapshot<S>>>,
        mut score: Score,
        state: &mut S,
    ) -> Individual<S> {
        let mut from = snapshots.len().checked_sub(1).map_or(0, |last| self.positions[last]);
        let spared = from as u64;
        let mut replayed = 0;
        for &position in &self.positions[snapshots.len()..] {
            replayed += self.replay_range(&genes, from..position, &mut score, state);
            snapshots.push(Arc::new(Snapshot { score, state: state.clone() }));
            from = position;
        }
        replayed += self.replay_range(&genes, from..genes.len(), &mut score, state);
        let Score { best: cost, best_at, .. } = score;
        Individual { genes, cost, best_at, snapshots, replayed, spared, is_new: true }
    }

    /// Replays a range of the genes, and returns how many of them are not blank.
    fn replay_range(
        &self,
        genes: &[Gene],
        range: Range<usize>,
        score: &mut Score,
        state: &mut S,
    ) -> u64 {
        let mut replayed = 0;
        for (index, gene) in range.clone().zip(&genes[range]) {
            let Some(gene) = *gene else { continue };
            replayed += 1;
            if state.apply(gene) {
                score.current += self.cost.change(gene.switches(self.width));
                if score.current < score.best {
                    score.best = score.current;
                    score.best_at = index + 1;
                }
            }
        }
        replayed
    }

    /// The best path of an individual, and the moves that lead to it from the start path, which is
    /// given.
    pub(super) fn walk(&self, mut path: Path, individual: &Individual<S>) -> (Path, Vec<Move>) {
        let genes = individual.genes[..individual.best_at].iter().flatten();
        let moves = genes.filter(|gene| gene.apply(&mut path)).copied().collect();
        debug_assert_eq!(self.cost.total(&path), individual.cost, "changes add up to the cost");
        (path, moves)
    }
}

/// Number of snapshots of each replay, for a population of this size: the number that fits into 256
/// MB, up to a maximum.
pub(super) fn snapshots(state: &impl State, population: usize) -> usize {
    /// The paper's crossover cuts after 60 % of the genes, which is one of these positions.
    const MAX_SNAPSHOTS: usize = 9;
    const MAX_BYTES: usize = 256 << 20;

    MAX_SNAPSHOTS.min(MAX_BYTES / (state.bytes() * population).max(1))
}

/// Number of genes at the beginning that are equal.
fn common_prefix(one: &[Gene], other: &[Gene]) -> usize {
    one.iter().zip(other).position(|(a, b)| a != b).unwrap_or(one.len())
}
