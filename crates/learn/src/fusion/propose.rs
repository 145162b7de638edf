//! Moves that a network, or nothing but the costs, proposes for states of paths.

use std::collections::BTreeMap;

use beadwork_grid::{PlacedVariant, Symmetry};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tch::{Device, Tensor};

use super::layer::{Canvas, Inputs, State};
use super::{FusionNet, Precision, ask};

/// A move that applies, and what is thought of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// The move.
    pub placed: PlacedVariant,
    /// By how much it changes the crossings.
    pub change: i32,
    /// The more the better; only differences count.
    pub score: f32,
}

/// Proposes moves.
pub trait Proposer {
    /// For each state the moves to choose from, the best by score first.
    /// Each applies.
    ///
    /// # Panics
    /// If a layer has more columns or rows than a network has [`places`](super::Config::places).
    fn propose(&mut self, states: &[State<'_>]) -> Vec<Vec<Proposal>>;
}

/// All moves that apply, in random order: what a planner has without a network.
/// The order depends on the seed and on how many moves were made before.
#[derive(Debug)]
pub struct AllMoves {
    /// Seed of the order.
    pub seed: u64,
}

impl Proposer for AllMoves {
    fn propose(&mut self, states: &[State<'_>]) -> Vec<Vec<Proposal>> {
        let all = |state: &State<'_>| {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(state.made.len() as u64);
            let mut proposals = Vec::new();
            state.links.for_each_variant(|placed| {
                let change = state.layer.change(placed);
                proposals.push(Proposal { placed, change, score: rng.random() });
            });
            sort(&mut proposals);
            proposals
        };
        states.iter().map(all).collect()
    }
}

/// A network with what it needs to be asked.
#[derive(Debug)]
pub struct Asked<'a> {
    /// The network.
    pub network: &'a FusionNet,
    /// Where its parameters are.
    pub device: Device,
    /// What it computes in.
    pub precision: Precision,
    /// Places, of those where a move applies, whose moves are proposed: the ones that it scores
    /// most.
    /// At least 1.
    pub places: usize,
    /// Most cells of all canvases that are looked at together, which bounds the memory.
    pub cells: usize,
}

impl<'a> Asked<'a> {
    /// On a device, with 32 places, and some hundred MB for features.
    pub fn new(network: &'a FusionNet, device: Device) -> Self {
        Self { network, device, precision: Precision::Single, places: 32, cells: 64 * 32 * 32 }
    }

    /// Proposes for states on one canvas.
    fn ask_together(&self, states: &[&State<'_>], canvas: Canvas) -> Vec<Vec<Proposal>> {
        let places = self.network.config().places as u32;
        assert!(
            states.iter().all(|state| state.layer.size().0.max(state.layer.size().1) <= places),
            "the network knows {places} places along each axis"
        );
        let mut inputs = Inputs::new(canvas, self.network.config().history as usize);
        states.iter().for_each(|state| inputs.push(state, Symmetry::ALL[0]));
        let (image, history) = inputs.tensors(self.device);
        let proposals = ask(self.network, &image, &history, self.precision);
        let (position, action) = (numbers(&proposals.position), numbers(&proposals.action));
        let cells = canvas.cells();
        let of_state = |(at, state): (usize, &&State<'_>)| {
            let scores = &position[at * cells..][..cells];
            let logits = &action[12 * at * cells..][..12 * cells];
            self.choose(state, canvas, scores, logits)
        };
        states.iter().enumerate().map(of_state).collect()
    }

    /// The moves at the places that score most, each by its place's score and its own share of what
    /// applies there.
    fn choose(
        &self,
        state: &State<'_>,
        canvas: Canvas,
        scores: &[f32],
        logits: &[f32],
    ) -> Vec<Proposal> {
        let mut places: Vec<(usize, Vec<PlacedVariant>)> = Vec::new();
        state.links.for_each_variant(|placed| {
            let cell = usize::from(placed.y) * canvas.width as usize + usize::from(placed.x);
            match places.last_mut() {
                Some((last, moves)) if *last == cell => moves.push(placed),
                _ => places.push((cell, vec![placed])),
            }
        });
        places.sort_by(|(a, _), (b, _)| scores[*b].total_cmp(&scores[*a]));
        places.truncate(self.places.max(1));
        let mut proposals = Vec::new();
        for (cell, moves) in places {
            let logit = |placed: &PlacedVariant| {
                logits[usize::from(placed.variant.class()) * scores.len() + cell]
            };
            let most = moves.iter().map(logit).fold(f32::NEG_INFINITY, f32::max);
            let sum: f32 = moves.iter().map(|placed| (logit(placed) - most).exp()).sum();
            proposals.extend(moves.iter().map(|&placed| Proposal {
                placed,
                change: state.layer.change(placed),
                score: scores[cell] + logit(&placed) - most - sum.ln(),
            }));
        }
        sort(&mut proposals);
        proposals
    }
}

impl Proposer for Asked<'_> {
    fn propose(&mut self, states: &[State<'_>]) -> Vec<Vec<Proposal>> {
        let mut by_canvas: BTreeMap<Canvas, Vec<usize>> = BTreeMap::new();
        for (at, state) in states.iter().enumerate() {
            by_canvas.entry(Canvas::holding(state.layer.size())).or_default().push(at);
        }
        let mut proposals = vec![Vec::new(); states.len()];
        for (canvas, members) in by_canvas {
            for together in members.chunks((self.cells / canvas.cells()).max(1)) {
                let asked: Vec<_> = together.iter().map(|&at| &states[at]).collect();
                for (&at, proposed) in together.iter().zip(self.ask_together(&asked, canvas)) {
                    proposals[at] = proposed;
                }
            }
        }
        proposals
    }
}

fn sort(proposals: &mut [Proposal]) {
    proposals.sort_by(|a, b| b.score.total_cmp(&a.score));
}

/// All numbers of a tensor, in the order of its axes.
fn numbers(tensor: &Tensor) -> Vec<f32> {
    Vec::try_from(tensor.contiguous().view([-1])).expect("single precision, one axis")
}
