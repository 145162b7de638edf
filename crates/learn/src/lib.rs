//! Neural networks that learn from recorded searches, and from acting.
//!
//! [`fusion`] is FusionNet, the network of Aali et al. ("Sequence-Based Evolutionary and Neural
//! Strategies for Reducing Zone Crossings in Toolpaths"), which proposes the next move of a search
//! from an image of the layer.
//! It covers the way from a dataset to better paths: batches of examples ([`fusion::samples`]),
//! training ([`fusion::train`]), trained models ([`fusion::model`]), proposals
//! ([`fusion::propose`]) and walks that follow them ([`fusion::walk`]).
//!
//! [`ppo`] is proximal policy optimisation, which trains a policy by acting in environments.
//! [`ppo::HeatPolicy`] opens `models/ppo-small`, which chooses the order of each layer of a part
//! for even temperatures.
//!
//! [`weights`] reads and writes parameters under their PyTorch names, [`checkpoint`] whole runs,
//! and [`adamw`] is the optimiser.
//!
//! # Terms
//! A **state** is a layer, a path through all of its cells, and the moves that led to that path.
//! An **example** is a state of a recorded search with the move that was applied next.
//! **Negatives** are the positions above which the recorded position should score.
//! A **proposal** is a move with a score.
//! A **walk** applies proposals until its path has few enough crossings.
//!
//! A **policy** gives each action of an **environment** a probability; an **episode** is a sequence
//! of its actions, and the **return** the sum of an episode's rewards.
//!
//! # Improve a path
//! ```no_run
//! use std::path::Path;
//!
//! use beadwork_base::Control;
//! use beadwork_grid::{Layout, LayoutSpec, Region, Start};
//! use beadwork_learn::Device;
//! use beadwork_learn::fusion::layer::Layer;
//! use beadwork_learn::fusion::model::Model;
//! use beadwork_learn::fusion::propose::NetworkProposer;
//! use beadwork_learn::fusion::walk::{self, Task};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Islands).zones(&region, 0)?;
//! let layer = Layer::new(&region, &zones);
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let model = Model::open(Path::new("models/fusion-small"), Device::Cpu)?;
//! let mut proposer = NetworkProposer::new(&model.network, Device::Cpu);
//! let task = Task { layer: &layer, start: &start, target: 30, seed: 0 };
//! let settings = walk::Settings::default();
//! let outcomes = walk::solve(&[task], &mut proposer, &settings, &Control::default());
//! assert!(outcomes[0].crossings <= outcomes[0].initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Read a batch as arrays
//! ```no_run
//! use std::path::Path;
//!
//! use beadwork_dataset::Dataset;
//! use beadwork_learn::fusion::samples::{Batches, Settings, Split};
//!
//! let dataset = Dataset::open(Path::new("datasets/chains"))?;
//! let settings = Settings::default();
//! for batch in Batches::new(&dataset, Split::Train, &settings, 0) {
//!     let batch = batch?;
//!     let image = batch.inputs.image(); // [example, y, x, channel]
//!     assert_eq!(image.shape()[0], batch.position.len());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Train a network
//! ```no_run
//! use std::path::Path;
//!
//! use beadwork_base::Control;
//! use beadwork_dataset::Dataset;
//! use beadwork_learn::Device;
//! use beadwork_learn::fusion::TrainingConfig;
//! use beadwork_learn::fusion::train::{Run, train};
//!
//! let dataset = Dataset::open(Path::new("datasets/chains"))?;
//! let config = TrainingConfig { steps: 1000, ..TrainingConfig::default() };
//! let mut observer = |event: &_| println!("{event:?}");
//! let run = Run { device: Device::Cpu, out: Path::new("runs/fusion"), observer: &mut observer };
//! train(&dataset, &config, run, &Control::default())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Train a policy
//! ```no_run
//! use std::path::Path;
//!
//! use beadwork_base::{Control, Threads};
//! use beadwork_learn::Device;
//! use beadwork_learn::ppo::tasks::CartPole;
//! use beadwork_learn::ppo::{Run, TrainingConfig, train};
//!
//! let mut observer = |event: &_| println!("{event:?}");
//! let run = Run { device: Device::Cpu, out: Path::new("runs/pole"), observer: &mut observer };
//! let config = TrainingConfig::cart_pole();
//! train(&CartPole::default, &config, run, &Control::on(Threads::Current))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//! - `oracle`: `fusion::parity`, which compares the network with another implementation.
//!
//! # Limits
//! The crate reads and writes weights, checkpoints and configurations, and prints nothing.
//!
//! Everything runs on libtorch through the crate `tch`; `cargo xtask setup` provides it.
//! No other crate of the workspace depends on it directly.
//! Networks compute on libtorch's own threads, not on those of a
//! [`Control`](beadwork_base::Control); [`fusion::TrainingConfig::threads`] and
//! [`ppo::TrainingConfig::threads`] set their number.
//! The same number of threads on the same processor gives the same bytes; another processor may
//! round differently.

pub mod adamw;
pub mod checkpoint;
pub mod fusion;
pub mod ppo;
pub mod weights;

pub use tch::{Cuda, Device};
