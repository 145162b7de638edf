//! Writes scalars in the event files of TensorBoard.
//!
//! A file is a sequence of records (TFRecord: length, masked checksum, bytes, masked checksum).
//! Each record is an `Event` message of TensorFlow's event.proto: its time, its step, and a summary
//! of named values.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Context;

/// A new event file in a folder.
pub(super) fn events_in(folder: &Path) -> anyhow::Result<Events<BufWriter<File>>> {
    // TensorBoard reads all files with `tfevents` in their names, in this order.
    let name = format!("events.out.tfevents.{:010}.beadwork", now() as u64);
    let file = OpenOptions::new().create(true).write(true).truncate(true).open(folder.join(name));
    let file = file.with_context(|| format!("cannot write to '{}'", folder.display()))?;
    Ok(Events::new(BufWriter::new(file), now())?)
}

/// Seconds since 1970-01-01.
pub(super) fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

/// An event file.
pub(super) struct Events<W> {
    out: W,
}

impl<W: Write> Events<W> {
    /// Starts a file by writing the version record, with which every file begins.
    /// `now` is in seconds since 1970.
    pub(super) fn new(out: W, now: f64) -> io::Result<Self> {
        let mut events = Self { out };
        let mut event = Message::default();
        event.double(1, now);
        event.bytes(3, b"brain.Event:2");
        events.record(&event.0)?;
        Ok(events)
    }

    /// Writes the values of one step.
    pub(super) fn write(&mut self, step: u64, scalars: &[(&str, f64)], now: f64) -> io::Result<()> {
        let mut summary = Message::default();
        for &(tag, value) in scalars {
            let mut scalar = Message::default();
            scalar.bytes(1, tag.as_bytes());
            scalar.float(2, value as f32);
            summary.bytes(1, &scalar.0);
        }
        let mut event = Message::default();
        event.double(1, now);
        event.whole(2, step);
        event.bytes(5, &summary.0);
        self.record(&event.0)
    }

    /// Flushes everything to the file.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    fn record(&mut self, bytes: &[u8]) -> io::Result<()> {
        let length = (bytes.len() as u64).to_le_bytes();
        self.out.write_all(&length)?;
        self.out.write_all(&masked_checksum(&length).to_le_bytes())?;
        self.out.write_all(bytes)?;
        self.out.write_all(&masked_checksum(bytes).to_le_bytes())
    }
}

/// The checksum of a TFRecord: masked, since records may themselves contain checksums.
fn masked_checksum(bytes: &[u8]) -> u32 {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(0xA282_EAD8)
}

/// A protocol buffers message.
#[derive(Default)]
struct Message(Vec<u8>);

impl Message {
    fn double(&mut self, field: u64, value: f64) {
        self.varint(field << 3 | 1);
        self.0.extend(value.to_le_bytes());
    }

    fn float(&mut self, field: u64, value: f32) {
        self.varint(field << 3 | 5);
        self.0.extend(value.to_le_bytes());
    }

    fn whole(&mut self, field: u64, value: u64) {
        self.varint(field << 3);
        self.varint(value);
    }

    fn bytes(&mut self, field: u64, bytes: &[u8]) {
        self.varint(field << 3 | 2);
        self.varint(bytes.len() as u64);
        self.0.extend(bytes);
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a panic fails the test")]

    use super::*;

    /// The bytes of TensorFlow's own writer, except the checksums, which have their own test
    /// vector.
    #[test]
    fn a_step_is_written_as_an_event() {
        let mut bytes = Vec::new();
        let mut events = Events::new(&mut bytes, 1.0).unwrap();
        events.write(300, &[("a", 0.5)], 2.0).unwrap();
        let first = 8 + 4 + 9 + 15 + 4;
        assert_eq!(bytes[..8], 24_u64.to_le_bytes());
        assert_eq!(&bytes[8 + 4 + 9 + 2..first - 4], b"brain.Event:2");
        let second = &bytes[first + 12..bytes.len() - 4];
        let expected = [
            &[0x09][..],
            &2.0_f64.to_le_bytes(),
            &[0x10, 0xAC, 0x02, 0x2A, 0x0A, 0x0A, 0x08, 0x0A, 0x01, b'a', 0x15],
            &0.5_f32.to_le_bytes(),
        ];
        assert_eq!(second, expected.concat());
    }

    #[test]
    fn checksums_are_those_of_crc_32c_masked() {
        // RFC 3720, section B.4: 32 bytes of zeros.
        assert_eq!(crc32c::crc32c(&[0; 32]), 0x8A91_36AA);
        assert_eq!(
            masked_checksum(&[0; 32]),
            0x8A91_36AA_u32.rotate_right(15).wrapping_add(0xA282_EAD8)
        );
    }
}
