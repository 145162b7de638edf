//! Shards that are written, read back, and damaged at every position.

use std::cell::Cell;
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};

use beadwork_base::Control;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::format::{ENTRY_BYTES, FOOTER_BYTES, HEADER_BYTES};
use super::*;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Sample {
    number: u32,
    name: String,
    moves: Vec<i8>,
    cost: Option<f32>,
}

impl Record for Sample {
    const KIND: u16 = 900;
}

/// Another schema kind.
#[derive(Debug, Serialize, Deserialize)]
struct OtherKind(u32);

impl Record for OtherKind {
    const KIND: u16 = 901;
}

/// The same schema kind with other fields.
#[derive(Debug, Serialize, Deserialize)]
struct OtherFields(bool, u8);

impl Record for OtherFields {
    const KIND: u16 = 900;
}

const HEADER: ShardHeader =
    ShardHeader { kind: 900, shard: 3, fingerprint: 0x0123_4567_89ab_cdef, first_record: 1000 };

fn sample(number: u32) -> Sample {
    Sample {
        number,
        name: format!("sample {number}"),
        moves: (0..number % 7).map(|step| step as i8 - 3).collect(),
        cost: number.is_multiple_of(2).then_some(number as f32 / 3.0),
    }
}

fn samples(numbers: std::ops::Range<u32>) -> Vec<Sample> {
    numbers.map(sample).collect()
}

/// A shard of 12 samples in blocks of 5, 1 and 6.
fn small_shard() -> (Vec<u8>, ShardSummary) {
    write(&[samples(0..5), samples(5..6), samples(6..12)])
}

fn write(blocks: &[Vec<Sample>]) -> (Vec<u8>, ShardSummary) {
    let mut writer = ShardWriter::new(Vec::new(), HEADER).unwrap();
    for block in blocks {
        writer.block(&Block::pack(block, Block::DEFAULT_LEVEL).unwrap()).unwrap();
    }
    writer.finish().unwrap()
}

/// Opens, verifies and reads a shard; any damage must give an error.
fn read_all(bytes: &[u8]) -> Result<Vec<Sample>, ShardError> {
    let mut reader = ShardReader::open(Cursor::new(bytes))?;
    reader.verify(&Control::default())?;
    reader.records().collect()
}

fn footer_at(bytes: &[u8]) -> usize {
    bytes.len() - FOOTER_BYTES
}

#[test]
fn a_written_shard_reads_back() {
    let (bytes, summary) = small_shard();
    assert_eq!(
        (summary.blocks, summary.records, summary.bytes as usize, summary.sha256.len()),
        (3, 12, bytes.len(), 64)
    );
    let hash: Vec<_> = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(summary.sha256, hash.concat());

    let mut reader = ShardReader::open(Cursor::new(&bytes)).unwrap();
    assert_eq!((*reader.header(), reader.block_count(), reader.record_count()), (HEADER, 3, 12));
    assert_eq!(reader.read_block::<Sample>(2).unwrap(), samples(6..12));
    assert_eq!(reader.read_block::<Sample>(0).unwrap(), samples(0..5));
    assert_eq!(reader.verify(&Control::default()).unwrap(), summary);
    assert_eq!(reader.records().collect::<Result<Vec<Sample>, _>>().unwrap(), samples(0..12));
}

#[test]
fn a_block_knows_its_size() {
    let block = Block::pack(&samples(3..9), 1).unwrap();
    let raw = crate::codec::encode(&samples(3..9)).unwrap();
    assert_eq!((block.records(), block.raw_bytes() as usize), (6, raw.len()));
}

#[test]
fn a_shard_may_be_empty_but_a_block_may_not() {
    let (bytes, summary) = write(&[]);
    assert_eq!((bytes.len(), summary.raw_bytes), (HEADER_BYTES + FOOTER_BYTES, 0));
    assert_eq!(read_all(&bytes).unwrap(), []);
    assert!(matches!(Block::pack::<Sample>(&[], 1), Err(PackError::Empty)));
}

