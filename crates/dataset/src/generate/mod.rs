//! Makes a dataset in a folder, shard by shard, so that an interrupted run can be continued.
//!
//! Every shard is written atomically and depends on the configuration and its number alone; the
//! manifest is written when all shards are there.
//! So the bytes of a finished dataset do not depend on interruptions, on the number of threads, or
//! on how its shards were divided among runs.
//! The times of the searches differ from run to run: they are in files beside the shards,
//! `shard-NNNNN.ms.csv`, which are not part of the dataset.

mod error;
mod run;
mod shard_range;
mod shards;
mod times;

pub use self::error::GenerateError;
pub use self::run::{Outcome, Settings, generate};
pub use self::shard_range::{ShardRange, ShardRangeError};
pub use self::times::search_times;

#[cfg(test)]
mod tests;
