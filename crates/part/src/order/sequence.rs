//! Orders of n things, whatever they are.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// An order of n things that have numbers 0 to n - 1, for every n.
///
/// The things may be the lines of a layer (see [`LineOrder`](super::LineOrder)), the infill lines
/// of a slicer, or beads.
/// Things with consecutive numbers are assumed to be neighbours.
///
/// | Name | Order |
/// |---|---|
/// | `sequential` | 0, 1, 2, ... |
/// | `interleaved-K` | every K-th thing: 0, K, 2K, ..., then 1, K + 1, ..., up to K - 1, 2K - 1, ... |
/// | `scattered-K` | the same with the offsets 0 to K - 1 in golden order |
/// | `golden` | all things in golden order |
/// | `bit-reversed` | 0, then the middle, then the quarters, then the eighths, ... |
///
/// The **golden order** of n things places n positions on a circle of length 1: with the golden
/// ratio φ = (√5 - 1) / 2, position i from 0 to n - 1 is the fractional part of i φ.
/// The i-th thing of the order is the one whose number is the rank of position i among the sorted
/// positions; for n = 7 the order is 0, 4, 2, 6, 3, 1, 5 as a result.
/// Each position falls into one of the largest gaps between those before it, so each thing is far
/// from all things before it, also across the end of the circle.
/// Of the first m of K offsets, no two are closer than 3/8 of K / m, for every stride.
///
/// The **bit-reversed order** sorts the numbers by their bits read in reverse, with as many bits as
/// n - 1 has; 0, 4, 2, 6, 1, 5, 3, 7 is that of 8 things.
/// All even numbers come before the odd ones.
///
/// A stride K of n or more acts like n: `interleaved-K` is then `sequential`, and `scattered-K` is
/// `golden`.
/// With K = 1 both are `sequential`.
///
/// # Example
/// ```
/// use beadwork_part::Sequence;
///
/// let sequence: Sequence = "interleaved-3".parse()?;
/// assert_eq!(sequence.order(8), [0, 3, 6, 1, 4, 7, 2, 5]);
/// let sequence: Sequence = "scattered-4".parse()?;
/// assert_eq!(sequence.order(8), [0, 4, 2, 6, 1, 5, 3, 7]);
/// assert_eq!(Sequence::Golden.order(5), [0, 3, 1, 4, 2]);
/// assert_eq!(sequence.to_string(), "scattered-4");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Sequence {
    /// In ascending order.
    Sequential,
    /// Every K-th thing, offset by offset, in ascending order of the offsets.
    Interleaved(Stride),
    /// Every K-th thing, offset by offset, in golden order of the offsets.
    Scattered(Stride),
    /// All things in golden order.
    Golden,
    /// All things sorted by their reversed bits.
    BitReversed,
}

/// Distance of the things that follow one another in [`Sequence::Interleaved`] and
/// [`Sequence::Scattered`]: 1 to [`Stride::MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Stride(u32);

/// The error of a stride that is 0 or above [`Stride::MAX`].
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("invalid stride {0}: expected 1 to {max}", max = Stride::MAX)]
pub struct InvalidStride(pub u32);

impl Stride {
    /// Maximum stride; the side of a layer has no more cells.
    pub const MAX: u32 = beadwork_grid::Region::MAX_SIDE;

    /// A stride of `k` things.
    ///
    /// # Errors
    /// If `k` is 0 or above [`Stride::MAX`].
    pub fn new(k: u32) -> Result<Self, InvalidStride> {
        if (1..=Self::MAX).contains(&k) { Ok(Self(k)) } else { Err(InvalidStride(k)) }
    }

    /// Number of things, 1 to [`Stride::MAX`].
    pub fn get(self) -> u32 {
        self.0
    }
}

/// The error of parsing a name that no [`Sequence`] has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SequenceError {
    /// No family of sequences has the name.
    #[error(
        "unknown sequence '{0}': expected sequential, interleaved-K, scattered-K, golden or \
         bit-reversed, such as scattered-7"
    )]
    Unknown(String),
    /// The family needs a stride, which is missing or invalid.
    #[error(
        "invalid sequence '{name}': expected {family}-K with a stride K from 1 to {max}, such as \
         {family}-7",
        max = Stride::MAX
    )]
    Stride {
        /// The invalid name.
        name: String,
        /// Family of the sequence: "interleaved" or "scattered".
        family: &'static str,
    },
}

