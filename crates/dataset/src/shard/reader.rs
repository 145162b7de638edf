//! Reading a shard block by block, checking all of its bytes.

use std::io::{self, Read, Seek, SeekFrom};

use beadwork_base::{Control, Interrupted};
use sha2::{Digest, Sha256};
use thiserror::Error;
use zstd::bulk::Decompressor;

use super::format::{
    END_MAGIC, ENTRY_BYTES, FOOTER_BYTES, HEADER_BYTES, MAGIC, Outline, Record, ShardHeader,
    ShardSummary, VERSION, crc32, parse_entry, parse_footer, parse_header,
};
use crate::codec::{self, CodecError, MAX_BYTES};

/// Why a shard cannot be read.
/// The messages do not name the file, which a reader does not know.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ShardError {
    /// The magic at the beginning is wrong.
    #[error("not a shard file")]
    NotAShard,
    /// The shard has a format of another version.
    #[error("shard has format version {got}, this build reads version {expected}")]
    Version {
        /// The version this build reads.
        expected: u16,
        /// The version found.
        got: u16,
    },
    /// The records have another schema.
    #[error("records have schema kind {got}, expected {expected}")]
    Kind {
        /// The requested kind.
        expected: u16,
        /// The kind found.
        got: u16,
    },
    /// The magic at the end is missing.
    #[error("shard is truncated")]
    Truncated,
    /// The header, the index or the footer does not match its checksum.
    #[error("header or index is damaged")]
    DamagedIndex,
    /// A block does not match its checksum.
    #[error("block {block} is damaged")]
    DamagedBlock {
        /// Number of the block, from 0.
        block: u32,
    },
    /// A block is undamaged, but its records cannot be decoded as the requested type: fields were
    /// changed without a new schema kind.
    #[error("block {block} holds records of another type: {cause}")]
    Foreign {
        /// Number of the block, from 0.
        block: u32,
        /// Where decoding failed.
        cause: CodecError,
    },
    /// Reading failed.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The caller ended the call early.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Reads one shard; it trusts none of the bytes.
pub struct ShardReader<R> {
    input: R,
    outline: Outline,
    unpacker: Decompressor<'static>,
    /// Buffers for the compressed and the uncompressed bytes of a block.
    packed: Vec<u8>,
    raw: Vec<u8>,
}

impl<R: Read + Seek> ShardReader<R> {
    /// Reads and checks header, index and footer.
    /// The input must be the shard from its first byte to its last; it needs no buffering.
    pub fn open(mut input: R) -> Result<Self, ShardError> {
        let outline = read_outline(&mut input)?;
        Ok(Self {
            input,
            outline,
            unpacker: Decompressor::new()?,
            packed: Vec::new(),
            raw: Vec::new(),
        })
    }

    /// The header.
    pub fn header(&self) -> &ShardHeader {
        &self.outline.header
    }

    /// Number of blocks.
    pub fn block_count(&self) -> u32 {
        self.outline.blocks.len() as u32
    }

    /// Number of records.
    pub fn record_count(&self) -> u64 {
        self.outline.records
    }

    /// Index of a block's first record in the shard, from 0.
    ///
    /// # Panics
    /// If there is no block of this number.
    pub fn first_of_block(&self, block: u32) -> u64 {
        self.outline.blocks[block as usize].first_record - self.outline.header.first_record
    }

    /// The records of one block, in order.
    ///
    /// # Panics
    /// If there is no block of this number.
    pub fn read_block<T: Record>(&mut self, block: u32) -> Result<Vec<T>, ShardError> {
        if self.outline.header.kind != T::KIND {
            return Err(ShardError::Kind { expected: T::KIND, got: self.outline.header.kind });
        }
        self.unpack(block)?;
        let records: Vec<T> =
            codec::decode(&self.raw).map_err(|cause| ShardError::Foreign { block, cause })?;
        if records.len() != self.outline.blocks[block as usize].records as usize {
            return Err(ShardError::DamagedBlock { block });
        }
        Ok(records)
    }

    /// All records in order, with one block in memory at a time.
    /// A block that cannot be read gives one error, and iteration continues with the next block.
    pub fn records<T: Record>(&mut self) -> impl Iterator<Item = Result<T, ShardError>> {
        flatten_blocks((0..self.block_count()).map(|block| self.read_block(block)))
    }

