//! Proximal policy optimisation (PPO): trains a policy by acting in environments.
//!
//! Schulman et al. 2017; the settings follow the paper on toolpaths for even temperature (Kim et
//! al. 2026) and a public reference implementation, as each field of [`TrainingConfig`] says.
//!
//! - [`Environment`]: what an agent acts in, with discrete actions that can be masked; observations
//!   are one or more tensors, described by a [`Space`];
//! - [`train()`] and its [`TrainingConfig`]: the algorithm, in one file;
//! - [`Policy`]: a trained policy in a folder; [`evaluate()`]: its returns;
//! - [`ActorCritic`] and [`NetworkConfig`]: the networks, of which [`FieldsConfig`] describes the
//!   paper's;
//! - [`HeatTask`] and [`HeatEnvironment`]: the paper's task, in which a step prints a layer;
//! - [`RandomHeatTask`] and [`RandomHeatEnvironment`]: the same with another random part in every
//!   episode, so that a policy learns to act on any part;
//! - [`HeatPolicy`]: plans of such a policy, within a limit on the printing time;
//! - [`tasks`]: small tasks with known results.
//!
//! # Example
//! ```
//! use beadwork_base::Control;
//! use beadwork_learn::Device;
//! use beadwork_learn::ppo::tasks::Bandit;
//! use beadwork_learn::ppo::{self, Environment, Kept, Policy, TrainingConfig};
//!
//! let out = tempfile::tempdir()?;
//! let config = TrainingConfig {
//!     steps: 512,
//!     rollout: 8,
//!     learning_rate: 1e-2,
//!     threads: 1,
//!     ..TrainingConfig::default()
//! };
//! let make = || Bandit::new(&[0.1, 0.9, 0.5]);
//! let mut observer = |_: &_| {};
//! let run = ppo::Run { device: Device::Cpu, out: out.path(), observer: &mut observer };
//! ppo::train(&make, &config, run, &Control::default())?;
//!
//! let policy = Policy::open(out.path(), Kept::Evaluation, Device::Cpu)?;
//! assert_eq!(policy.act(&make().reset(0)), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guarantees
//! The same seed gives the same bytes for any number of threads of a
//! [`Control`](beadwork_base::Control), and for a run that was interrupted and resumed.
//! Random numbers come from portable generators, not from libtorch's.

mod categorical;
mod environment;
mod evaluate;
mod fields;
mod heat;
mod init;
mod network;
mod perceptron;
mod policy;
mod random;
mod range;
mod state;
pub mod tasks;
mod train;
mod training_config;
mod worker;

pub use self::categorical::Categorical;
pub use self::environment::{Environment, EpisodeEnd, Observation, Space, Step};
pub use self::evaluate::{Evaluation, evaluate};
pub use self::fields::FieldsConfig;
pub use self::heat::{
    HeatEnvironment, HeatError, HeatPolicy, HeatPolicyError, HeatSettings, HeatTask, PolicyTask,
    RandomHeatEnvironment, RandomHeatError, RandomHeatTask, TimePrice,
};
pub use self::network::{ActorCritic, NetworkConfig, Output, SpaceError};
pub use self::perceptron::PerceptronConfig;
pub use self::policy::{Kept, Policy, PolicyError};
pub use self::range::RangeError;
pub use self::train::{
    Batch, End, Event, Losses, Run, TrainError, Update, advantages, last_checkpoint, losses, train,
};
pub use self::training_config::{TrainingConfig, TrainingConfigError};
