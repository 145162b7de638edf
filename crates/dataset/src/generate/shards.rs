//! The shards of a dataset: finding, making and writing them.

use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use beadwork_base::Control;
use rayon::prelude::*;

use super::error::GenerateError;
use super::times::write_search_times;
use crate::factory::Factory;
use crate::file::{FileError, remove_partials, write_atomic};
use crate::manifest::{Manifest, ManifestError, ShardEntry};
use crate::shard::{
    Block, Record, ShardError, ShardHeader, ShardReader, ShardSummary, ShardWriter,
};
use crate::stratum::FactoryError;
use crate::trajectory::Trajectory;

/// Maximum number of trajectories in a block: enough for zstd to find common patterns, few enough
/// to shuffle well.
const PER_BLOCK: usize = 32;

/// Approximate size in bytes from which a block takes no further trajectory: with large pictures,
/// [`PER_BLOCK`] trajectories would exceed the format's limit.
pub(super) const BLOCK_BYTES: usize = 8 << 20;

/// Compression level.
/// The searches take a hundred times as long as packing, but higher levels save only a few per
/// cent.
const LEVEL: i32 = Block::DEFAULT_LEVEL;

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The shards that a dataset is divided into.
pub(super) struct Shards<'a> {
    factory: &'a Factory,
    folder: &'a Path,
    /// Number of shards.
    pub(super) count: u32,
}

/// A finished shard in the folder.
#[derive(Clone, Debug)]
pub(super) struct FinishedShard {
    pub(super) summary: ShardSummary,
    moves: u64,
}

/// A shard in memory, to be written.
pub(super) struct PackedShard {
    pub(super) number: u32,
    blocks: Vec<Block>,
    moves: u64,
    /// Time of each search.
    milliseconds: Vec<f64>,
}

impl<'a> Shards<'a> {
    pub(super) fn new(factory: &'a Factory, folder: &'a Path) -> Self {
        let count = factory.config().count.div_ceil(u64::from(factory.config().per_shard)) as u32;
        Self { factory, folder, count }
    }

    /// Numbers of a shard's records.
    pub(super) fn records(&self, number: u32) -> Range<u64> {
        let (count, per_shard) =
            (self.factory.config().count, u64::from(self.factory.config().per_shard));
        let first = u64::from(number) * per_shard;
        first..count.min(first + per_shard)
    }

    fn file_name(number: u32) -> String {
        format!("shard-{number:05}.bws")
    }

    fn path(&self, number: u32) -> PathBuf {
        self.folder.join(Self::file_name(number))
    }

    fn header(&self, number: u32) -> ShardHeader {
        ShardHeader {
            kind: Trajectory::KIND,
            shard: number,
            fingerprint: self.factory.fingerprint(),
            first_record: self.records(number).start,
        }
    }

