//! Numbers drawn by the searches.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// A number below `count`, which must be positive.
#[inline]
pub(crate) fn below(rng: &mut Xoshiro256PlusPlus, count: usize) -> usize {
    scale(rng.next_u64(), count)
}

/// A number below `count` from the upper half of 64 random bits; its bias, below 2^-32 times
/// `count`, does not matter to a search.
#[inline]
pub(crate) fn scale(random: u64, count: usize) -> usize {
    (((random >> 32) * count as u64) >> 32) as usize
}

/// A number in 0..1 of 53 random bits.
#[inline]
pub(crate) fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
