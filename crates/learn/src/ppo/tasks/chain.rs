//! A chain of states with a small reward near by and a large one far away.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::ppo::environment::{Environment, EpisodeEnd, Observation, Space, Step};

/// A chain of states `0..length`, along which action 0 leads down and action 1 up.
///
/// Reaching state 0 ends the episode with a reward of 0.1, reaching the last state with 1; all
/// other rewards are 0. An episode starts at state 1 or 2, by its seed, and is truncated after
/// `4 * length` steps.
/// The optimal return is 1: always up.
///
/// Observation: 1 at the number of the state, 0 elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    length: usize,
    state: usize,
    steps: usize,
}

impl Chain {
    /// A chain of `length` states, at least 4.
    ///
    /// # Panics
    /// If it is shorter.
    pub fn new(length: usize) -> Self {
        assert!(length >= 4, "a chain of {length} states: expected at least 4");
        Self { length, state: 1, steps: 0 }
    }

    fn observation(&self) -> Observation {
        let at = |state| f32::from(u8::from(state == self.state));
        Observation::vector((0..self.length).map(at).collect(), 2)
    }
}

impl Environment for Chain {
    fn identity(&self) -> String {
        format!("task = \"chain\"\nlength = {}", self.length)
    }

    fn space(&self) -> Space {
        Space::vector(self.length as i64, 2)
    }

    fn reset(&mut self, seed: u64) -> Observation {
        self.state = ChaCha8Rng::seed_from_u64(seed).random_range(1..=2);
        self.steps = 0;
        self.observation()
    }

    fn step(&mut self, action: usize) -> Step {
        self.state = if action == 1 { self.state + 1 } else { self.state - 1 };
        self.steps += 1;
        let (reward, end) = if self.state == 0 {
            (0.1, Some(EpisodeEnd::Terminated))
        } else if self.state + 1 == self.length {
            (1.0, Some(EpisodeEnd::Terminated))
        } else {
            (0.0, (self.steps == 4 * self.length).then_some(EpisodeEnd::Truncated))
        };
        Step { observation: self.observation(), reward, end }
    }
}
