//! Random numbers of the searches.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// A random number below `count`, which must be positive.
#[inline]
pub(crate) fn below(rng: &mut Xoshiro256PlusPlus, count: usize) -> usize {
    scale(rng.next_u64(), count)
}

/// Maps 64 random bits to a number below `count`, using their upper half.
///
/// The relative error of each probability is at most `count` / 2^32, which does not matter to a
/// search.
#[inline]
pub(crate) fn scale(random: u64, count: usize) -> usize {
    (((random >> 32) * count as u64) >> 32) as usize
}

/// A random number in 0..1 with 53 bits.
#[inline]
pub(crate) fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
