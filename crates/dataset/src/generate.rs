//! Makes a dataset in a folder: shard by shard, so that an interrupted run goes on where it
//! stopped.
//!
//! A shard is written whole or not at all, and depends on nothing but the configuration and its
//! number; the manifest comes when all are there.
//! So the bytes of a finished dataset are the same however often the work was interrupted, by
//! however many threads it was done, and however it was split into slices.
//! How long each search took can't be the same: it lies beside the shard, in `shard-NNNNN.ms.csv`,
//! and is no part of the dataset.

use std::fmt;
use std::fs::{self, File};
use std::io::{BufReader, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use rayon::prelude::*;
use thiserror::Error;

use crate::factory::{Factory, FactoryError};
use crate::file::{FileError, remove_partials, write_whole};
use crate::manifest::{Manifest, ManifestError, ShardEntry};
use crate::shard::{
    Block, PackError, Record, ShardError, ShardHeader, ShardReader, ShardSummary, ShardWriter,
};
use crate::trajectory::Trajectory;

impl Record for Trajectory {
    const KIND: u16 = 1;
}

/// Most trajectories in a block: enough for zstd to find what they share, few enough to shuffle
/// well.
const PER_BLOCK: usize = 32;

/// Bytes, about, after which a block takes no further trajectory: large pictures would outgrow the
/// format's limit.
const BLOCK_BYTES: usize = 8 << 20;

/// Level of compression; the search takes a hundred times as long, and higher levels gain a few per
/// cent.
const LEVEL: i32 = Block::DEFAULT_LEVEL;

/// One of several equal parts of a dataset, written "2/5": the second of five.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slice {
    part: u32,
    of: u32,
}

/// A text that is no [`Slice`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no slice: write I/N, with I from 1 to N, such as 2/5")]
pub struct SliceError(pub String);

impl Slice {
    /// The whole dataset.
    pub const WHOLE: Self = Self { part: 1, of: 1 };

    fn shards(self, count: u32) -> Range<u32> {
        let cut = |part: u32| (u64::from(count) * u64::from(part) / u64::from(self.of)) as u32;
        cut(self.part - 1)..cut(self.part)
    }
}

impl FromStr for Slice {
    type Err = SliceError;

    fn from_str(text: &str) -> Result<Self, SliceError> {
        let slice = text.split_once('/').and_then(|(part, of)| {
            let (part, of) = (part.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&part).then_some(Self { part, of })
        });
        slice.ok_or_else(|| SliceError(text.to_owned()))
    }
}

impl fmt::Display for Slice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.of)
    }
}

/// How to make a dataset.
#[derive(Clone, Copy)]
pub struct GenerateSettings<'a> {
    /// The part to make.
    pub slice: Slice,
    /// Threads of the pool that searches; 0 for one a core.
    pub threads: usize,
    /// Stops the work soon after it turns true; finished shards stay.
    pub cancel: &'a AtomicBool,
    /// Told after each trajectory, from any thread, how far the work has come.
    pub observer: &'a (dyn Fn(GenerateProgress) + Sync),
}

/// How far a [`generate`] has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GenerateProgress {
    /// Trajectories of this slice that are searched, those of earlier runs included.
    pub done: u64,
    /// Of them, those made by earlier runs.
    pub kept: u64,
    /// Trajectories of this slice.
    pub total: u64,
}

/// What a [`generate`] has left in the folder.
#[derive(Clone, Debug)]
pub struct Generated {
    /// The manifest, if the whole dataset is there now.
    pub manifest: Option<Manifest>,
    /// Trajectories made by this run.
    pub made: u64,
    /// Trajectories of this slice that earlier runs had made.
    pub kept: u64,
    /// Shards of the whole dataset that are still missing: those of other slices, or all left by a
    /// cancelled run.
    pub missing: u32,
    /// Whether it was cancelled.
    pub cancelled: bool,
}

