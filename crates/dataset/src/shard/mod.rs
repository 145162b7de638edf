//! Shards: files of records of one schema, in blocks that are compressed and checksummed
//! separately.
//!
//! # Layout
//! All numbers are little endian.
//! The file has no other bytes.
//!
//! | part   | at | bytes | content                                                            |
//! |--------|---:|------:|--------------------------------------------------------------------|
//! | header |  0 |     8 | magic `89 42 57 53 0d 0a 1a 0a`; line-end conversion breaks it     |
//! |        |  8 |     2 | format version, 1                                                  |
//! |        | 10 |     2 | schema kind, [`Record::KIND`]                                      |
//! |        | 12 |     4 | shard number                                                       |
//! |        | 16 |     8 | fingerprint of the configuration                                   |
//! |        | 24 |     8 | number of the first record                                         |
//! | blocks | 32 |     - | consecutive zstd frames, each an encoded `Vec` of records          |
//! | index  |  0 |     8 | for each block: offset in the file                                 |
//! |        |  8 |     8 | number of its first record                                         |
//! |        | 16 |     4 | compressed length in bytes                                         |
//! |        | 20 |     4 | uncompressed length in bytes                                       |
//! |        | 24 |     4 | records, at least 1                                                |
//! |        | 28 |     4 | CRC-32 of the compressed bytes                                     |
//! | footer |  0 |     8 | offset of the index in the file                                    |
//! |        |  8 |     8 | records in the shard                                               |
//! |        | 16 |     4 | blocks                                                             |
//! |        | 20 |     4 | CRC-32 of the header, the index and the 20 bytes before this       |
//! |        | 24 |     8 | magic `42 57 53 2d 65 6e 64 0a`, "BWS-end" and a line end          |
//!
//! Records are numbered through the whole dataset: the first record of a shard follows the last one
//! of the previous shard.
//! Fields have no names on disk, so a change to a record's fields needs a new schema kind.

mod format;
mod reader;
mod writer;

pub(crate) use format::hex;
pub use format::{Record, ShardHeader, ShardSummary};
pub(crate) use reader::flatten_blocks;
pub use reader::{ShardError, ShardReader};
pub use writer::{Block, PackError, ShardWriter};

#[cfg(test)]
mod tests;
