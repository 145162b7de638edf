//! Random numbers of a run, each a function of the run's seed, a purpose and a number.
//!
//! No generator has a state that outlives its use, so none is stored in checkpoints, and no random
//! number depends on the order in which threads draw.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What a random number decides.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    /// The initial weights.
    Weights,
    /// The seeds of the episodes of an environment.
    Episodes,
    /// The actions in an environment.
    Actions,
    /// The order of the steps in an epoch.
    Shuffle,
    /// The seeds of the episodes of an evaluation.
    Evaluation,
    /// The steps of an environment before the run.
    Stagger,
}

/// The generator of a purpose; `number` tells apart generators of one purpose.
pub(super) fn generator(seed: u64, purpose: Purpose, number: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream((purpose as u64) << 56 | number);
    generator
}

/// The seed of an episode of an environment.
pub(super) fn episode_seed(seed: u64, environment: usize, episode: u64) -> u64 {
    let mut generator = generator(seed, Purpose::Episodes, environment as u64);
    generator.set_word_pos(2 * u128::from(episode));
    generator.next_u64()
}

/// The number, 0..1, by which an environment's action at one of its steps is drawn.
pub(super) fn action_draw(seed: u64, environment: usize, step: u64) -> f64 {
    let mut generator = generator(seed, Purpose::Actions, environment as u64);
    generator.set_word_pos(2 * u128::from(step));
    generator.random()
}
