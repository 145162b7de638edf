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

/// What a shard can hold.
pub trait Record: Serialize + DeserializeOwned {
    /// Number of the schema in a shard's header.
    /// A change to the fields needs a new one, for they have no names on disk.
    const KIND: u16;
}

/// What the header of a shard says about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShardHeader {
    /// The [`Record::KIND`] of its records; 1 stands for trajectories.
    pub kind: u16,
    /// Its number in the dataset, from 0.
    pub shard: u32,
    /// Fingerprint of the configuration it was made from: shards of one dataset have the same.
    pub fingerprint: u64,
    /// Number of its first record in the dataset, from 0.
    pub first_record: u64,
}

/// What a shard holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardSummary {
    /// Number of blocks.
    pub blocks: u32,
    /// Number of records.
    pub records: u64,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Length in bytes of its blocks before compression.
    pub raw_bytes: u64,
    /// SHA-256 of the file, in lower-case hexadecimal digits.
    pub sha256: String,
}

/// Where a block is and what it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockEntry {
    pub(crate) offset: u64,
    pub(crate) first_record: u64,
    pub(crate) bytes: u32,
    pub(crate) raw_bytes: u32,
    pub(crate) records: u32,
    pub(crate) crc32: u32,
}

/// Everything in a shard but its blocks.
///
/// Invariant: the blocks follow each other without a gap, from the end of the header on, and so do
/// their records.
/// The bytes follow from the fields, so a reader can hash a file without reading these parts again.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(crate) header: ShardHeader,
    pub(crate) blocks: Vec<BlockEntry>,
    /// Where the blocks end and the index begins.
    pub(crate) index_offset: u64,
    pub(crate) records: u64,
}

/// The fields of a footer, as read.
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

    /// Appends a block; `None` when a number would overflow, which changes nothing.
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

    /// Index and footer.
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

    /// Length of the whole file.
    pub(crate) fn bytes(&self) -> u64 {
        self.index_offset + (self.blocks.len() * ENTRY_BYTES + FOOTER_BYTES) as u64
    }

    /// The summary, given the hash of all bytes before the index.
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

/// Bytes as lower-case hexadecimal digits, as checksum tools print them.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut digits, byte| {
        write!(digits, "{byte:02x}").expect("a string takes all text");
        digits
    })
}

/// CRC-32 (of the polynomial that zip and PNG use) of some parts, end to end.
pub(crate) fn crc32(parts: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    parts.iter().for_each(|part| hasher.update(part));
    hasher.finalize()
}

/// The header's fields, after the magic and the version.
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

/// Cuts the first bytes off; callers hand in whole parts, whose lengths are constants.
fn take<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
    let (first, rest) = bytes.split_first_chunk().expect("the parts have fixed lengths");
    *bytes = rest;
    *first
}