#[test]
fn the_layout_is_the_documented_one() {
    let (bytes, summary) = small_shard();
    let header = [
        0x89, 0x42, 0x57, 0x53, 0x0d, 0x0a, 0x1a, 0x0a, 1, 0, 0x84, 3, 3, 0, 0, 0, 0xef, 0xcd,
        0xab, 0x89, 0x67, 0x45, 0x23, 0x01, 0xe8, 3, 0, 0, 0, 0, 0, 0,
    ];
    assert_eq!(bytes[..HEADER_BYTES], header);
    let footer = footer_at(&bytes);
    let index = footer - 3 * ENTRY_BYTES;
    let number = |at: usize, len: usize| {
        bytes[at..at + len].iter().rev().fold(0, |n, &byte| n << 8 | usize::from(byte))
    };
    assert_eq!((number(footer, 8), number(footer + 8, 8), number(footer + 16, 4)), (index, 12, 3));
    let checked = [&bytes[..HEADER_BYTES], &bytes[index..footer + 20]].concat();
    assert_eq!(number(footer + 20, 4), crc32fast::hash(&checked) as usize);
    assert_eq!(&bytes[footer + 24..], b"BWS-end\n");

    let (mut at, mut first, mut raw) = (HEADER_BYTES, 1000, 0);
    for (block, records) in [5, 1, 6].into_iter().enumerate() {
        let entry = index + block * ENTRY_BYTES;
        assert_eq!(
            (number(entry, 8), number(entry + 8, 8), number(entry + 24, 4)),
            (at, first, records)
        );
        let frame = &bytes[at..at + number(entry + 16, 4)];
        assert_eq!(number(entry + 28, 4), crc32fast::hash(frame) as usize);
        let unpacked = zstd::bulk::decompress(frame, 1 << 20).unwrap();
        assert_eq!(unpacked.len(), number(entry + 20, 4));
        assert_eq!(
            usize::from(unpacked[0]),
            records,
            "a block is a `Vec`, which begins with its length"
        );
        (at, first, raw) = (at + frame.len(), first + records, raw + unpacked.len());
    }
    assert_eq!((at, raw as u64), (index, summary.raw_bytes));
}

#[test]
fn every_flipped_byte_is_found() {
    let (bytes, _) = small_shard();
    for at in 0..bytes.len() {
        for mask in [0x01, 0x80, 0xff] {
            let mut bad = bytes.clone();
            bad[at] ^= mask;
            let error = read_all(&bad).unwrap_err();
            let index = footer_at(&bytes) - 3 * ENTRY_BYTES;
            let right = match at {
                0..8 => matches!(error, ShardError::NotAShard),
                8..10 => matches!(error, ShardError::Version { expected: 1, .. }),
                _ if at >= bytes.len() - 8 => matches!(error, ShardError::Truncated),
                _ if at < HEADER_BYTES || at >= index => matches!(error, ShardError::DamagedIndex),
                _ => matches!(error, ShardError::DamagedBlock { .. }),
            };
            assert!(right, "byte {at} flipped by {mask:#x}: {error}");
        }
    }
}

#[test]
fn every_truncation_is_found() {
    let (bytes, _) = small_shard();
    for length in 0..bytes.len() {
        let error = read_all(&bytes[..length]).unwrap_err();
        assert!(matches!(error, ShardError::Truncated), "{length} bytes: {error}");
    }
}

#[test]
fn inserted_and_removed_bytes_are_found() {
    let (bytes, _) = small_shard();
    for at in 0..=bytes.len() {
        let longer = [&bytes[..at], &[0], &bytes[at..]].concat();
        assert!(read_all(&longer).is_err(), "byte inserted at {at}");
        if at < bytes.len() {
            let shorter = [&bytes[..at], &bytes[at + 1..]].concat();
            assert!(read_all(&shorter).is_err(), "byte {at} removed");
        }
    }
}

