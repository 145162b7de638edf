//! Packing records into blocks, and writing blocks as a shard.

use std::io::{self, Write};

use sha2::{Digest, Sha256};
use thiserror::Error;

use super::format::{Outline, Record, ShardHeader, ShardSummary, crc32};
use crate::CodecError;
use crate::codec;

/// Some records, encoded and compressed: what a shard is made of, and the least that is read at a
/// time.
///
/// A reader decodes a whole block for one of its records, and a shuffled stream holds several: some
/// hundred kilobytes of raw bytes compress well and read fast.
/// The bytes depend on the records, the level and the zstd version alone.
#[derive(Clone, Debug)]
pub struct Block {
    kind: u16,
    records: u32,
    raw_bytes: u32,
    crc32: u32,
    bytes: Vec<u8>,
}

/// Why records could not become a block.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PackError {
    /// There are no records.
    #[error("a block needs at least one record")]
    Empty,
    /// The records can't be encoded, or are too long for one block.
    #[error(transparent)]
    Codec(#[from] CodecError),
    /// zstd failed.
    #[error("the block can't be compressed: {0}")]
    Compress(io::Error),
}

impl Block {
    /// The level to use unless there is a reason not to.
    /// Moves are dense: the levels above save a few percent of the file for twice the time and
    /// more, level 1 saves half of the time and adds a tenth to the file.
    pub const DEFAULT_LEVEL: i32 = 3;

    /// Encodes and compresses records.
    /// Pure, so that blocks can be packed in parallel.
    ///
    /// `level` is zstd's, 1 (fast) to 22 (small); values beyond are clamped, 0 is zstd's own
    /// default.
    /// Reading takes about the same time at every level.
    pub fn pack<R: Record>(records: &[R], level: i32) -> Result<Self, PackError> {
        if records.is_empty() {
            return Err(PackError::Empty);
        }
        let raw = codec::encode(records)?;
        let mut bytes = zstd::bulk::compress(&raw, level).map_err(PackError::Compress)?;
        // The buffer was as large as the raw bytes, and packed blocks may wait for their turn.
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
/// After an error the output is of no use; [`write_whole`](crate::write_whole()) makes sure that no
/// such file stays.
#[derive(Debug)]
pub struct ShardWriter<W> {
    out: W,
    outline: Outline,
    hasher: Sha256,
}

impl<W: Write> ShardWriter<W> {
    /// Begins a shard with its header.
    pub fn new(mut out: W, header: ShardHeader) -> io::Result<Self> {
        let outline = Outline::new(header);
        let bytes = outline.header_bytes();
        out.write_all(&bytes)?;
        Ok(Self { out, outline, hasher: Sha256::new_with_prefix(bytes) })
    }

    /// Appends a block.
    ///
    /// # Panics
    /// If the block's records are of another kind than the header says, or the record numbers or
    /// the blocks exceed their range of 64 or 32 bits.
    pub fn block(&mut self, block: &Block) -> io::Result<()> {
        assert_eq!(
            block.kind, self.outline.header.kind,
            "the block's schema kind must be the shard's"
        );
        self.out.write_all(&block.bytes)?;
        self.hasher.update(&block.bytes);
        self.outline
            .push(block.bytes.len() as u32, block.raw_bytes, block.records, block.crc32)
            .expect("blocks and records must keep to their range of numbers");
        Ok(())
    }

    /// Ends the shard with its index and footer, flushes, and gives the output back.
    pub fn finish(mut self) -> io::Result<(W, ShardSummary)> {
        self.out.write_all(&self.outline.tail_bytes())?;
        self.out.flush()?;
        Ok((self.out, self.outline.summary(self.hasher)))
    }
}
