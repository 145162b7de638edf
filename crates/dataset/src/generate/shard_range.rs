//! A range of a dataset's shards, for runs that share the work.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use thiserror::Error;

/// One of several contiguous ranges that a dataset's shards are divided into; their sizes differ by
/// at most one shard.
/// Written "2/5": the second of five.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShardRange {
    /// Number of the range, from 1.
    part: u32,
    /// Number of ranges.
    parts: u32,
}

/// A text is not a [`ShardRange`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("invalid shard range '{0}': expected I/N with I from 1 to N, such as 2/5")]
pub struct ShardRangeError(pub String);

impl ShardRange {
    /// All shards, "1/1".
    pub const ALL: Self = Self { part: 1, parts: 1 };

    /// The numbers of the range's shards in a dataset of `count` shards.
    pub fn shards(self, count: u32) -> Range<u32> {
        let end_of =
            |part: u32| (u64::from(count) * u64::from(part) / u64::from(self.parts)) as u32;
        end_of(self.part - 1)..end_of(self.part)
    }
}

impl Default for ShardRange {
    fn default() -> Self {
        Self::ALL
    }
}

impl FromStr for ShardRange {
    type Err = ShardRangeError;

    fn from_str(text: &str) -> Result<Self, ShardRangeError> {
        let range = text.split_once('/').and_then(|(part, parts)| {
            let (part, parts) = (part.parse().ok()?, parts.parse().ok()?);
            (1..=parts).contains(&part).then_some(Self { part, parts })
        });
        range.ok_or_else(|| ShardRangeError(text.to_owned()))
    }
}

impl fmt::Display for ShardRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.parts)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn shard_ranges_are_read_and_refused() {
        assert_eq!("1/1".parse(), Ok(ShardRange::ALL));
        assert_eq!("2/5".parse::<ShardRange>().unwrap().to_string(), "2/5");
        for text in ["0/2", "3/2", "1/0", "1", "a/b", "1/2/3", "-1/2"] {
            assert_eq!(text.parse::<ShardRange>(), Err(ShardRangeError(text.to_owned())));
        }
        let covered: Vec<u32> =
            (1..=4).flat_map(|part| ShardRange { part, parts: 4 }.shards(10)).collect();
        assert_eq!(covered, (0..10).collect::<Vec<_>>());
    }
}
