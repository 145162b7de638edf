//! The records of a dataset, in order or shuffled.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::file::FileError;
use crate::manifest::{Manifest, ManifestError, ShardEntry};
use crate::shard::{Record, ShardError, ShardReader, ShardSummary, flatten};

/// A finished dataset: a folder with a manifest and the shards that it lists.
#[derive(Clone, Debug)]
pub struct Dataset {
    folder: PathBuf,
    manifest: Manifest,
}

/// Why a dataset could not be read.
/// The messages name the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The manifest can't be loaded.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A shard is missing or can't be opened.
    #[error(transparent)]
    File(#[from] FileError),
    /// A shard has another length than the manifest says.
    #[error("'{path}' has {got} bytes, the manifest says {expected}", path = path.display())]
    Length {
        /// The shard.
        path: PathBuf,
        /// Bytes according to the manifest.
        expected: u64,
        /// Bytes of the file.
        got: u64,
    },
    /// A shard is sound, but not the one that the manifest describes.
    #[error("'{path}' is not the shard that the manifest describes", path = path.display())]
    OtherShard {
        /// The shard.
        path: PathBuf,
    },
    /// A shard can't be read.
    #[error("cannot read '{path}': {cause}", path = path.display())]
    Shard {
        /// The shard.
        path: PathBuf,
        /// What is wrong with it.
        cause: ShardError,
    },
}

/// A block of a dataset.
#[derive(Clone, Copy)]
struct BlockId {
    shard: usize,
    block: u32,
}

/// The shard read last and its number: consecutive blocks of one shard need no second opening.
type LastShard = Option<(usize, ShardReader<File>)>;

impl Dataset {
    /// Loads the manifest of a folder and checks that all shards are there and have the right
    /// lengths.
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        let dataset = Self { manifest: Manifest::load(folder)?, folder: folder.to_owned() };
        for entry in &dataset.manifest.shards {
            let path = dataset.path(entry);
            let got =
                fs::metadata(&path).map_err(|cause| FileError::new("read", &path, cause))?.len();
            if got != entry.bytes {
                return Err(DatasetError::Length { path, expected: entry.bytes, got });
            }
        }
        Ok(dataset)
    }

    /// What it holds.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Checks every byte of one shard, also against the manifest.
    /// Independent of other shards, so several can be checked in parallel.
    ///
    /// # Panics
    /// If the manifest lists no shard of this number.
    pub fn verify_shard(&self, shard: usize) -> Result<ShardSummary, DatasetError> {
        let entry = &self.manifest.shards[shard];
        let path = self.path(entry);
        let summary = self.open_shard(shard)?.verify();
        let summary = summary.map_err(|cause| DatasetError::Shard { path: path.clone(), cause })?;
        if ShardEntry::new(entry.file.clone(), entry.first, summary.clone()) != *entry {
            return Err(DatasetError::OtherShard { path });
        }
        Ok(summary)
    }

    /// All records in order, one block in memory at a time.
    /// A block that can't be read gives one error, and the records go on with the next block's.
    pub fn records<T: Record>(&self) -> impl Iterator<Item = Result<T, DatasetError>> {
        let mut last = None;
        flatten(self.blocks().map(move |id| self.read_block(id, &mut last)))
    }

    /// All records in a random order, each once: the stream of one epoch of training.
    ///
    /// The blocks of all shards are shuffled; `window` of them (0 counts as 1) are in memory at a
    /// time, and each record is drawn from all that are, all being equally likely.
    /// A block of which the last record is drawn makes room for the next.
    /// The order depends on the dataset's shape, the seed, the epoch and the window, and is the
    /// same on every machine.
    /// A block that can't be read gives one error, and the stream goes on without it.
    pub fn shuffled<T: Record>(&self, seed: u64, epoch: u64, window: usize) -> Shuffled<'_, T> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(epoch);
        let mut waiting: Vec<_> = self.blocks().collect();
        waiting.shuffle(&mut rng);
        let window = window.clamp(1, waiting.len().max(1));
        Shuffled {
            dataset: self,
            rng,
            waiting,
            free: (0..window as u32).collect(),
            left: vec![0; window],
            held: Vec::new(),
            last: None,
        }
    }

    fn blocks(&self) -> impl Iterator<Item = BlockId> {
        let shards = self.manifest.shards.iter().enumerate();
        shards
            .flat_map(|(shard, entry)| (0..entry.blocks).map(move |block| BlockId { shard, block }))
    }

    fn path(&self, entry: &ShardEntry) -> PathBuf {
        self.folder.join(&entry.file)
    }

    fn open_shard(&self, shard: usize) -> Result<ShardReader<File>, DatasetError> {
        let entry = &self.manifest.shards[shard];
        let path = self.path(entry);
        let file = File::open(&path).map_err(|cause| FileError::new("read", &path, cause))?;
        let reader = ShardReader::open(file)
            .map_err(|cause| DatasetError::Shard { path: path.clone(), cause })?;
        let found = (reader.header().first_record, reader.record_count(), reader.block_count());
        if found != (entry.first, entry.records, entry.blocks) {
            return Err(DatasetError::OtherShard { path });
        }
        Ok(reader)
    }

    fn read_block<T: Record>(
        &self,
        id: BlockId,
        last: &mut LastShard,
    ) -> Result<Vec<T>, DatasetError> {
        if last.as_ref().is_none_or(|&(shard, _)| shard != id.shard) {
            // Closed before the next one opens, for both would hold a block's memory.
            *last = None;
            *last = Some((id.shard, self.open_shard(id.shard)?));
        }
        let (_, reader) = last.as_mut().expect("just opened");
        reader.read_block(id.block).map_err(|cause| DatasetError::Shard {
            path: self.path(&self.manifest.shards[id.shard]),
            cause,
        })
    }
}

/// The records of a dataset in a random order.
/// See [`Dataset::shuffled`].
pub struct Shuffled<'a, T> {
    dataset: &'a Dataset,
    rng: ChaCha8Rng,
    /// Blocks still to be read, the next one last.
    waiting: Vec<BlockId>,
    /// Places in the window without a block.
    free: Vec<u32>,
    /// For each place in the window, how many records of its block are held.
    left: Vec<u32>,
    /// The records held, each with the place of its block.
    held: Vec<(u32, T)>,
    last: LastShard,
}

impl<T: Record> Shuffled<'_, T> {
    /// Reads blocks until the window is full or none is left.
    fn fill(&mut self) -> Result<(), DatasetError> {
        while let Some(&place) = self.free.last()
            && let Some(id) = self.waiting.pop()
        {
            let records = self.dataset.read_block(id, &mut self.last)?;
            self.free.pop();
            self.left[place as usize] = records.len() as u32;
            self.held.extend(records.into_iter().map(|record| (place, record)));
        }
        Ok(())
    }
}

impl<T: Record> Iterator for Shuffled<'_, T> {
    type Item = Result<T, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Err(error) = self.fill() {
            return Some(Err(error));
        }
        if self.held.is_empty() {
            return None;
        }
        let (place, record) = self.held.swap_remove(self.rng.random_range(0..self.held.len()));
        self.left[place as usize] -= 1;
        if self.left[place as usize] == 0 {
            self.free.push(place);
        }
        Some(Ok(record))
    }
}

#[cfg(test)]
mod tests;