impl Sequence {
    /// Returns each number from 0 to `n` - 1 once, in the order of the sequence.
    ///
    /// Takes O(n); O(n log n) for [`Sequence::Golden`] and large strides of
    /// [`Sequence::Scattered`].
    pub fn order(self, n: usize) -> Vec<usize> {
        match self {
            Self::Sequential => (0..n).collect(),
            Self::Interleaved(stride) => every(n, 0..n.min(stride.0 as usize)),
            Self::Scattered(stride) => every(n, golden(n.min(stride.0 as usize)).into_iter()),
            Self::Golden => golden(n),
            Self::BitReversed => bit_reversed(n),
        }
    }
}

/// For each offset in turn, the numbers below `n` that are congruent to it modulo the number of
/// offsets.
fn every(n: usize, offsets: impl ExactSizeIterator<Item = usize>) -> Vec<usize> {
    // Without offsets, if n is 0, the stride does not matter, but `step_by` refuses 0.
    let stride = offsets.len().max(1);
    offsets.flat_map(|offset| (offset..n).step_by(stride)).collect()
}

fn golden(n: usize) -> Vec<usize> {
    /// The golden ratio's fractional part as a multiple of 2^-64, rounded down.
    ///
    /// Rounding moves position i by less than i / 2^64, and the n positions are at least 1 / (3 n)
    /// apart, so ranks are exact for n up to 2^31.
    /// The multiplier is odd, so positions of all u64 are distinct.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut sorted: Vec<(u64, usize)> =
        (0..n).map(|i| (GOLDEN.wrapping_mul(i as u64), i)).collect();
    sorted.sort_unstable();
    let mut order = vec![0; n];
    for (rank, (_, i)) in sorted.into_iter().enumerate() {
        order[i] = rank;
    }
    order
}

fn bit_reversed(n: usize) -> Vec<usize> {
    let Some(last) = n.checked_sub(1) else { return Vec::new() };
    let bits = usize::BITS - last.leading_zeros();
    // Reversing twice gives the number itself, so counting through the reversed numbers sorts.
    let reversed = |i: usize| if bits == 0 { 0 } else { i.reverse_bits() >> (usize::BITS - bits) };
    (0..1 << bits).map(reversed).filter(|&number| number < n).collect()
}

const INTERLEAVED: &str = "interleaved";
const SCATTERED: &str = "scattered";

impl fmt::Display for Sequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sequential => f.pad("sequential"),
            Self::Interleaved(stride) => f.pad(&format!("{INTERLEAVED}-{}", stride.0)),
            Self::Scattered(stride) => f.pad(&format!("{SCATTERED}-{}", stride.0)),
            Self::Golden => f.pad("golden"),
            Self::BitReversed => f.pad("bit-reversed"),
        }
    }
}

impl FromStr for Sequence {
    type Err = SequenceError;

    fn from_str(name: &str) -> Result<Self, SequenceError> {
        match name {
            "sequential" => return Ok(Self::Sequential),
            "golden" => return Ok(Self::Golden),
            "bit-reversed" => return Ok(Self::BitReversed),
            _ => {}
        }
        let (family, stride) = name.split_once('-').unwrap_or((name, ""));
        let (family, sequence): (_, fn(Stride) -> Self) = match family {
            INTERLEAVED => (INTERLEAVED, Self::Interleaved),
            SCATTERED => (SCATTERED, Self::Scattered),
            _ => return Err(SequenceError::Unknown(name.to_owned())),
        };
        stride
            .parse()
            .ok()
            .and_then(|k| Stride::new(k).ok())
            .map(sequence)
            // A sequence has one name only, without "+" or leading zeros.
            .filter(|sequence| sequence.to_string() == name)
            .ok_or_else(|| SequenceError::Stride { name: name.to_owned(), family })
    }
}
