//! Datasets of recorded searches: checked files that can be continued after an interruption, and
//! the factory that makes them; and random parts.
//!
//! # Terms
//! A **trajectory** is the record of one search: its instance, its start path, and every move that
//! led to the best path.
//! An **instance** is a layer with zones, drawn from a layout or read from a picture.
//! A **stratum** is a combination of instance, preset and start; a dataset has equal shares of all
//! strata.
//! A **shard** is a file of records in compressed **blocks**.
//! A **manifest** lists the shards; it is written last, so a folder without one is unfinished.
//!
//! # Overview
//! - [`Config`] describes a dataset; a [`Factory`] makes each of its trajectories from its number
//!   alone; [`generate()`] fills a folder with them, in parallel.
//! - [`Dataset`] reads a folder: in order, or shuffled for training.
//! - [`Trajectory`] can be replayed and checked ([`Trajectory::replay`]), and converted to
//!   `ndarray` arrays ([`Trajectory::arrays`]).
//! - [`random_part()`] generates parts to train thermal models and policies on
//!   ([`random_part`](mod@random_part)).
//! - [`ShardWriter`] and [`ShardReader`] store records of any type; [`write_atomic`] writes files
//!   that are complete or absent.
//!
//! # Make a dataset and read it
//! ```
//! use beadwork_base::{Control, Threads};
//! use beadwork_dataset::{Config, Dataset, Factory, Trajectory, generate};
//!
//! let folder = tempfile::tempdir()?;
//! let config = Config { count: 4, ..Config::preset("smoke").unwrap() };
//! let control = Control::on(Threads::Current);
//! let factory = Factory::new(config, Vec::new(), &control)?;
//! generate(&factory, folder.path(), &generate::Settings::default(), &control)?;
//!
//! for trajectory in Dataset::open(folder.path())?.records::<Trajectory>() {
//!     let best = trajectory?.replay(&Control::default())?;
//!     assert_eq!(best.pieces(), 1);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! This crate reads and writes files, measures how long searches take, and starts one thread that
//! writes shards; no result depends on these.
//! It has no features.

mod by_name;
mod codec;
mod config;
mod factory;
mod file;
pub mod generate;
mod manifest;
pub mod random_part;
mod shard;
mod size;
mod source;
mod start_choice;
mod stratum;
mod stream;
mod trajectory;

pub use codec::CodecError;
pub use config::{Config, ConfigError, LayoutConfig, Named};
pub use factory::Factory;
pub use file::{FileError, write_atomic, write_atomic_at};
pub use generate::{GenerateError, ShardRange, ShardRangeError, generate, search_times};
pub use manifest::{Manifest, ManifestError, ShardEntry};
pub use random_part::random_part;
pub use shard::{
    Block, PackError, Record, ShardError, ShardHeader, ShardReader, ShardSummary, ShardWriter,
};
pub use size::{Size, SizeError};
pub use source::{PresetName, Search, Source};
pub use start_choice::StartChoice;
pub use stratum::FactoryError;
pub use stream::{Dataset, DatasetError, Shuffled};
pub use trajectory::{DrawError, Instance, Moves, ReplayError, Step, Trajectory, TrajectoryArrays};
