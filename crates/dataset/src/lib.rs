//! Trajectories of searches as checked, resumable files, and the factory that makes them.
//!
//! A dataset is a folder: **shards**, files of records in compressed **blocks** ([`ShardWriter`],
//! [`ShardReader`]), and a **manifest** that lists them and is written last ([`Manifest`]).
//! [`Dataset`] reads it, in order or shuffled for training.
//!
//! A [`Config`] says which searches to record, a [`Factory`] runs each of them from its number
//! alone, [`generate()`] fills a folder with their [`Trajectory`] records.
//! Every trajectory can be replayed and checked ([`Trajectory::replay`]).
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//!
//! use beadwork_dataset::{Config, Dataset, Factory, GenerateSettings, Slice, Trajectory, generate};
//!
//! let folder = tempfile::tempdir()?;
//! let config = Config { count: 4, ..Config::preset("smoke").unwrap() };
//! let factory = Factory::new(config, Vec::new())?;
//! let cancel = AtomicBool::new(false);
//! let settings = GenerateSettings { slice: Slice::WHOLE, threads: 1, cancel: &cancel, observer: &|_| {} };
//! generate(&factory, folder.path(), &settings)?;
//!
//! for trajectory in Dataset::open(folder.path())?.records::<Trajectory>() {
//!     let best = trajectory?.replay()?;
//!     assert_eq!(best.pieces(), 1);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! This crate reads and writes files and measures how long searches take; nothing it computes
//! depends on either.

mod by_name;
mod codec;
mod config;
mod factory;
mod file;
mod generate;
mod manifest;
mod shard;
mod source;
mod stream;
mod trajectory;

pub use codec::CodecError;
pub use config::{Config, ConfigError, LayoutConfig, Named, Size, SizeError, StartChoice};
pub use factory::{Factory, FactoryError};
pub use file::{FileError, write_whole, write_whole_at};
pub use generate::{
    GenerateError, GenerateProgress, GenerateSettings, Generated, Slice, SliceError, generate,
    search_times,
};
pub use manifest::{Manifest, ManifestError, ShardEntry};
pub use shard::{
    Block, PackError, Record, ShardError, ShardHeader, ShardReader, ShardSummary, ShardWriter,
};
pub use source::{ForeignPreset, PresetName, Search, Source, UnknownPresetName, UnknownSource};
pub use stream::{Dataset, DatasetError, Shuffled};
pub use trajectory::{DrawError, Instance, Moves, ReplayError, Step, Trajectory};