#[test]
fn a_damaged_block_leaves_the_others() {
    let (mut bytes, _) = small_shard();
    bytes[HEADER_BYTES + 3] ^= 4;
    let mut reader = ShardReader::open(Cursor::new(&bytes)).unwrap();
    let items: Vec<Result<Sample, _>> = reader.records().collect();
    assert!(matches!(items[0], Err(ShardError::DamagedBlock { block: 0 })));
    let rest: Vec<_> = items.into_iter().skip(1).map(Result::unwrap).collect();
    assert_eq!(rest, samples(5..12));
    assert!(matches!(
        reader.verify(&Control::default()),
        Err(ShardError::DamagedBlock { block: 0 })
    ));
}

#[test]
fn other_records_are_refused() {
    let (bytes, _) = small_shard();
    let mut reader = ShardReader::open(Cursor::new(&bytes)).unwrap();
    let error = reader.read_block::<OtherKind>(0).unwrap_err();
    assert!(matches!(error, ShardError::Kind { expected: 901, got: 900 }));
    assert_eq!(error.to_string(), "records have schema kind 900, expected 901");
    assert!(matches!(
        reader.read_block::<OtherFields>(1),
        Err(ShardError::Foreign { block: 1, .. })
    ));
}

/// Recomputes the checksum of header, index and footer, as a faulty or malicious writer would.
fn reseal(bytes: &mut [u8]) {
    let footer = footer_at(bytes);
    let index = u64::from_le_bytes(bytes[footer..footer + 8].try_into().unwrap()) as usize;
    let crc = crc32fast::hash(&[&bytes[..HEADER_BYTES], &bytes[index..footer + 20]].concat());
    bytes[footer + 20..footer + 24].copy_from_slice(&crc.to_le_bytes());
}

#[test]
fn a_wrong_index_with_a_valid_checksum_is_refused() {
    let (bytes, _) = small_shard();
    let footer = footer_at(&bytes);
    // All fields of the index, the number of the first record, and the number of records.
    // The position and the length of the index are left out: they determine the range that the
    // checksum covers.
    let fields = (footer - 3 * ENTRY_BYTES..footer).chain(24..32).chain(footer + 8..footer + 16);
    for at in fields {
        let mut bad = bytes.clone();
        bad[at] ^= 0x55;
        reseal(&mut bad);
        assert!(read_all(&bad).is_err(), "byte {at}");
    }
}

#[test]
fn huge_lengths_are_refused_before_allocation() {
    let (bytes, _) = small_shard();
    let footer = footer_at(&bytes);
    let mut many_blocks = bytes.clone();
    many_blocks[footer + 16..footer + 20].fill(0xff);
    assert!(matches!(read_all(&many_blocks), Err(ShardError::DamagedIndex)));
    let mut large_block = bytes;
    let raw_bytes = footer - ENTRY_BYTES + 20;
    large_block[raw_bytes..raw_bytes + 4].fill(0xff);
    reseal(&mut large_block);
    assert!(matches!(read_all(&large_block), Err(ShardError::DamagedIndex)));
}

/// A writer that takes `left` bytes, a few at a time, and then fails; or that fails to flush.
struct Failing {
    left: usize,
    flush_fails: bool,
}

impl Write for Failing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.left).min(7);
        self.left -= taken;
        if taken == 0 { Err(io::Error::from(io::ErrorKind::StorageFull)) } else { Ok(taken) }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.flush_fails { Err(io::Error::from(io::ErrorKind::StorageFull)) } else { Ok(()) }
    }
}

#[test]
fn every_failed_write_is_reported() {
    let (bytes, summary) = small_shard();
    let blocks = [samples(0..5), samples(5..6), samples(6..12)]
        .map(|block| Block::pack(&block, Block::DEFAULT_LEVEL).unwrap());
    let write = |left: usize, flush_fails: bool| {
        let mut writer = ShardWriter::new(Failing { left, flush_fails }, HEADER)?;
        blocks.iter().try_for_each(|block| writer.block(block))?;
        writer.finish()
    };
    for left in 0..bytes.len() {
        let error = write(left, false).map(|_| ()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull, "after {left} bytes");
    }
    assert!(write(bytes.len(), true).is_err());
    assert_eq!(write(bytes.len(), false).unwrap().1, summary);
}

