//! The fixed parts of a shard: header, index and footer.

use std::fmt::Write;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

pub(crate) const MAGIC: [u8; 8] = *b"\x89BWS\r\n\x1a\n";
pub(crate) const END_MAGIC: [u8; 8] = *b"BWS-end\n";
pub(crate) const VERSION: u16 = 1;
pub(crate) const HEADER_BYTES: usize = 32;
pub(crate) const ENTRY_BYTES: usize = 32;
pub(crate) const FOOTER_BYTES: usize = 32;

/// A type whose values can be stored in shards.
pub trait Record: Serialize + DeserializeOwned {
    /// Number of the schema, stored in the shard's header.
    /// Fields have no names on disk, so a change to the fields needs a new number.
    const KIND: u16;
}

/// The header of a shard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShardHeader {
    /// [`Record::KIND`] of its records; 1 is trajectories.
    pub kind: u16,
    /// Number of the shard in the dataset, from 0.
    pub shard: u32,
    /// Fingerprint of the resolved configuration, the same in all shards of a dataset.
    pub fingerprint: u64,
    /// Number of its first record in the dataset, from 0.
    pub first_record: u64,
}

/// Counts, lengths and hash of a shard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardSummary {
    /// Number of blocks.
    pub blocks: u32,
    /// Number of records.
    pub records: u64,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Length of its blocks before compression, in bytes.
    pub raw_bytes: u64,
    /// SHA-256 of the file, in lower-case hexadecimal.
    pub sha256: String,
}

/// An entry of the index: position, lengths, records and checksum of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockEntry {
    pub(crate) offset: u64,
    pub(crate) first_record: u64,
    pub(crate) bytes: u32,
    pub(crate) raw_bytes: u32,
    pub(crate) records: u32,
    pub(crate) crc32: u32,
}

/// Header and index of a shard.
///
/// Invariant: the first block follows the header, and each block follows the previous one without a
/// gap, in the file and in the numbers of its records.
/// The fields determine all bytes of header, index and footer, so a reader can hash the file
/// without reading these parts again.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(crate) header: ShardHeader,
    pub(crate) blocks: Vec<BlockEntry>,
    /// Offset of the index, where the blocks end.
    pub(crate) index_offset: u64,
    pub(crate) records: u64,
}

/// The fields of a footer as read, not checked.
pub(crate) struct Footer {
    pub(crate) index_offset: u64,
    pub(crate) records: u64,
    pub(crate) blocks: u32,
    pub(crate) crc32: u32,
    pub(crate) magic: [u8; 8],
}

impl Outline {
    pub(crate) fn new(header: ShardHeader) -> Self {
        Self { header, blocks: Vec::new(), index_offset: HEADER_BYTES as u64, records: 0 }
    }

    /// Appends a block.
    /// Returns `None` and changes nothing if a number would overflow.
    pub(crate) fn push(
        &mut self,
        bytes: u32,
        raw_bytes: u32,
        records: u32,
        crc32: u32,
    ) -> Option<()> {
        let first_record = self.header.first_record.checked_add(self.records)?;
        first_record.checked_add(u64::from(records))?;
        let index_offset = self.index_offset.checked_add(u64::from(bytes))?;
        u32::try_from(self.blocks.len() + 1).ok()?;
        let offset = self.index_offset;
        self.blocks.push(BlockEntry { offset, first_record, bytes, raw_bytes, records, crc32 });
        self.index_offset = index_offset;
        self.records += u64::from(records);
        Some(())
    }

    pub(crate) fn header_bytes(&self) -> Vec<u8> {
        let header = &self.header;
        let mut bytes = Vec::with_capacity(HEADER_BYTES);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(header.kind.to_le_bytes());
        bytes.extend(header.shard.to_le_bytes());
        bytes.extend(header.fingerprint.to_le_bytes());
        bytes.extend(header.first_record.to_le_bytes());
        bytes
    }

    /// The bytes of index and footer.
    pub(crate) fn tail_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.blocks.len() * ENTRY_BYTES + FOOTER_BYTES);
        for block in &self.blocks {
            bytes.extend(block.offset.to_le_bytes());
            bytes.extend(block.first_record.to_le_bytes());
            bytes.extend(block.bytes.to_le_bytes());
            bytes.extend(block.raw_bytes.to_le_bytes());
            bytes.extend(block.records.to_le_bytes());
            bytes.extend(block.crc32.to_le_bytes());
        }
        bytes.extend(self.index_offset.to_le_bytes());
        bytes.extend(self.records.to_le_bytes());
        bytes.extend((self.blocks.len() as u32).to_le_bytes());
        bytes.extend(crc32(&[&self.header_bytes(), &bytes]).to_le_bytes());
        bytes.extend(END_MAGIC);
        bytes
    }

    pub(crate) fn raw_bytes(&self) -> u64 {
        self.blocks.iter().map(|block| u64::from(block.raw_bytes)).sum()
    }

    /// Length of the whole file in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.index_offset + (self.blocks.len() * ENTRY_BYTES + FOOTER_BYTES) as u64
    }

    /// The summary of the shard; `hasher` has hashed all bytes before the index.
    pub(crate) fn summary(&self, hasher: Sha256) -> ShardSummary {
        let sha256 = hex(&hasher.chain_update(self.tail_bytes()).finalize());
        ShardSummary {
            blocks: self.blocks.len() as u32,
            records: self.records,
            bytes: self.bytes(),
            raw_bytes: self.raw_bytes(),
            sha256,
        }
    }
}

/// Bytes as lower-case hexadecimal, as checksum tools print them.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut digits, byte| {
        write!(digits, "{byte:02x}").expect("writing to a string does not fail");
        digits
    })
}

/// CRC-32 of the concatenated parts, with the polynomial of zip and PNG.
pub(crate) fn crc32(parts: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    parts.iter().for_each(|part| hasher.update(part));
    hasher.finalize()
}

/// Parses the fields of a header after magic and version.
pub(crate) fn parse_header(mut bytes: &[u8]) -> ShardHeader {
    ShardHeader {
        kind: u16::from_le_bytes(take(&mut bytes)),
        shard: u32::from_le_bytes(take(&mut bytes)),
        fingerprint: u64::from_le_bytes(take(&mut bytes)),
        first_record: u64::from_le_bytes(take(&mut bytes)),
    }
}

pub(crate) fn parse_entry(mut bytes: &[u8]) -> BlockEntry {
    BlockEntry {
        offset: u64::from_le_bytes(take(&mut bytes)),
        first_record: u64::from_le_bytes(take(&mut bytes)),
        bytes: u32::from_le_bytes(take(&mut bytes)),
        raw_bytes: u32::from_le_bytes(take(&mut bytes)),
        records: u32::from_le_bytes(take(&mut bytes)),
        crc32: u32::from_le_bytes(take(&mut bytes)),
    }
}

pub(crate) fn parse_footer(mut bytes: &[u8]) -> Footer {
    Footer {
        index_offset: u64::from_le_bytes(take(&mut bytes)),
        records: u64::from_le_bytes(take(&mut bytes)),
        blocks: u32::from_le_bytes(take(&mut bytes)),
        crc32: u32::from_le_bytes(take(&mut bytes)),
        magic: take(&mut bytes),
    }
}

/// Removes and returns the first `N` bytes; callers pass parts whose fixed lengths cover all
/// fields.
fn take<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
    let (first, rest) = bytes.split_first_chunk().expect("the parts have fixed lengths");
    *bytes = rest;
    *first
}
