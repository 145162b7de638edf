//! Reading the records of a dataset, in order or shuffled.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use beadwork_base::Control;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::file::FileError;
use crate::manifest::{Manifest, ManifestError, ShardEntry};
use crate::shard::{Record, ShardError, ShardReader, ShardSummary, flatten_blocks};

/// A finished dataset: a folder with a manifest and the shards that it lists.
#[derive(Clone, Debug)]
pub struct Dataset {
    folder: PathBuf,
    manifest: Manifest,
}

/// Why a dataset cannot be read.
/// The messages name the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The manifest cannot be loaded.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A shard is missing or cannot be opened.
    #[error(transparent)]
    File(#[from] FileError),
    /// The length of a shard differs from the manifest.
    #[error("'{path}' has {got} bytes, the manifest says {expected}", path = path.display())]
    Length {
        /// The shard.
        path: PathBuf,
        /// Length according to the manifest, in bytes.
        expected: u64,
        /// Length of the file in bytes.
        got: u64,
    },
    /// A shard is undamaged, but differs from the one in the manifest.
    #[error("'{path}' is not the shard that the manifest lists", path = path.display())]
    OtherShard {
        /// The shard.
        path: PathBuf,
    },
    /// A shard cannot be read.
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

/// The shard that was read last, with its number; it stays open because the next block is often in
/// the same shard.
type LastShard = Option<(usize, ShardReader<File>)>;

impl Dataset {
    /// Loads the manifest of a folder, and checks that all shards exist and have the right lengths.
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

    /// The manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Checks every byte of one shard, against its checksums and against the manifest.
    /// Linear in its length; shards can be checked in parallel.
    /// Progress counts blocks.
    ///
    /// # Panics
    /// If there is no shard of this number.
    pub fn verify_shard(
        &self,
        shard: usize,
        control: &Control<'_>,
    ) -> Result<ShardSummary, DatasetError> {
        let entry = &self.manifest.shards[shard];
        let path = self.path(entry);
        let summary = self.open_shard(shard)?.verify(control);
        let summary = summary.map_err(|cause| DatasetError::Shard { path: path.clone(), cause })?;
        if ShardEntry::new(entry.file.clone(), entry.first, summary.clone()) != *entry {
            return Err(DatasetError::OtherShard { path });
        }
        Ok(summary)
    }

    /// All records in order, with one block in memory at a time.
    /// A block that cannot be read gives one error, and iteration continues with the next block.
    pub fn records<T: Record>(&self) -> impl Iterator<Item = Result<T, DatasetError>> {
        let mut last = None;
        flatten_blocks(self.blocks().map(move |id| self.read_block(id, &mut last)))
    }

    /// All records in random order, each once: one epoch of training.
    ///
    /// The blocks of all shards are shuffled, and `window` of them (0 counts as 1) are in memory at
    /// a time.
    /// Each record is drawn uniformly from the records in memory; a block whose last record was
    /// drawn is replaced by the next block.
    /// The order depends on the number of records in each block, the seed, the epoch and the window
    /// alone, and is the same on every machine.
    /// A block that cannot be read gives one error, and iteration continues without it.
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
            // Close the last shard first: each reader keeps the memory of a block.
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

/// The records of a dataset in random order; see [`Dataset::shuffled`].
pub struct Shuffled<'a, T> {
    dataset: &'a Dataset,
    rng: ChaCha8Rng,
    /// Blocks to be read, the next one last.
    waiting: Vec<BlockId>,
    /// Slots of the window without a block.
    free: Vec<u32>,
    /// For each slot of the window, the number of its block's records in memory.
    left: Vec<u32>,
    /// The records in memory, each with the slot of its block.
    held: Vec<(u32, T)>,
    last: LastShard,
}

impl<T: Record> Shuffled<'_, T> {
    /// Reads blocks until the window is full or all blocks have been read.
    fn fill(&mut self) -> Result<(), DatasetError> {
        while let Some(&slot) = self.free.last()
            && let Some(id) = self.waiting.pop()
        {
            let records = self.dataset.read_block(id, &mut self.last)?;
            self.free.pop();
            self.left[slot as usize] = records.len() as u32;
            self.held.extend(records.into_iter().map(|record| (slot, record)));
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
        let (slot, record) = self.held.swap_remove(self.rng.random_range(0..self.held.len()));
        self.left[slot as usize] -= 1;
        if self.left[slot as usize] == 0 {
            self.free.push(slot);
        }
        Some(Ok(record))
    }
}

#[cfg(test)]
mod tests;
