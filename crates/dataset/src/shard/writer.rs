//! Packing records into blocks, and writing blocks to a shard.

use std::io::{self, Write};

use sha2::{Digest, Sha256};
use thiserror::Error;

use super::format::{Outline, Record, ShardHeader, ShardSummary, crc32};
use crate::codec::{self, CodecError};

/// Records that are encoded and compressed together.
///
/// A block is read as a whole, and a shuffled stream holds several blocks in memory, so a block
/// should have some hundred kilobytes before compression.
/// The compressed bytes depend on the records, the level and the zstd version alone.
#[derive(Clone, Debug)]
pub struct Block {
    kind: u16,
    records: u32,
    raw_bytes: u32,
    crc32: u32,
    bytes: Vec<u8>,
}

/// Why records cannot be packed into a block.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PackError {
    /// There are no records.
    #[error("a block needs at least one record")]
    Empty,
    /// The records cannot be encoded, or are too long for one block.
    #[error(transparent)]
    Codec(#[from] CodecError),
    /// zstd failed.
    #[error("block cannot be compressed: {0}")]
    Compress(io::Error),
}

impl Block {
    /// The recommended compression level.
    /// Moves contain little redundancy: higher levels save a few per cent of the file and take
    /// twice the time or more; level 1 halves the time and makes the file a tenth larger.
    pub const DEFAULT_LEVEL: i32 = 3;

    /// Encodes and compresses records.
    /// Blocks can be packed in parallel.
    ///
    /// `level` is the zstd level, 1 (fast) to 22 (small); values outside are clamped, and 0 is
    /// zstd's default.
    /// Reading takes about the same time at every level.
    pub fn pack<R: Record>(records: &[R], level: i32) -> Result<Self, PackError> {
        if records.is_empty() {
            return Err(PackError::Empty);
        }
        let raw = codec::encode(records)?;
        let mut bytes = zstd::bulk::compress(&raw, level).map_err(PackError::Compress)?;
        // The buffer was allocated for incompressible data, and all blocks of a shard are in memory
        // at once.
        bytes.shrink_to_fit();
        Ok(Self {
            kind: R::KIND,
            records: records.len() as u32,
            raw_bytes: raw.len() as u32,
            crc32: crc32(&[&bytes]),
            bytes,
        })
    }

    /// Number of records, at least 1.
    pub fn records(&self) -> u32 {
        self.records
    }

    /// Length in bytes before compression.
    pub fn raw_bytes(&self) -> u32 {
        self.raw_bytes
    }
}

/// Writes one shard, block by block.
///
/// After an error the output is unusable; [`write_atomic`](crate::write_atomic()) leaves no such
/// file behind.
#[derive(Debug)]
pub struct ShardWriter<W> {
    out: W,
    outline: Outline,
    hasher: Sha256,
}

impl<W: Write> ShardWriter<W> {
    /// Starts a shard by writing its header.
    pub fn new(mut out: W, header: ShardHeader) -> io::Result<Self> {
        let outline = Outline::new(header);
        let bytes = outline.header_bytes();
        out.write_all(&bytes)?;
        Ok(Self { out, outline, hasher: Sha256::new_with_prefix(bytes) })
    }

    /// Appends a block.
    ///
    /// # Panics
    /// If the block's schema kind differs from the header's, if the number of records exceeds 64
    /// bits, or if the number of blocks exceeds 32 bits.
    pub fn block(&mut self, block: &Block) -> io::Result<()> {
        assert_eq!(
            block.kind, self.outline.header.kind,
            "the block's schema kind must be the shard's"
        );
        self.out.write_all(&block.bytes)?;
        self.hasher.update(&block.bytes);
        self.outline
            .push(block.bytes.len() as u32, block.raw_bytes, block.records, block.crc32)
            .expect("numbers of blocks and records are in their ranges");
        Ok(())
    }

    /// Writes index and footer, flushes, and returns the output and a summary.
    pub fn finish(mut self) -> io::Result<(W, ShardSummary)> {
        self.out.write_all(&self.outline.tail_bytes())?;
        self.out.flush()?;
        Ok((self.out, self.outline.summary(self.hasher)))
    }
}
