//! Proposals of moves for states of paths, by a network or without one.

use std::collections::BTreeMap;

use beadwork_grid::{PlacedVariant, Symmetry};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tch::{Device, Tensor};

use super::config::{ACTIONS, Precision};
use super::inputs::{Canvas, Inputs};
use super::layer::State;
use super::network::FusionNet;

/// A move that applies, with its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// The move.
    pub placed: PlacedVariant,
    /// Change of the number of crossings, negative if it saves crossings.
    pub change: i32,
    /// Higher is better; only differences between proposals for one state have a meaning.
    pub score: f32,
}

/// A source of proposals.
pub trait Proposer {
    /// Returns proposals for each state, in descending order of score.
    /// All proposed moves apply.
    ///
    /// # Panics
    /// If a layer is larger than the proposer can handle; see
    /// [`Config::max_side`](super::Config::max_side).
    fn propose(&mut self, states: &[State<'_>]) -> Vec<Vec<Proposal>>;
}

/// Proposes all moves that apply, with random scores: the baseline without a network.
///
/// The scores of a state depend on the seed and on the number of moves that led to it.
#[derive(Debug)]
pub struct AllMoves {
    /// Seed of the scores.
    pub seed: u64,
}

impl Proposer for AllMoves {
    fn propose(&mut self, states: &[State<'_>]) -> Vec<Vec<Proposal>> {
        let propose = |state: &State<'_>| {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(state.moves.len() as u64);
            let mut proposals = Vec::new();
            state.links.for_each_variant(|placed| {
                let change = state.layer.change(placed);
                proposals.push(Proposal { placed, change, score: rng.random() });
            });
            sort_by_score(&mut proposals);
            proposals
        };
        states.iter().map(propose).collect()
    }
}

/// Proposes the moves that a network scores highest.
#[derive(Debug)]
pub struct NetworkProposer<'a> {
    /// The network.
    pub network: &'a FusionNet,
    /// The device of its parameters.
    pub device: Device,
    /// Precision of convolutions.
    pub precision: Precision,
    /// Number of positions whose moves are proposed, at least 1: of all positions where a move
    /// applies, those with the highest scores.
    pub positions: usize,
    /// Maximum number of cells of all images in one forward pass, which bounds the memory.
    pub max_cells: usize,
}

impl<'a> NetworkProposer<'a> {
    /// A proposer in single precision with 32 positions.
    /// A forward pass takes some hundred megabytes of memory.
    pub fn new(network: &'a FusionNet, device: Device) -> Self {
        let max_cells = 64 * 32 * 32;
        Self { network, device, precision: Precision::Single, positions: 32, max_cells }
    }

    /// Proposes moves for states on one canvas, in one forward pass.
    fn propose_batch(&self, states: &[&State<'_>], canvas: Canvas) -> Vec<Vec<Proposal>> {
        let max_side = self.network.config().max_side as u32;
        assert!(
            states.iter().all(|state| state.layer.size().0.max(state.layer.size().1) <= max_side),
            "a layer is larger than {max_side} x {max_side} cells, the network's limit"
        );
        let mut inputs = Inputs::new(canvas, self.network.config().history as usize);
        states.iter().for_each(|state| inputs.push(state, Symmetry::ALL[0]));
        let (image, history) = inputs.tensors(self.device);
        let proposals = self.network.infer(&image, &history, self.precision);
        let (position, action) = (to_vec(&proposals.position), to_vec(&proposals.action));
        let scores = position.chunks_exact(canvas.cells());
        let logits = action.chunks_exact(ACTIONS as usize * canvas.cells());
        let outputs = scores.zip(logits);
        let choose = |(state, (scores, logits)): (&&State<'_>, _)| {
            self.choose(state, canvas, scores, logits)
        };
        states.iter().zip(outputs).map(choose).collect()
    }

    /// The moves at the positions with the highest scores.
    ///
    /// A move's score is its position's score plus its log probability: a softmax over the logits
    /// of only those variants that apply there.
    fn choose(
        &self,
        state: &State<'_>,
        canvas: Canvas,
        scores: &[f32],
        logits: &[f32],
    ) -> Vec<Proposal> {
        let mut positions: Vec<(usize, Vec<PlacedVariant>)> = Vec::new();
        state.links.for_each_variant(|placed| {
            let cell = usize::from(placed.y) * canvas.width as usize + usize::from(placed.x);
            match positions.last_mut() {
                Some((last, moves)) if *last == cell => moves.push(placed),
                _ => positions.push((cell, vec![placed])),
            }
        });
        positions.sort_by(|(a, _), (b, _)| scores[*b].total_cmp(&scores[*a]));
        positions.truncate(self.positions.max(1));
        let mut proposals = Vec::new();
        for (cell, moves) in positions {
            let logit = |placed: &PlacedVariant| {
                logits[usize::from(placed.variant.class()) * scores.len() + cell]
            };
            // The maximum is subtracted before exponentiation, so that no term overflows.
            let max = moves.iter().map(logit).fold(f32::NEG_INFINITY, f32::max);
            let sum: f32 = moves.iter().map(|placed| (logit(placed) - max).exp()).sum();
            proposals.extend(moves.iter().map(|&placed| Proposal {
                placed,
                change: state.layer.change(placed),
                score: scores[cell] + logit(&placed) - max - sum.ln(),
            }));
        }
        sort_by_score(&mut proposals);
        proposals
    }
}

impl Proposer for NetworkProposer<'_> {
    fn propose(&mut self, states: &[State<'_>]) -> Vec<Vec<Proposal>> {
        let mut by_canvas: BTreeMap<Canvas, Vec<usize>> = BTreeMap::new();
        for (index, state) in states.iter().enumerate() {
            by_canvas.entry(Canvas::holding(state.layer.size())).or_default().push(index);
        }
        let mut proposals = vec![Vec::new(); states.len()];
        for (canvas, indices) in by_canvas {
            for indices in indices.chunks((self.max_cells / canvas.cells()).max(1)) {
                let batch: Vec<_> = indices.iter().map(|&index| &states[index]).collect();
                for (&index, proposed) in indices.iter().zip(self.propose_batch(&batch, canvas)) {
                    proposals[index] = proposed;
                }
            }
        }
        proposals
    }
}

/// Sorts by descending score; proposals with equal scores keep their order.
fn sort_by_score(proposals: &mut [Proposal]) {
    proposals.sort_by(|a, b| b.score.total_cmp(&a.score));
}

/// All elements of a tensor in the order of its axes.
fn to_vec(tensor: &Tensor) -> Vec<f32> {
    Vec::try_from(tensor.contiguous().view([-1])).expect("single precision, one axis")
}
