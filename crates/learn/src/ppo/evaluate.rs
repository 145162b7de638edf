//! Evaluation of a policy: episodes in which the most likely actions are chosen.

use beadwork_base::{Control, Interrupted};
use rand::Rng;
use tch::{Device, no_grad};

use super::categorical::{Categorical, likeliest};
use super::environment::{Environment, Observation, Step};
use super::network::{ActorCritic, batch, permitted};
use super::random::{Purpose, generator};

/// The episodes of an evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Return of each episode, as its environment [scores](Environment::score) it.
    pub returns: Vec<f64>,
    /// Actions of each episode.
    pub actions: Vec<Vec<usize>>,
}

impl Evaluation {
    /// Mean return.
    pub fn mean(&self) -> f64 {
        self.returns.iter().sum::<f64>() / self.returns.len() as f64
    }

    /// The seeds of a run's evaluations, the same for all evaluations of the run.
    pub fn seeds(seed: u64, count: usize) -> Vec<u64> {
        let mut generator = generator(seed, Purpose::Evaluation, 0);
        (0..count).map(|_| generator.next_u64()).collect()
    }
}

/// One episode for each seed, in which the most likely permitted action is chosen.
///
/// Every episode has its own environment, from `make`; they are stepped together on the threads of
/// `control`.
/// Returns an error if `control` interrupts the call, and never if an episode does not end.
///
/// # Panics
/// If the network's output is not finite.
pub fn evaluate<E: Environment>(
    make: &dyn Fn() -> E,
    network: &dyn ActorCritic,
    seeds: &[u64],
    device: Device,
    control: &Control<'_>,
) -> Result<Evaluation, Interrupted> {
    struct Episode<E> {
        number: usize,
        environment: E,
        observation: Observation,
        ended: bool,
    }
    let mut evaluation =
        Evaluation { returns: vec![0.0; seeds.len()], actions: vec![Vec::new(); seeds.len()] };
    let start = |(number, &seed): (usize, &u64)| {
        let mut environment = make();
        let observation = environment.reset(seed);
        Episode { number, environment, observation, ended: false }
    };
    let mut episodes: Vec<Episode<E>> = seeds.iter().enumerate().map(start).collect();
    while !episodes.is_empty() {
        control.check()?;
        let space = episodes[0].environment.space();
        let seen: Vec<&Observation> = episodes.iter().map(|episode| &episode.observation).collect();
        let output = no_grad(|| network.forward(&batch(&seen, &space, device)));
        let policy = Categorical::new(&output.logits, &permitted(&seen, device));
        let probabilities: Vec<f32> = Vec::try_from(policy.probabilities().contiguous().view([-1]))
            .expect("single precision, one axis");
        let actions: Vec<usize> =
            probabilities.chunks_exact(space.actions).map(likeliest).collect();
        let step = |index: usize, episode: &mut Episode<E>| {
            let Step { observation, reward, end } = episode.environment.step(actions[index]);
            episode.observation = observation;
            episode.ended = end.is_some();
            reward
        };
        let rewards = control.threads.map_mut(&mut episodes, step);
        for ((episode, reward), action) in episodes.iter().zip(rewards).zip(actions) {
            evaluation.returns[episode.number] += reward;
            evaluation.actions[episode.number].push(action);
            if episode.ended {
                let score = &mut evaluation.returns[episode.number];
                *score = episode.environment.score(*score);
            }
        }
        episodes.retain(|episode| !episode.ended);
    }
    Ok(evaluation)
}
