//! What an agent acts in.

use serde::{Deserialize, Serialize};

/// The form of an environment's observations and actions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Space {
    /// Shape of each tensor of an observation: `[values]`, `[action, values]`, `[channel, y, x]` or
    /// `[channel, z, y, x]`.
    pub observation: Vec<Vec<i64>>,
    /// Number of actions, at least 1.
    pub actions: usize,
}

impl Space {
    /// The space of environments that observe a vector of `values` numbers.
    pub fn vector(values: i64, actions: usize) -> Self {
        Self { observation: vec![vec![values]], actions }
    }

    /// Reads the content of a policy's `space.toml`.
    pub(super) fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// The content of a policy's `space.toml`.
    pub(super) fn to_toml(&self) -> String {
        toml::to_string(self).expect("a space is plain data")
    }

    /// Whether an observation has the form of this space and permits an action.
    pub fn fits(&self, observation: &Observation) -> bool {
        self.has_shapes_of(observation)
            && observation.permitted.len() == self.actions
            && observation.permitted.contains(&true)
    }

    /// Whether the tensors of an observation have the shapes of this space.
    pub(super) fn has_shapes_of(&self, observation: &Observation) -> bool {
        let sizes = self.observation.iter().map(|shape| shape.iter().product::<i64>() as usize);
        sizes.eq(observation.tensors.iter().map(Vec::len))
    }
}

/// What an agent sees before it acts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// The numbers of each tensor, in the order and the shapes of [`Space::observation`], the last
    /// axis fastest.
    /// Networks learn best from numbers of about -1 to 1.
    pub tensors: Vec<Vec<f32>>,
    /// Whether each action may be chosen; at least one may.
    pub permitted: Vec<bool>,
}

impl Observation {
    /// A vector after which all of `actions` actions are permitted.
    pub fn vector(values: Vec<f32>, actions: usize) -> Self {
        Self { tensors: vec![values], permitted: vec![true; actions] }
    }
}

/// How an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EpisodeEnd {
    /// A final state was reached: the return from here on is 0.
    Terminated,
    /// A limit on the steps was reached, which the agent does not see: the return from here on is
    /// what the critic expects of the last observation.
    Truncated,
}

/// The consequence of an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The observation after the action, the episode's last one if it ended.
    pub observation: Observation,
    /// The reward.
    pub reward: f64,
    /// How the episode ended; `None` if it continues.
    pub end: Option<EpisodeEnd>,
}

/// What an agent acts in, one episode after the other.
///
/// An episode must depend on its seed and its actions alone: a resumed run replays the actions of
/// unfinished episodes instead of storing environments.
pub trait Environment: Send {
    /// Text that differs between environments with different episodes, one or more lines
    /// `key = value`.
    /// A run can only be resumed in an environment with the same identity.
    fn identity(&self) -> String;

    /// Form of the observations and actions, the same for each episode.
    fn space(&self) -> Space;

    /// Starts the episode with this seed, and returns its first observation.
    fn reset(&mut self, seed: u64) -> Observation;

    /// Acts.
    ///
    /// # Panics
    /// Implementations may panic if the action is not permitted, or if the episode has ended.
    fn step(&mut self, action: usize) -> Step;

    /// What the episode that just ended counts for in logs, evaluations and the choice of the best
    /// policy, where the sum of its rewards was `rewards`.
    ///
    /// The sum itself, unless rewards are shaped: they then differ from what is wanted, so that it
    /// is learned more easily.
    fn score(&self, rewards: f64) -> f64 {
        rewards
    }
}