    /// Returns an error if the folder has the manifest of another dataset, or one that cannot be
    /// read.
    pub(super) fn check_manifest(&self) -> Result<(), GenerateError> {
        match Manifest::load(self.folder) {
            Ok(manifest)
                if manifest.config == *self.factory.resolved_config()
                    && manifest.crate_version == VERSION =>
            {
                Ok(())
            }
            Ok(_) => Err(GenerateError::OtherDataset { path: self.folder.join(Manifest::FILE) }),
            Err(ManifestError::Missing { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Looks in the folder for the shards that are `None`, and checks those that it finds.
    pub(super) fn find_finished(
        &self,
        shards: &mut [Option<FinishedShard>],
        control: &Control<'_>,
    ) -> Result<(), GenerateError> {
        let numbers: Vec<u32> =
            (0..self.count).filter(|&number| shards[number as usize].is_none()).collect();
        let found = control.threads.map(&numbers, |&number| {
            control.check()?;
            self.find(number, control)
        });
        for (number, found) in numbers.into_iter().zip(found) {
            shards[number as usize] = found?;
        }
        Ok(())
    }

    /// Reads a finished shard and checks every byte; `None` if it is not in the folder.
    fn find(
        &self,
        number: u32,
        control: &Control<'_>,
    ) -> Result<Option<FinishedShard>, GenerateError> {
        let path = self.path(number);
        let file = match File::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(cause) => return Err(FileError::new("read", &path, cause).into()),
        };
        let read = |file| -> Result<(ShardHeader, FinishedShard), ShardError> {
            let mut reader = ShardReader::open(BufReader::new(file))?;
            let mut moves = 0;
            for trajectory in reader.records::<Trajectory>() {
                moves += trajectory?.moves.len() as u64;
            }
            Ok((
                *reader.header(),
                FinishedShard { summary: reader.verify(&control.without_progress())?, moves },
            ))
        };
        match read(file) {
            Ok((header, _)) if header != self.header(number) => {
                Err(GenerateError::OtherDataset { path })
            }
            Ok((_, shard)) => Ok(Some(shard)),
            Err(ShardError::Interrupted(interrupted)) => Err(interrupted.into()),
            Err(cause) => Err(GenerateError::Shard { path, cause }),
        }
    }

    /// Runs the searches of a shard and packs their trajectories.
    /// Calls `searched` after each search, from any thread.
    pub(super) fn make(
        &self,
        number: u32,
        control: &Control<'_>,
        searched: &(dyn Fn() + Sync),
    ) -> Result<PackedShard, GenerateError> {
        let search = |&index: &u64| -> Result<(Trajectory, f64), FactoryError> {
            control.check()?;
            let begin = Instant::now();
            let trajectory = self.factory.trajectory(index, control)?;
            searched();
            Ok((trajectory, begin.elapsed().as_secs_f64() * 1e3))
        };
        let records: Vec<u64> = self.records(number).collect();
        // Searches take very different times, so each one is scheduled separately.
        let results: Result<Vec<_>, FactoryError> = control.threads.either(
            || records.iter().map(search).collect(),
            || records.par_iter().with_max_len(1).map(search).collect(),
        );
        let (trajectories, milliseconds): (Vec<Trajectory>, Vec<f64>) =
            results?.into_iter().unzip();

        let moves = trajectories.iter().map(|trajectory| trajectory.moves.len() as u64).sum();
        let chunks = split_into_blocks(&trajectories, Trajectory::size_hint);
        let packed = control.threads.map(&chunks, |chunk| Block::pack(chunk, LEVEL));
        let blocks: Result<_, _> = packed.into_iter().collect();
        let blocks =
            blocks.map_err(|cause| GenerateError::Pack { path: self.path(number), cause })?;
        Ok(PackedShard { number, blocks, moves, milliseconds })
    }

    /// Writes the times of a shard's searches, then the shard.
    pub(super) fn write(&self, packed: &PackedShard) -> Result<FinishedShard, FileError> {
        let path = self.path(packed.number);
        let header = self.header(packed.number);
        write_search_times(&path, header.first_record, &packed.milliseconds)?;
        let summary = write_atomic(&path, |out| {
            let mut writer = ShardWriter::new(out, header)?;
            for block in &packed.blocks {
                writer.block(block)?;
            }
            writer.finish().map(|(_, summary)| summary)
        })?;
        Ok(FinishedShard { summary, moves: packed.moves })
    }

    /// Writes the manifest and removes the temporary files of killed runs.
    ///
    /// A lock on the first shard keeps two runs that finish at the same time from doing this
    /// together.
    pub(super) fn store(&self, manifest: &Manifest) -> Result<(), FileError> {
        let first = self.path(0);
        let lock = File::open(&first).and_then(|file| file.lock().map(|()| file));
        let _lock = lock.map_err(|cause| FileError::new("lock", &first, cause))?;
        manifest.store(self.folder)?;
        // All shards are finished, so no run is writing one.
        remove_partials(self.folder)
    }

    /// The manifest of the finished dataset.
    pub(super) fn manifest(&self, shards: Vec<FinishedShard>) -> Manifest {
        Manifest {
            format_version: Manifest::FORMAT_VERSION,
            schema: "trajectories".to_owned(),
            crate_version: VERSION.to_owned(),
            seed: self.factory.config().seed,
            config: self.factory.resolved_config().clone(),
            records: self.factory.config().count,
            moves: shards.iter().map(|shard| shard.moves).sum(),
            strata: self.factory.strata().map(|(name, count)| (name.to_owned(), count)).collect(),
            shards: (0..)
                .zip(shards)
                .map(|(number, shard)| {
                    let first = self.records(number).start;
                    ShardEntry::new(Self::file_name(number), first, shard.summary)
                })
                .collect(),
        }
    }
}

/// Splits records into blocks of at most [`PER_BLOCK`] records and about [`BLOCK_BYTES`] bytes.
pub(super) fn split_into_blocks<T>(mut records: &[T], size: impl Fn(&T) -> usize) -> Vec<&[T]> {
    let mut blocks = Vec::new();
    while !records.is_empty() {
        let mut bytes = 0;
        let fitting = records.iter().take(PER_BLOCK).take_while(|record| {
            let fits = bytes < BLOCK_BYTES;
            bytes += size(record);
            fits
        });
        let (block, rest) = records.split_at(fitting.count());
        blocks.push(block);
        records = rest;
    }
    blocks
}
