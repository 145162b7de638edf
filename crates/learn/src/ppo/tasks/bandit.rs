//! One step, one reward: which action is best.

use crate::ppo::environment::{Environment, EpisodeEnd, Observation, Space, Step};

/// Episodes of one step; the reward depends on the action alone.
/// The optimal return is the highest reward of a permitted action.
#[derive(Clone, Debug, PartialEq)]
pub struct Bandit {
    /// Reward of each action; `None` if it is not permitted.
    pub rewards: Vec<Option<f64>>,
}

impl Bandit {
    /// A bandit that permits all actions.
    pub fn new(rewards: &[f64]) -> Self {
        Self { rewards: rewards.iter().copied().map(Some).collect() }
    }

    fn observation(&self) -> Observation {
        Observation {
            tensors: vec![vec![1.0]],
            permitted: self.rewards.iter().map(Option::is_some).collect(),
        }
    }
}

impl Environment for Bandit {
    fn identity(&self) -> String {
        format!("task = \"bandit\"\nrewards = \"{:?}\"", self.rewards)
    }

    fn space(&self) -> Space {
        Space::vector(1, self.rewards.len())
    }

    fn reset(&mut self, _: u64) -> Observation {
        self.observation()
    }

    /// # Panics
    /// If the action is not permitted.
    fn step(&mut self, action: usize) -> Step {
        let reward = self.rewards[action].expect("the action is permitted");
        Step { observation: self.observation(), reward, end: Some(EpisodeEnd::Terminated) }
    }
}