    /// Checks every byte of the blocks ([`ShardReader::open`] has checked the rest) and returns a
    /// summary.
    /// Records are not decoded, so this works for any schema.
    /// Progress counts blocks.
    pub fn verify(&mut self, control: &Control<'_>) -> Result<ShardSummary, ShardError> {
        let mut hasher = Sha256::new_with_prefix(self.outline.header_bytes());
        let blocks = self.block_count();
        for block in 0..blocks {
            control.check()?;
            control.report(block as usize, blocks as usize);
            self.unpack(block)?;
            hasher.update(&self.packed);
        }
        control.report(blocks as usize, blocks as usize);
        Ok(self.outline.summary(hasher))
    }

    /// Reads, checks and decompresses a block.
    fn unpack(&mut self, block: u32) -> Result<(), ShardError> {
        let entry = self.outline.blocks[block as usize];
        self.packed.resize(entry.bytes as usize, 0);
        self.input.seek(SeekFrom::Start(entry.offset))?;
        read_all(&mut self.input, &mut self.packed)?;
        if crc32(&[&self.packed]) != entry.crc32 {
            return Err(ShardError::DamagedBlock { block });
        }
        self.raw.clear();
        self.raw.reserve(entry.raw_bytes as usize);
        let written = self.unpacker.decompress_to_buffer(&self.packed, &mut self.raw);
        match written {
            Ok(written) if written == entry.raw_bytes as usize => Ok(()),
            _ => Err(ShardError::DamagedBlock { block }),
        }
    }
}

/// The records of all blocks, with one error for each block that could not be read.
pub(crate) fn flatten_blocks<T, E>(
    blocks: impl Iterator<Item = Result<Vec<T>, E>>,
) -> impl Iterator<Item = Result<T, E>> {
    blocks.flat_map(|block| {
        let (records, error) = match block {
            Ok(records) => (records, None),
            Err(error) => (Vec::new(), Some(Err(error))),
        };
        records.into_iter().map(Ok).chain(error)
    })
}

fn read_outline<R: Read + Seek>(input: &mut R) -> Result<Outline, ShardError> {
    let length = input.seek(SeekFrom::End(0))?;
    input.seek(SeekFrom::Start(0))?;
    let mut header = Vec::with_capacity(HEADER_BYTES);
    input.by_ref().take(HEADER_BYTES as u64).read_to_end(&mut header)?;
    let magic = &header[..header.len().min(MAGIC.len())];
    if !MAGIC.starts_with(magic) {
        return Err(ShardError::NotAShard);
    }
    // The version is checked first: other versions may differ in everything else.
    if let Some(got) = header.get(MAGIC.len()..).and_then(<[u8]>::first_chunk) {
        let got = u16::from_le_bytes(*got);
        if got != VERSION {
            return Err(ShardError::Version { expected: VERSION, got });
        }
    }
    if length < (HEADER_BYTES + FOOTER_BYTES) as u64 || header.len() < HEADER_BYTES {
        return Err(ShardError::Truncated);
    }
    let footer_offset = length - FOOTER_BYTES as u64;
    let mut tail = vec![0; FOOTER_BYTES];
    input.seek(SeekFrom::Start(footer_offset))?;
    read_all(input, &mut tail)?;
    let footer = parse_footer(&tail);
    if footer.magic != END_MAGIC {
        return Err(ShardError::Truncated);
    }
    // Allocate memory for the index only if it fills the bytes between the blocks and the footer.
    let index_bytes = u64::from(footer.blocks) * ENTRY_BYTES as u64;
    if footer.index_offset.checked_add(index_bytes) != Some(footer_offset) {
        return Err(ShardError::DamagedIndex);
    }
    let mut index = vec![0; index_bytes as usize];
    input.seek(SeekFrom::Start(footer.index_offset))?;
    read_all(input, &mut index)?;
    if crc32(&[&header, &index, &tail[..20]]) != footer.crc32 {
        return Err(ShardError::DamagedIndex);
    }
    let mut outline = Outline::new(parse_header(&header[10..]));
    for entry in index.chunks_exact(ENTRY_BYTES).map(parse_entry) {
        let pushed = outline.push(entry.bytes, entry.raw_bytes, entry.records, entry.crc32);
        let is_valid = pushed.is_some()
            && outline.blocks.last() == Some(&entry)
            && entry.records > 0
            && entry.raw_bytes as usize <= MAX_BYTES;
        if !is_valid {
            return Err(ShardError::DamagedIndex);
        }
    }
    if (outline.index_offset, outline.records) != (footer.index_offset, footer.records) {
        return Err(ShardError::DamagedIndex);
    }
    Ok(outline)
}

/// Fills the buffer; an early end of the input is an error.
fn read_all(input: &mut impl Read, buffer: &mut [u8]) -> Result<(), ShardError> {
    input.read_exact(buffer).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => ShardError::Truncated,
        _ => ShardError::Io(error),
    })
}
