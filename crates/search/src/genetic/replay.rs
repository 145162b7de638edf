//! Replays of genes, each from the last known state before the first gene that is new.

use std::sync::Arc;

use beadwork_grid::{Links, Path, PlacedVariant};

use super::individual::{Gene, Individual};
use crate::{Cost, Move};

/// What genes are replayed on.
pub(super) trait State: Clone + Send + Sync {
    /// Makes it a copy of another state of the same layer.
    fn copy_from(&mut self, other: &Self);

    /// Applies a gene; where it does not apply it changes nothing and gives false.
    fn apply(&mut self, gene: Move) -> bool;

    /// A variant as a gene of the sort that is replayed here, in a plane so many cells wide.
    fn gene(placed: PlacedVariant, width: u32) -> Move;

    /// Bytes it takes, about.
    fn bytes(&self) -> usize;
}

/// Variants alone.
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

/// Any moves; variants are written as pairs, for a record holds one sort.
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
        // Order, position and links.
        9 * (self.width() * self.height()) as usize
    }
}

/// Where a replay stands.
#[derive(Clone, Copy)]
struct Score {
    present: i64,
    best: i64,
    best_at: usize,
}

/// A replay half way.
pub(super) struct Mark<S> {
    score: Score,
    state: S,
}

/// What all replays share.
pub(super) struct Replay<'a, S, C> {
    start: &'a S,
    cost: &'a C,
    width: u32,
    pub(super) initial: i64,
    /// Genes before which a state is kept, rising.
    places: Vec<usize>,
}

impl<'a, S: State, C: Cost> Replay<'a, S, C> {
    /// Prepares replays of lists of so many genes from `state`, which is that of `start`; each
    /// replay keeps so many states.
    pub(super) fn new(
        state: &'a S,
        start: &Path,
        cost: &'a C,
        length: usize,
        marks: usize,
    ) -> Self {
        let places = (1..=marks).map(|mark| length * mark / (marks + 1)).collect();
        Self { start: state, cost, width: start.width(), initial: cost.total(start), places }
    }

    /// An individual of the first population.
    pub(super) fn first(&self, genes: &[Gene], state: &mut S) -> Individual<S> {
        state.copy_from(self.start);
        let score = Score { present: self.initial, best: self.initial, best_at: 0 };
        self.replay(genes.into(), Vec::new(), score, state)
    }

    /// A child of two parents.
    pub(super) fn child(
        &self,
        genes: Vec<Gene>,
        parents: [&Individual<S>; 2],
        state: &mut S,
    ) -> Individual<S> {
        let common = parents.map(|parent| common_beginning(&genes, &parent.genes));
        let (parent, common) =
            if common[0] >= common[1] { (parents[0], common[0]) } else { (parents[1], common[1]) };
        if common == genes.len() {
            return parent.copy();
        }
        let kept = self.places.partition_point(|&place| place <= common);
        let marks = parent.marks[..kept].to_vec();
        match marks.last() {
            Some(mark) => {
                state.copy_from(&mark.state);
                let score = mark.score;
                self.replay(genes.into(), marks, score, state)
            }
            None => self.first(&genes, state),
        }
    }

    /// Replays the genes after the last of the marks, keeping further ones.
    fn replay(
        &self,
        genes: Arc<[Gene]>,
        mut marks: Vec<Arc<Mark<S>>>,
        mut score: Score,
        state: &mut S,
    ) -> Individual<S> {
        let mut from = marks.len().checked_sub(1).map_or(0, |last| self.places[last]);
        let spared = from as u64;
        let mut replayed = 0;
        for &place in &self.places[marks.len()..] {
            replayed += self.stretch(&genes, from..place, &mut score, state);
            marks.push(Arc::new(Mark { score, state: state.clone() }));
            from = place;
        }
        replayed += self.stretch(&genes, from..genes.len(), &mut score, state);
        let Score { best: cost, best_at, .. } = score;
        Individual { genes, cost, best_at, marks, replayed, spared, is_new: true }
    }

    /// Replays some of the genes; gives the number of those that are not blank.
    fn stretch(
        &self,
        genes: &[Gene],
        range: std::ops::Range<usize>,
        score: &mut Score,
        state: &mut S,
    ) -> u64 {
        let mut replayed = 0;
        for (place, gene) in range.clone().zip(&genes[range]) {
            let Some(gene) = *gene else { continue };
            replayed += 1;
            if state.apply(gene) {
                score.present += self.cost.change(gene.switches(self.width));
                if score.present < score.best {
                    score.best = score.present;
                    score.best_at = place + 1;
                }
            }
        }
        replayed
    }

    /// The best path of an individual, and the moves that lead to it from the start.
    pub(super) fn walk(&self, mut path: Path, individual: &Individual<S>) -> (Path, Vec<Move>) {
        let genes = individual.genes[..individual.best_at].iter().flatten();
        let moves = genes.filter(|gene| gene.apply(&mut path)).copied().collect();
        debug_assert_eq!(self.cost.total(&path), individual.cost, "changes add up to the cost");
        (path, moves)
    }
}

/// How many states to keep of each replay, for so many individuals: as many as fit into 256 MB.
pub(super) fn marks(state: &impl State, population: usize) -> usize {
    /// The paper cuts at 60 %, so tenths are as good as exact.
    const MOST: usize = 9;
    const MEMORY: usize = 256 << 20;

    MOST.min(MEMORY / (state.bytes() * population).max(1))
}

fn common_beginning(one: &[Gene], other: &[Gene]) -> usize {
    one.iter().zip(other).position(|(a, b)| a != b).unwrap_or(one.len())
}
