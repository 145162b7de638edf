//! Small tasks with known results, by which training is checked.

mod bandit;
mod cart_pole;
mod chain;

pub use self::bandit::Bandit;
pub use self::cart_pole::CartPole;
pub use self::chain::Chain;