/// Why a dataset can't be made.
/// The messages name the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// A file can't be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A combination of the configuration is impossible.
    #[error(transparent)]
    Factory(#[from] FactoryError),
    /// The manifest that lies there can't be read.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// The folder holds another dataset.
    #[error("'{path}' belongs to a dataset of another configuration or version: choose another folder", path = path.display())]
    OtherDataset {
        /// The shard or manifest.
        path: PathBuf,
    },
    /// A shard of an earlier run is damaged.
    #[error("cannot go on from '{path}': {cause}; remove it to have it made again", path = path.display())]
    Shard {
        /// The shard.
        path: PathBuf,
        /// What is wrong with it.
        cause: ShardError,
    },
    /// Trajectories don't fit into a block.
    #[error("cannot write '{path}': {cause}", path = path.display())]
    Pack {
        /// The shard.
        path: PathBuf,
        /// Why not.
        cause: PackError,
    },
    /// The threads can't be started.
    #[error("cannot start {threads} threads: {cause}")]
    Threads {
        /// Asked number.
        threads: usize,
        /// Why not.
        cause: rayon::ThreadPoolBuildError,
    },
}

/// A finished shard.
#[derive(Clone, Debug)]
struct Shard {
    summary: ShardSummary,
    moves: u64,
}

/// A shard to be written.
struct Made {
    number: u32,
    blocks: Vec<Block>,
    moves: u64,
    milliseconds: Vec<f64>,
}

/// Makes the dataset of a factory in a folder, or what is missing of it.
///
/// Searches run in a pool of their own; the shard before is written meanwhile.
/// Memory: two shards.
pub fn generate(
    factory: &Factory,
    folder: &Path,
    settings: &GenerateSettings<'_>,
) -> Result<Generated, GenerateError> {
    fs::create_dir_all(folder).map_err(|cause| FileError::new("write", folder, cause))?;
    check_manifest(factory, folder)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build();
    let pool = pool.map_err(|cause| GenerateError::Threads { threads: settings.threads, cause })?;
    let layout = Shards::new(factory, folder);
    let mine = settings.slice.shards(layout.count);

    let mut shards = vec![None; layout.count as usize];
    pool.install(|| layout.find_missing(&mut shards))?;
    let size = |number: u32| layout.records(number).end - layout.records(number).start;
    let kept = mine.clone().filter(|&number| shards[number as usize].is_some()).map(size).sum();
    let total = mine.clone().map(size).sum();
    let done = AtomicU64::new(kept);
    let report = |more: u64| {
        let done = done.fetch_add(more, Ordering::Relaxed) + more;
        (settings.observer)(GenerateProgress { done, kept, total });
    };
    report(0);

    let todo: Vec<u32> = mine.filter(|&number| shards[number as usize].is_none()).collect();
    let mut made = 0;
    let cancelled = std::thread::scope(|scope| -> Result<bool, GenerateError> {
        let (sender, receiver) = mpsc::sync_channel::<Made>(0);
        let layout = &layout;
        let writer = scope.spawn(move || {
            receiver
                .into_iter()
                .map(|made| Ok((made.number, layout.write(&made)?)))
                .collect::<Result<Vec<_>, FileError>>()
        });
        let search = || {
            for &number in &todo {
                let made = pool.install(|| layout.make(number, settings.cancel, &|| report(1)))?;
                let Some(made) = made else { return Ok(true) };
                if sender.send(made).is_err() {
                    // The writer hangs up only when it has failed; its own error says why.
                    break;
                }
            }
            Ok(false)
        };
        let searched = search();
        drop(sender);
        let written = writer.join().expect("the writer does not panic")?;
        for (number, shard) in written {
            made += shard.summary.records;
            shards[number as usize] = Some(shard);
        }
        searched
    })?;

    // Other slices may have been at work meanwhile.
    pool.install(|| layout.find_missing(&mut shards))?;
    let missing = shards.iter().filter(|shard| shard.is_none()).count() as u32;
    let manifest = match shards.into_iter().collect::<Option<Vec<Shard>>>() {
        Some(shards) => {
            let manifest = layout.manifest(shards);
            layout.store(&manifest)?;
            Some(manifest)
        }
        None => None,
    };
    Ok(Generated { manifest, made, kept, missing, cancelled })
}

