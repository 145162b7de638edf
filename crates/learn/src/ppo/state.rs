//! The state of a run between two updates.

use std::collections::VecDeque;

use tch::Tensor;

use super::worker::Position;
use crate::checkpoint::RunState;

/// The state of a run between two updates, beside parameters and optimiser.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    /// Updates completed.
    pub(super) updates: u64,
    /// Episodes completed.
    pub(super) episodes: u64,
    /// Position of each environment.
    pub(super) positions: Vec<Position>,
    /// Returns of the last episodes, the newest last.
    pub(super) recent: VecDeque<f64>,
    /// Highest mean of a full window of returns so far; minus infinity before the first one.
    pub(super) best_mean: f64,
    /// Highest mean return of an evaluation so far; minus infinity before the first one.
    pub(super) best_evaluation: f64,
}

impl State {
    /// The state of a new run.
    pub(super) fn new(environments: usize) -> Self {
        Self {
            updates: 0,
            episodes: 0,
            positions: vec![Position::default(); environments],
            recent: VecDeque::new(),
            best_mean: f64::NEG_INFINITY,
            best_evaluation: f64::NEG_INFINITY,
        }
    }

    /// Adds an episode's return; only the last `window` of them stay.
    pub(super) fn add_return(&mut self, episode_return: f64, window: usize) {
        self.episodes += 1;
        self.recent.push_back(episode_return);
        while self.recent.len() > window {
            self.recent.pop_front();
        }
    }

    /// Mean return of the last episodes, if there is one.
    pub(super) fn mean_return(&self) -> Option<f64> {
        let sum: f64 = self.recent.iter().sum();
        (!self.recent.is_empty()).then(|| sum / self.recent.len() as f64)
    }
}

const COUNTS: &str = "ppo.counts";
const RETURNS: &str = "ppo.returns";
const POSITIONS: &str = "ppo.positions";

impl RunState for State {
    const NAMES: &'static [&'static str] = &[COUNTS, RETURNS, POSITIONS];

    fn to_tensors(&self, optimiser_steps: i64) -> Vec<Tensor> {
        let counts = [self.updates as i64, self.episodes as i64, optimiser_steps];
        let best = [self.best_mean, self.best_evaluation];
        let returns: Vec<f64> = best.into_iter().chain(self.recent.iter().copied()).collect();
        // For each environment: episode, number of actions, actions.
        let mut positions = Vec::new();
        for Position { episode, actions } in &self.positions {
            positions.extend([*episode as i64, actions.len() as i64]);
            positions.extend(actions.iter().map(|&action| i64::from(action)));
        }
        vec![
            Tensor::from_slice(&counts),
            Tensor::from_slice(&returns),
            Tensor::from_slice(&positions),
        ]
    }

    fn from_tensors(tensors: &[Tensor]) -> Result<(Self, i64), &'static str> {
        let [counts, returns, positions] = tensors else { return Err(COUNTS) };
        let counts =
            Vec::<i64>::try_from(counts).ok().and_then(|counts| <[i64; 3]>::try_from(counts).ok());
        let [updates, episodes, optimiser_steps] = counts.ok_or(COUNTS)?;
        let returns = Vec::<f64>::try_from(returns).map_err(|_| RETURNS)?;
        let &[best_mean, best_evaluation, ref recent @ ..] = returns.as_slice() else {
            return Err(RETURNS);
        };
        let flat = Vec::<i64>::try_from(positions).map_err(|_| POSITIONS)?;
        let mut rest = flat.as_slice();
        let mut positions = Vec::new();
        while let &[episode, count, ref after @ ..] = rest {
            let count = usize::try_from(count).map_err(|_| POSITIONS)?;
            let (actions, next) = after.split_at_checked(count).ok_or(POSITIONS)?;
            let actions = actions.iter().map(|&action| u32::try_from(action));
            let actions = actions.collect::<Result<_, _>>().map_err(|_| POSITIONS)?;
            positions.push(Position { episode: episode as u64, actions });
            rest = next;
        }
        if !rest.is_empty() {
            return Err(POSITIONS);
        }
        let state = Self {
            updates: updates as u64,
            episodes: episodes as u64,
            positions,
            recent: recent.iter().copied().collect(),
            best_mean,
            best_evaluation,
        };
        Ok((state, optimiser_steps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_survive_a_checkpoint() {
        let mut state = State::new(3);
        assert_eq!(State::from_tensors(&state.to_tensors(0)), Ok((state.clone(), 0)));
        for episode in 0..7 {
            state.add_return(f64::from(episode), 4);
        }
        state.updates = 5;
        state.best_mean = 1.25;
        state.positions[1] = Position { episode: 7, actions: vec![0, 37, 2] };
        state.positions[2] = Position { episode: 1, actions: vec![5] };
        assert_eq!((state.episodes, state.mean_return()), (7, Some(4.5)));
        assert_eq!(State::from_tensors(&state.to_tensors(9)), Ok((state.clone(), 9)));
        let mut tensors = state.to_tensors(9);
        tensors[2] = Tensor::from_slice(&[1_i64, 3, 0]);
        assert_eq!(State::from_tensors(&tensors), Err(POSITIONS));
    }
}
