//! An environment with its episode's record.

use rand::RngExt;

use super::environment::{Environment, EpisodeEnd, Observation, Space, Step};
use super::random::{Purpose, episode_seed, generator};

/// Where an environment is in its sequence of episodes.
///
/// An episode is determined by its seed and its actions, so the actions since its start stand for
/// the environment's state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Position {
    /// Number of the episode, from 0.
    pub(super) episode: u64,
    /// Actions since its start.
    pub(super) actions: Vec<u32>,
}

/// An environment of a run.
///
/// When an episode ends, the next one starts, so that there is always an observation to act on.
pub(super) struct Worker<E> {
    environment: E,
    /// Number of the environment, by which its seeds differ from those of the others.
    number: usize,
    /// Seed of the run.
    seed: u64,
    space: Space,
    position: Position,
    observation: Observation,
    /// Sum of the rewards of the episode so far.
    episode_return: f64,
}

/// A finished episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Finished {
    /// The episode's score.
    pub(super) episode_return: f64,
    pub(super) length: u64,
}

/// What a step did.
pub(super) struct Outcome {
    pub(super) reward: f64,
    pub(super) end: Option<EpisodeEnd>,
    /// The episode's last observation, if it was truncated.
    pub(super) truncated_at: Option<Observation>,
    pub(super) finished: Option<Finished>,
}

impl<E: Environment> Worker<E> {
    /// Starts at a position of a run, by replaying the actions of its episode.
    pub(super) fn new(environment: E, number: usize, seed: u64, position: &Position) -> Self {
        let mut worker = Self {
            space: environment.space(),
            environment,
            number,
            seed,
            position: Position { episode: position.episode, actions: Vec::new() },
            observation: Observation::default(),
            episode_return: 0.0,
        };
        worker.reset();
        for &action in &position.actions {
            worker.step(action as usize);
        }
        worker
    }

    /// Makes a random number of random permitted steps, up to `steps`.
    pub(super) fn stagger(&mut self, steps: u32) {
        let mut generator = generator(self.seed, Purpose::Stagger, self.number as u64);
        for _ in 0..generator.random_range(0..=steps) {
            let permitted = self.observation.permitted.iter();
            let permitted: Vec<usize> =
                permitted.enumerate().filter_map(|(action, &is)| is.then_some(action)).collect();
            self.step(permitted[generator.random_range(0..permitted.len())]);
        }
    }

    pub(super) fn position(&self) -> &Position {
        &self.position
    }

    /// What to act on next.
    pub(super) fn observation(&self) -> &Observation {
        &self.observation
    }

    pub(super) fn step(&mut self, action: usize) -> Outcome {
        let Step { observation, reward, end } = self.environment.step(action);
        assert!(
            self.space.has_shapes_of(&observation),
            "an observation does not have the form of its environment's space"
        );
        self.position.actions.push(action as u32);
        self.episode_return += reward;
        let Some(ended) = end else {
            self.observe(observation);
            return Outcome { reward, end, truncated_at: None, finished: None };
        };
        let length = self.position.actions.len() as u64;
        let episode_return = self.environment.score(self.episode_return);
        let finished = Some(Finished { episode_return, length });
        self.position = Position { episode: self.position.episode + 1, actions: Vec::new() };
        self.reset();
        let truncated_at = (ended == EpisodeEnd::Truncated).then_some(observation);
        Outcome { reward, end, truncated_at, finished }
    }

    /// Starts the episode of the current position.
    fn reset(&mut self) {
        let seed = episode_seed(self.seed, self.number, self.position.episode);
        self.episode_return = 0.0;
        let observation = self.environment.reset(seed);
        self.observe(observation);
    }

    fn observe(&mut self, observation: Observation) {
        assert!(
            self.space.fits(&observation),
            "an observation does not have the form of its environment's space, or permits no action"
        );
        self.observation = observation;
    }
}