/// Milliseconds that each search of a shard took, in the order of its records; `None` where they
/// are not known.
pub fn search_times(shard: &Path) -> Option<Vec<f64>> {
    let text = fs::read_to_string(times_file(shard)).ok()?;
    text.lines().skip(1).map(|line| line.split_once(',')?.1.parse().ok()).collect()
}

fn times_file(shard: &Path) -> PathBuf {
    shard.with_extension("ms.csv")
}

/// Refuses a folder whose finished dataset is another one.
fn check_manifest(factory: &Factory, folder: &Path) -> Result<(), GenerateError> {
    match Manifest::load(folder) {
        Ok(manifest) if manifest.config == *factory.echo() && manifest.crate_version == VERSION => {
            Ok(())
        }
        Ok(_) => Err(GenerateError::OtherDataset { path: folder.join(Manifest::FILE) }),
        Err(ManifestError::Missing { .. }) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// How a dataset is split into shards.
struct Shards<'a> {
    factory: &'a Factory,
    folder: &'a Path,
    count: u32,
}

impl<'a> Shards<'a> {
    fn new(factory: &'a Factory, folder: &'a Path) -> Self {
        let count = factory.config().count.div_ceil(u64::from(factory.config().per_shard)) as u32;
        Self { factory, folder, count }
    }

    fn records(&self, number: u32) -> Range<u64> {
        let (count, per_shard) =
            (self.factory.config().count, u64::from(self.factory.config().per_shard));
        let first = u64::from(number) * per_shard;
        first..count.min(first + per_shard)
    }

    fn file(number: u32) -> String {
        format!("shard-{number:05}.bws")
    }

    fn header(&self, number: u32) -> ShardHeader {
        ShardHeader {
            kind: Trajectory::KIND,
            shard: number,
            fingerprint: self.factory.fingerprint(),
            first_record: self.records(number).start,
        }
    }

    /// Looks for the shards that are not known yet.
    fn find_missing(&self, shards: &mut [Option<Shard>]) -> Result<(), GenerateError> {
        let missing = shards.par_iter_mut().enumerate().filter(|(_, shard)| shard.is_none());
        missing.try_for_each(|(number, shard)| {
            *shard = self.find(number as u32)?;
            Ok(())
        })
    }

    /// The shard of an earlier run, checked byte by byte; `None` if there is none.
    fn find(&self, number: u32) -> Result<Option<Shard>, GenerateError> {
        let path = self.folder.join(Self::file(number));
        let file = match File::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(cause) => return Err(FileError::new("read", &path, cause).into()),
        };
        let read = |file| -> Result<(ShardHeader, Shard), ShardError> {
            let mut reader = ShardReader::open(BufReader::new(file))?;
            let mut moves = 0;
            for trajectory in reader.records::<Trajectory>() {
                moves += trajectory?.moves.len() as u64;
            }
            Ok((*reader.header(), Shard { summary: reader.verify()?, moves }))
        };
        match read(file) {
            Ok((header, _)) if header != self.header(number) => {
                Err(GenerateError::OtherDataset { path })
            }
            Ok((_, shard)) => Ok(Some(shard)),
            Err(cause) => Err(GenerateError::Shard { path, cause }),
        }
    }

    /// Searches and packs a shard in the present pool; `None` if cancelled.
    fn make(
        &self,
        number: u32,
        cancel: &AtomicBool,
        report: &(dyn Fn() + Sync),
    ) -> Result<Option<Made>, GenerateError> {
        let indices: Vec<u64> = self.records(number).collect();
        let searched = indices.into_par_iter().with_max_len(1).map(|index| {
            let begin = Instant::now();
            let trajectory = if cancel.load(Ordering::Relaxed) {
                None
            } else {
                self.factory.trajectory(index, cancel)?
            };
            if trajectory.is_some() {
                report();
            }
            Ok(trajectory.map(|trajectory| (trajectory, begin.elapsed().as_secs_f64() * 1e3)))
        });
        let searched: Result<Option<Vec<_>>, FactoryError> = searched.collect();
        let Some(searched) = searched? else { return Ok(None) };
        let (trajectories, milliseconds): (Vec<Trajectory>, Vec<f64>) =
            searched.into_iter().unzip();
        let moves = trajectories.iter().map(|trajectory| trajectory.moves.len() as u64).sum();
        let chunks = chunks(&trajectories, Trajectory::size_hint);
        let blocks =
            chunks.into_par_iter().map(|chunk| Block::pack(chunk, LEVEL)).collect::<Result<_, _>>();
        let blocks = blocks.map_err(|cause| GenerateError::Pack {
            path: self.folder.join(Self::file(number)),
            cause,
        })?;
        Ok(Some(Made { number, blocks, moves, milliseconds }))
    }

    /// Writes a shard, and before it the times of its searches.
    fn write(&self, made: &Made) -> Result<Shard, FileError> {
        let file = self.folder.join(Self::file(made.number));
        write_whole(&times_file(&file), |out| {
            writeln!(out, "trajectory,milliseconds")?;
            for (index, milliseconds) in self.records(made.number).zip(&made.milliseconds) {
                writeln!(out, "{index},{milliseconds:.3}")?;
            }
            Ok(())
        })?;
        let summary = write_whole(&file, |out| {
            let mut writer = ShardWriter::new(out, self.header(made.number))?;
            for block in &made.blocks {
                writer.block(block)?;
            }
            writer.finish().map(|(_, summary)| summary)
        })?;
        Ok(Shard { summary, moves: made.moves })
    }

    /// Stores the manifest and clears up after killed runs; two slices that end at once take turns.
    fn store(&self, manifest: &Manifest) -> Result<(), FileError> {
        let first = self.folder.join(Self::file(0));
        let turn = File::open(&first).and_then(|file| file.lock().map(|()| file));
        let _turn = turn.map_err(|cause| FileError::new("lock", &first, cause))?;
        manifest.store(self.folder)?;
        // All shards are there, so nobody is writing one.
        remove_partials(self.folder)
    }

    fn manifest(&self, shards: Vec<Shard>) -> Manifest {
        Manifest {
            format_version: Manifest::FORMAT_VERSION,
            schema: "trajectories".to_owned(),
            crate_version: VERSION.to_owned(),
            seed: self.factory.config().seed,
            config: self.factory.echo().clone(),
            records: self.factory.config().count,
            moves: shards.iter().map(|shard| shard.moves).sum(),
            strata: self.factory.strata().map(|(name, count)| (name.to_owned(), count)).collect(),
            shards: (0..)
                .zip(shards)
                .map(|(number, shard)| {
                    ShardEntry::new(Self::file(number), self.records(number).start, shard.summary)
                })
                .collect(),
        }
    }
}

/// Splits records into blocks by their number and their sizes.
fn chunks<T>(mut records: &[T], size: impl Fn(&T) -> usize) -> Vec<&[T]> {
    let mut chunks = Vec::new();
    while !records.is_empty() {
        let mut bytes = 0;
        let fitting = records.iter().take(PER_BLOCK).take_while(|record| {
            let fits = bytes < BLOCK_BYTES;
            bytes += size(record);
            fits
        });
        let (chunk, rest) = records.split_at(fitting.count());
        chunks.push(chunk);
        records = rest;
    }
    chunks
}

#[cfg(test)]
mod tests;