/// An input that fails after `left` operations.
struct FailingInput<'a> {
    input: Cursor<&'a [u8]>,
    left: &'a Cell<u32>,
}

impl FailingInput<'_> {
    fn count(&self) -> io::Result<()> {
        let left = self.left.get().checked_sub(1).ok_or_else(|| io::Error::other("bad disk"))?;
        self.left.set(left);
        Ok(())
    }
}

impl Read for FailingInput<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.count()?;
        self.input.read(buffer)
    }
}

impl Seek for FailingInput<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.count()?;
        self.input.seek(to)
    }
}

#[test]
fn every_failed_read_is_reported() {
    let (bytes, _) = small_shard();
    for operations in 0.. {
        let left = Cell::new(operations);
        let read = ShardReader::open(FailingInput { input: Cursor::new(&bytes), left: &left })
            .and_then(|mut reader| reader.records::<Sample>().collect::<Result<Vec<_>, _>>());
        match read {
            Ok(records) => {
                assert_eq!(records, samples(0..12));
                assert!(operations > 10);
                break;
            }
            Err(error) => assert!(matches!(error, ShardError::Io(_)), "{error}"),
        }
    }
}

#[test]
#[should_panic(expected = "schema kind")]
fn a_block_of_another_kind_is_a_bug() {
    let mut writer = ShardWriter::new(Vec::new(), HEADER).unwrap();
    writer.block(&Block::pack(&[OtherKind(1)], 1).unwrap()).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_shape_is_read_back(sizes in prop::collection::vec(1_u32..40, 0..12), level in -5..12) {
        let mut writer = ShardWriter::new(Vec::new(), HEADER).unwrap();
        let mut next = 0;
        for &size in &sizes {
            writer.block(&Block::pack(&samples(next..next + size), level).unwrap()).unwrap();
            next += size;
        }
        let (bytes, summary) = writer.finish().unwrap();
        prop_assert_eq!((summary.blocks as usize, summary.records), (sizes.len(), u64::from(next)));
        prop_assert_eq!(read_all(&bytes).unwrap(), samples(0..next));
        let mut reader = ShardReader::open(Cursor::new(&bytes)).unwrap();
        prop_assert_eq!(reader.verify(&Control::default()).unwrap(), summary);
    }

    #[test]
    fn any_bytes_are_refused(start in 0_usize..40, noise: Vec<u8>) {
        let (bytes, _) = small_shard();
        prop_assert!(read_all(&[&bytes[..start], &noise].concat()).is_err());
        let with_footer = [&bytes[..start], &noise, &bytes[footer_at(&bytes)..]].concat();
        prop_assert!(read_all(&with_footer).is_err());
    }

    /// Damage that no checksum detects reaches the codec: it gives an error or other records, but
    /// never a panic.
    #[test]
    fn undetected_damage_does_not_panic(
        at: prop::sample::Index,
        noise in prop::collection::vec(any::<u8>(), 1..40),
    ) {
        let (mut bytes, _) = small_shard();
        let footer = footer_at(&bytes);
        let at = HEADER_BYTES + at.index(footer - HEADER_BYTES);
        for (byte, noise) in bytes[at..footer].iter_mut().zip(noise) {
            *byte = noise;
        }
        let mut offset = HEADER_BYTES;
        for entry in (0..3).map(|block| footer - (3 - block) * ENTRY_BYTES) {
            let length = bytes[entry + 16..entry + 20].try_into().unwrap();
            let length = u32::from_le_bytes(length) as usize;
            if let Some(frame) = bytes.get(offset..offset.saturating_add(length)) {
                let crc = crc32fast::hash(frame);
                bytes[entry + 28..entry + 32].copy_from_slice(&crc.to_le_bytes());
            }
            offset = offset.saturating_add(length);
        }
        reseal(&mut bytes);
        let _ = read_all(&bytes);
    }
}
